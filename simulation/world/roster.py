"""Which train set runs which train from where: missions drawn up from the timetable before the run (運用)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Final

from network.graph import routes_from
from network.model import Line, SectionKind, TagPurpose
from network.timetable import AtPortal, BecomesTrain, Call, FromTrain, Stabled, Timetable, TimetableTrain
from onboard.mission import Mission, NoWay, on_tracks, plan_mission
from simulation.late.entry import entry_late_s
from simulation.setup import Setup

OPENING_S: Final = 600.0  # the run begins this long before the first thing planned
PORTAL_STAND_M = 40.0  # a train enters with its rear this far inside the portal's outer end, at most


@dataclass(frozen=True, slots=True)
class Duty:
    """One train of one stock: how it comes to be there and what becomes of it."""

    stock_id: str
    train: TimetableTrain
    mission: Mission
    enters: bool  # comes in by a portal, `enter_s` is when it stands there
    enter_s: float
    leaves: bool
    becomes: str | None  # the next train of a set that stays on the line, at once or after a rest
    late_s: float = 0.0  # by how much later than planned it comes to its portal

    @property
    def comes_s(self) -> float:
        """When it stands before its portal, s; `enter_s` is when it should."""
        return self.enter_s + self.late_s


def begins_s(duties: Iterable[Duty]) -> float:
    """When a run of these duties begins, s, on a whole minute."""
    return math.floor((min((duty.enter_s for duty in duties), default=0.0) - OPENING_S) / 60.0) * 60.0


def drawn_up(setup: Setup, line: Line) -> dict[str, tuple[Duty, ...]]:
    """Duties of a setup's day on its line, or on the one that its units believe in. Raises as `draw_up` does."""
    duties = draw_up(line, setup.timetable, setup.lengths_m, setup.operation.portal_lead_s)
    if not setup.late.entry:
        return duties
    late_s = {
        number: entry_late_s(setup.late, setup.seed, setup.today, train)
        for number, train in setup.timetable.trains.items()
    }
    return {
        stock_id: tuple(replace(duty, late_s=late_s[duty.train.number]) for duty in drawn)
        for stock_id, drawn in duties.items()
    }


def draw_up(
    line: Line, timetable: Timetable, train_lengths_m: dict[str, float], portal_lead_s: float
) -> dict[str, tuple[Duty, ...]]:
    """Duties of each stock id in order. Raises `onboard.mission.NoWay` where the line has no route for a train."""
    duties: dict[str, tuple[Duty, ...]] = {}
    for diagram in timetable.diagrams:
        drawn: list[Duty] = []
        for number, following in zip_longest(diagram.train_numbers, diagram.train_numbers[1:]):
            stands_in = drawn[-1].mission.spans[-1].section_id if drawn and not drawn[-1].leaves else None
            train = timetable.trains[number]
            length_m = train_lengths_m[diagram.stock_id]
            duty = _duty(line, train, diagram.stock_id, length_m, portal_lead_s, stands_in)
            drawn.append(duty if duty.leaves else replace(duty, becomes=following))
        duties[diagram.stock_id] = tuple(drawn)
    return duties


def _duty(
    line: Line,
    train: TimetableTrain,
    stock_id: str,
    length_m: float,
    portal_lead_s: float,
    stands_in: str | None,
) -> Duty:
    """One duty; a train starts where its set stands since the one before, `stands_in`, stabled or turning back."""
    enters = isinstance(train.begins, AtPortal)
    if isinstance(train.begins, AtPortal):
        start = train.begins.section_id
    elif stands_in is not None:
        start = stands_in
    else:
        start = first_section(line, train)
    leave_by = train.ends.section_id if isinstance(train.ends, AtPortal) else None
    enter_mark_m = portal_mark_m(line, train, start, length_m) if enters else None
    mission = plan_mission(line, train, start, leave_by, enter_mark_m)
    enter_s = train.calls[0].first_s - portal_lead_s if enters else train.calls[0].first_s
    return Duty(stock_id, train, mission, enters, enter_s, leaves=leave_by is not None, becomes=None)


def by_route(line: Line, duty: Duty, route_id: str, instead: str, length_m: float) -> Duty:
    """The same duty with another route for one of its own, to another track of that station. NoWay if there is none."""
    mission = duty.mission
    at = next((i for i, route in enumerate(mission.routes) if route.id == route_id), None)
    if at is None:
        raise NoWay(f"train {duty.train.number} has no route {route_id}")
    old = mission.routes[at]
    new = next((r for r in routes_from(line, old.from_section, old.direction) if r.id == instead), None)
    station_id = line.sections[old.to_section].station_id
    track = None if new is None else line.sections[new.to_section].track
    if new is None or track is None or station_id is None:
        raise NoWay(f"train {duty.train.number} has no way by {instead}")
    changed = on_tracks(duty.train, mission.tracks | {station_id: track})
    found = _by_tracks(line, duty, changed, mission.spans[0].section_id, length_m)
    if [r.id for r in found.mission.routes[: at + 1]] != [*(r.id for r in mission.routes[:at]), instead]:
        raise NoWay(f"train {duty.train.number} does not come by {instead} where it is to go")
    return found


def from_section(line: Line, duty: Duty, start: str, length_m: float) -> Duty:
    """The same duty from another track of its first station. NoWay where it has no way from there."""
    first, track = duty.train.calls[0].station_id, line.sections[start].track
    if track is None or line.sections[start].station_id != first:
        raise NoWay(f"train {duty.train.number} does not begin at {start}")
    return _by_tracks(
        line, duty, on_tracks(duty.train, duty.mission.tracks | {first: track}), start, length_m
    )


def ending_at(line: Line, duty: Duty, at: int, next_train: str, length_m: float) -> Duty:
    """The same duty to its target of that index and no further (途中折返し). NoWay where it is no station."""
    kept = _calls_until(duty.train, duty.mission.targets[at].station_id)
    train = replace(duty.train, calls=kept, ends=BecomesTrain(next_train))
    tracks = on_tracks(train, duty.mission.tracks)
    ended = _by_tracks(line, duty, tracks, duty.mission.spans[0].section_id, length_m)
    return replace(ended, leaves=False, becomes=next_train)


def beginning_at(line: Line, duty: Duty, station_id: str, start: str, after: str, length_m: float) -> Duty:
    """The same duty from a station on its way, where its set stands in section `start` since train `after`. NoWay where
    it does not stop there, or has no way from there.
    """
    train = duty.train
    goes_on = train.calls if isinstance(train.ends, AtPortal) else train.calls[:-1]
    at = next((i for i, call in enumerate(goes_on) if call.station_id == station_id and call.stops), -1)
    if at < 0:
        raise NoWay(f"train {train.number} does not go on from {station_id}")
    begun = replace(train, calls=train.calls[at:], begins=FromTrain(after))
    own = replace(duty, train=begun, enters=False, enter_s=begun.calls[0].last_s, late_s=0.0)
    return from_section(line, own, start, length_m)


def ordered_by(
    line: Line, duties: Sequence[Duty], at: int, route_id: str, instead: str, length_m: float
) -> tuple[Duty, ...]:
    """A set's duties with another route for the train of that index, and from another track the next one, if any
    (着発線変更). NoWay as `by_route` and `from_section`.
    """
    old, rest = duties[at], tuple(duties[at + 1 :])
    duty = by_route(line, old, route_id, instead, length_m)
    end = duty.mission.spans[-1].section_id
    if duty.becomes is not None and end != old.mission.spans[-1].section_id:
        rest = (from_section(line, rest[0], end, length_m), *rest[1:])
    return (*duties[:at], duty, *rest)


def cut_at(
    line: Line, duties: Sequence[Duty], at: int, target: int, next_train: str, length_m: float
) -> tuple[Duty, ...]:
    """A set's duties whose train of that index ends at a target, where the set goes on as another; those between are
    left out (運休). NoWay as `ending_at` and `beginning_at`, or where it has no such train.
    """
    old, here = duties[at], duties[at].mission.targets[target]
    to = next((k for k in range(at + 1, len(duties)) if duties[k].train.number == next_train), None)
    if to is None or here.station_id is None:
        raise NoWay(f"{old.stock_id} has no train {next_train} from here")
    ended = ending_at(line, old, target, next_train, length_m)
    begun = beginning_at(line, duties[to], here.station_id, here.section_id, old.train.number, length_m)
    return (*duties[:at], ended, begun, *duties[to + 1 :])


def _calls_until(train: TimetableTrain, station_id: str | None) -> tuple[Call, ...]:
    at = next((i for i, call in enumerate(train.calls) if call.station_id == station_id), -1)
    if at < 0:
        raise NoWay(f"train {train.number} does not end at {station_id}")
    return train.calls[: at + 1]


def _by_tracks(line: Line, duty: Duty, train: TimetableTrain, start: str, length_m: float) -> Duty:
    leave_by = train.ends.section_id if isinstance(train.ends, AtPortal) else None
    enter_mark_m = portal_mark_m(line, train, start, length_m) if duty.enters else None
    return replace(duty, train=train, mission=plan_mission(line, train, start, leave_by, enter_mark_m))


def first_section(line: Line, train: TimetableTrain) -> str:
    """Section in which a train's stock stands before it begins: its first call's usual track."""
    call = train.calls[0]
    tracks = [
        track
        for track in line.stations[call.station_id].tracks
        if train.direction in track.marks_m and call.track in (None, track.name)
    ]
    own = [track for track in tracks if line.sections[track.section_id].kind is SectionKind.TRACK]
    usual = [track for track in own if train.direction in track.directions]
    chosen = usual or own or tracks
    if not chosen:
        raise ValueError(f"train {train.number} has no track at {call.station_id}")
    return chosen[0].section_id


def portal_mark_m(line: Line, train: TimetableTrain, portal: str, length_m: float) -> float:
    """Kilometrage (m) of the front of a train that has come in by a portal: on its portal tag.

    Where the portal has none, as far in as needed for the whole train.
    """
    piece = line.pieces[line.sections[portal].piece_ids[0]]
    for tag in line.tags.values():
        if tag.piece_id == piece.id and tag.purpose is TagPurpose.PORTAL:
            return tag.position_m
    inside_m = length_m + PORTAL_STAND_M
    return piece.from_m + inside_m if train.direction > 0 else piece.to_m - inside_m


def stabled_at_start(duties: tuple[Duty, ...]) -> bool:
    """Whether a stock stands on the line before its first train."""
    return bool(duties) and isinstance(duties[0].train.begins, Stabled)
