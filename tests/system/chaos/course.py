"""How a ground's trains run when nothing fails: when they move, and which events a fault may wait for."""

from dataclasses import dataclass

import numpy as np

from network.clock import clock
from onboard.notes import Arrived, Departs, Holds, MissionBegun
from radio.noted import Sent
from simulation.events import Entered, JournalEntry, PointsLocked, PointsMoving, TagPassed, unit_of
from simulation.faults.script import matcher_of
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from wayside.said import PointsCommanded


@dataclass(frozen=True, slots=True)
class Course:
    """An undisturbed run. `moving_s`: whole seconds at which any train moves; `events`: (time, words), first of its
    words; `uses`: (time, what is used then): units, devices, points, tags; `stopped_s`: time that trains stood between
    their first and last movement.
    """

    moving_s: tuple[int, ...]
    events: tuple[tuple[float, str], ...]
    uses: tuple[tuple[float, str], ...]
    stopped_s: float


def course_of(result: RunResult) -> Course:
    """What a run shows."""
    trace = result.trace
    moving = np.unique(trace["step"][trace["speed_mps"] > 0.0] // STEPS_PER_S)
    events: dict[str, float] = {}
    train_of: dict[str, str] = {}
    for entry in result.journal.entries:
        if isinstance(entry.event, MissionBegun):
            train_of[entry.who] = entry.event.train
        words = words_of(entry, train_of)
        if words is not None:
            events.setdefault(words, entry.t_s)
    uses = tuple((e.t_s, name) for e in result.journal.entries for name in used_by(e))
    firsts = tuple((t_s, words) for words, t_s in events.items())
    return Course(tuple(int(s) for s in moving), firsts, uses, stopped_s(result))


def used_by(entry: JournalEntry) -> tuple[str, ...]:
    """What an entry shows to be in use."""
    match entry.event:
        case Sent(source=source, receiver=receiver):
            return source, receiver
        case TagPassed(tag_id=tag_id):
            return (str(tag_id),)
        case PointsCommanded(points_id=points_id):
            return (points_id,)
        case _:
            return ()


def words_of(entry: JournalEntry, train_of: dict[str, str]) -> str | None:
    """The words of a drill file that name this entry; None where there are none."""
    event, train = entry.event, train_of.get(unit_of(entry))
    match event:
        case TagPassed() if train is not None:
            words = f"train {train} passes tag {event.tag_id}"
        case Departs() if train is not None:
            words = f"train {train} departs {event.station}"
        case Arrived() if train is not None:
            words = f"train {train} arrives {event.station}"
        case Holds() if train is not None and event.section_ids:
            words = f"train {train} holds {event.section_ids[-1]}"
        case Entered():
            words = f"train {event.train} enters"
        case PointsMoving():
            words = f"points {event.points_id} move"
        case PointsLocked():
            words = f"points {event.points_id} lock"
        case _:
            return None
    return words if matcher_of(words) is not None else None


def stopped_s(result: RunResult) -> float:
    """For how long all trains together stood between their first and their last movement, s."""
    total_steps = 0
    trace = result.trace
    for slot in range(len(result.stock_ids)):
        mine = trace[trace["slot"] == slot]
        moves = np.flatnonzero(mine["speed_mps"] > 0.0)
        if moves.size == 0:
            continue
        between = mine[moves[0] : moves[-1] + 1]
        steps, stands = between["step"], between["speed_mps"] <= 0.0
        total_steps += int(np.sum(np.diff(steps)[stands[:-1]]))
    return total_steps / STEPS_PER_S


def clock_tenths(t_s: float) -> str:
    """HH:MM:SS.d, as a drill file has it."""
    tenths = round(t_s * STEPS_PER_S)
    return f"{clock(tenths // STEPS_PER_S)}.{tenths % STEPS_PER_S}"
