"""Days worth looking at: what went wrong, the worst, and an ordinary one beside them; each runs again by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from study.sweep.figures import FIGURES
from study.sweep.go import SweepProgress
from study.sweep.plan import GridPoint
from study.sweep.point import scenario_text
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.store import write_whole
from study.sweep.table import value_of
from study.sweep.worker import replay_command, replay_name

EACH_MAX: Final = 3  # days of one kind at one point
DAYS_MAX: Final = 60  # in all: the table of all days has every one
_WRONG: Final = (DayOutcome.CRASHED, DayOutcome.BROKEN, DayOutcome.DEADLOCK, DayOutcome.NOT_ARRIVED)


@dataclass(frozen=True, slots=True)
class NotableDay:
    """A day, why it is shown, and the command that runs it again with its report."""

    why: str
    point: GridPoint
    record: DayRecord
    command: str


def worth_looking_at(state: SweepProgress, out: Path) -> tuple[NotableDay, ...]:
    """The days, the gravest kind first; no day twice."""
    found: list[NotableDay] = []
    seen: set[tuple[int, int]] = set()
    for why, point, record in _all(state):
        if (point.number, record.index) in seen or len(found) >= DAYS_MAX:
            continue
        seen.add((point.number, record.index))
        found.append(NotableDay(why, point, record, command_of(record, out)))
    return tuple(found)


def command_of(record: DayRecord, out: Path) -> str:
    """What runs a day again; a plan that cannot work is refused without being told to run it."""
    command = replay_command(record.spec, str(out))
    return command if record.outcome is DayOutcome.GOOD else f"{command} --anyway"


def write_replays(days: tuple[NotableDay, ...], out: Path) -> None:
    """The scenario files that the commands name."""
    (out / "replays").mkdir(exist_ok=True)
    for day in days:
        spec = day.record.spec
        text = scenario_text(spec, seeded=bool(spec.drawn))
        write_whole(out / replay_name(spec), text.encode("utf-8"))


def _all(state: SweepProgress) -> Iterator[tuple[str, GridPoint, DayRecord]]:
    points = state.plan.points
    days = {point.number: state.days_counted(point) for point in points}
    for point in points:
        differing = [record for record in days[point.number] if record.differs]
        yield from (("another day on SUMO", point, record) for record in differing[:EACH_MAX])
    for outcome in _WRONG:
        for point in points:
            wrong = [record for record in days[point.number] if record.outcome is outcome]
            yield from ((outcome.value, point, record) for record in wrong[:EACH_MAX])
    name = state.plan.table.watch[0]
    figure = FIGURES[name]
    for point in points:
        ranked = sorted(
            (
                (value, record.index, record)
                for record in days[point.number]
                if (value := value_of(record, name)) is not None
            ),
            reverse=not figure.more_is_better,
        )
        yield from (
            (f"worst {figure.title}" if place == 0 else f"{place + 1}. worst {figure.title}", point, record)
            for place, (_, _, record) in enumerate(ranked[: EACH_MAX if len(points) == 1 else 1])
        )
        if ranked:
            yield f"median {figure.title}", point, ranked[len(ranked) // 2][2]
