"""A sweep under way: which days are still to run, which count, and when a point has enough of them.

Days of a point count in the order of their seeds, up to the first at which the stop rule holds: the table is the same
in whatever order days come back, and on however many machines. Days beyond it stay on disk and do not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Final

from network.errors import InputError
from study.sweep.digest import code_digest
from study.sweep.figures import FIGURES
from study.sweep.kept import is_kept
from study.sweep.local import Pump
from study.sweep.plan import GridPoint, SweepPlan
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.statistics import FigureEstimate, RunningMoments
from study.sweep.store import FiledDays, SweepDirectory, UnusableFile, day_name
from study.sweep.worker import RUNNER, FiledDay, Task

CODE_SHOWN: Final = 8
BAD: Final = (DayOutcome.BROKEN, DayOutcome.CRASHED)  # the others are what a sweep is to find out


class _PointProgress:
    """One point: its days as they come, and how far they are complete from the first one on."""

    def __init__(self, plan: SweepPlan, point: GridPoint) -> None:
        self.point: Final = point
        self.names: Final = tuple(day_name(plan.spec(point, index), index) for index in range(plan.days))
        self.days = plan.days  # that count; the stop rule makes it fewer
        self._plan = plan
        self._complete = 0
        self._ahead: set[int] = set()  # days that are there before one that comes first
        self._running = {name: RunningMoments() for name in _watched(plan)}
        self._looks = frozenset(plan.looks)

    def take(self, index: int, name: str, records: Mapping[str, DayRecord]) -> None:
        """A day that has come, and those that now follow on those before it."""
        if self.names[index] == name and self._complete <= index < self.days:
            self._ahead.add(index)
            self.advance(records)

    def find(self, records: Mapping[str, DayRecord]) -> None:
        """The days that there are already."""
        self._ahead = {index for index, name in enumerate(self.names) if name in records}
        self.advance(records)

    @property
    def there(self) -> int:
        """Days that count and are there."""
        return self._complete + len(self._ahead)

    def advance(self, records: Mapping[str, DayRecord]) -> None:
        """Take the days that now follow on those before."""
        while self._complete < self.days and (record := records.get(self.names[self._complete])) is not None:
            self._ahead.discard(self._complete)
            self._complete += 1
            for name, running in self._running.items():
                value = None if record.figures is None else FIGURES[name].of(record.figures)
                if value is not None:
                    running.add(value)
            if self._enough():
                self.days = self._complete
                self._ahead.clear()

    def estimate(self, name: str) -> FigureEstimate:
        """Of a watched figure, so far."""
        return self._running[name].estimate(self._plan.confidence)

    @property
    def done(self) -> bool:
        """Whether all days that count are there."""
        return self._complete >= self.days

    def _enough(self) -> bool:
        stop = self._plan.stop
        if stop is None or self._complete not in self._looks:
            return False
        width = self.estimate(stop.figure).width
        return width is not None and width < stop.narrower_than


@dataclass(slots=True)
class SweepProgress:
    """How far a sweep is. `before`: days that were there as it began; `last`: the day that came last."""

    plan: SweepPlan
    courses: tuple[_PointProgress, ...]
    records: dict[str, DayRecord]
    before: int
    refused: tuple[UnusableFile, ...] = ()
    others: int = 0
    run: int = 0
    wall_s: float = 0.0
    cpu_s: float = 0.0
    peak_bytes: int = 0
    last: FiledDay | None = None

    @property
    def total(self) -> int:
        """Days that count, as far as is known."""
        return sum(course.days for course in self.courses)

    @property
    def there(self) -> int:
        """Days of those that are there."""
        return sum(course.there for course in self.courses)

    def days_counted(self, point: GridPoint) -> tuple[DayRecord, ...]:
        """The days of a point that count and are there, by seed."""
        course = self.courses[point.number]
        return tuple(self.records[name] for name in course.names[: course.days] if name in self.records)

    def estimate(self, name: str, point: int = 0) -> FigureEstimate:
        """Of a watched figure at a point, over the days that are complete."""
        return self.courses[point].estimate(name)

    def found_text(self) -> str:
        """The first figure watched, at the point whose interval is the widest, for the line that runs."""
        name = self.plan.table.watch[0]
        found = [course.estimate(name) for course in self.courses]
        widest = max(found, key=lambda one: one.width or 0.0)
        return f"{FIGURES[name].title} {widest.text} {FIGURES[name].unit}".rstrip()

    def stopped_early(self, point: GridPoint) -> bool:
        """Whether the stop rule has spared days of a point."""
        return self.courses[point.number].days < self.plan.days

    @property
    def done(self) -> bool:
        """Whether nothing is left to run."""
        return all(course.done for course in self.courses)

    @property
    def failures(self) -> tuple[str, ...]:
        """What makes the sweep a failure, a sentence each: carriers that differ, rules that are broken, crashes."""
        texts = [
            f"day {record.index} of {label} (seed {record.spec.seed}) is another day on SUMO: {record.again}, not"
            f" {record.digest}"
            for label, record in self._counted()
            if record.differs
        ]
        for outcome in BAD:
            days = [record for _, record in self._counted() if record.outcome is outcome]
            if days:
                first = days[0]
                texts.append(
                    f"{len(days)} days: {outcome.value}; the first has seed {first.spec.seed}: {first.why}"
                )
        return tuple(texts)

    @property
    def carriers(self) -> str:
        """What carried the days that count: another carrier than the plan's where days were there before."""
        found = {record.spec.carrier for _, record in self._counted()} or {self.plan.carrier.value}
        return " and ".join(sorted(found))

    def _counted(self) -> Iterator[tuple[str, DayRecord]]:
        for point in self.plan.points:
            for record in self.days_counted(point):
                yield point.label, record


Show = Callable[[SweepProgress], None]


def sweep_begun(plan: SweepPlan, store: SweepDirectory, *, anyway: bool) -> SweepProgress:
    """What is there, all that is to be kept too. InputError for days of other code, unless they count `anyway`."""
    courses = tuple(_PointProgress(plan, point) for point in plan.points)
    found: FiledDays = store.days_found({name for course in courses for name in course.names})
    codes = {record.code for record in found.records.values()} - {code_digest()}
    if codes and not anyway:
        shown = ", ".join(sorted(code[:CODE_SHOWN] for code in codes))
        expected = (
            f"a directory whose days were run by this code ({code_digest()[:CODE_SHOWN]}), or --anyway; it has"
            f" days of {shown}"
        )
        raise InputError("command line", "--out", store.out, expected)
    there = {name: day for name, day in found.records.items() if is_kept(day, store.out, plan.table.keep)}
    state = SweepProgress(plan, courses, there, 0, found.refused, found.others)
    for course in courses:
        course.find(state.records)
    state.before = state.there
    return state


def run_missing(
    state: SweepProgress, store: SweepDirectory, pump: Pump, show: Show | None = None, runner: str = RUNNER
) -> None:
    """Run what is missing. Raises GivenUpError; whatever ends it, the days that are filed stay."""
    with closing(pump.run(_tasks(state, store, runner))) as days:
        for done in days:
            record = done.record
            name = day_name(record.spec, record.index)
            state.records[name] = record
            state.run += 1
            state.wall_s += done.wall_s
            state.cpu_s += done.cpu_s
            state.peak_bytes = max(state.peak_bytes, done.peak_bytes)
            state.last = done
            for course in state.courses:
                course.take(record.index, name, state.records)
            if show is not None:
                show(state)
            if state.done:
                return


def _tasks(state: SweepProgress, store: SweepDirectory, runner: str) -> Iterator[Task]:
    """The days that are missing, seed by seed at all points; a point that has enough is left out from then on."""
    plan = state.plan
    given: set[str] = set()
    for index in range(plan.days):
        for course in state.courses:
            name = course.names[index]
            if index >= course.days or name in state.records or name in given:
                continue
            given.add(name)
            yield Task(
                str(store.out),
                store.token,
                plan.spec(course.point, index),
                index,
                plan.runs_twice(index),
                tuple(plan.table.keep),
                runner=runner,
            )


def _watched(plan: SweepPlan) -> tuple[str, ...]:
    stop = () if plan.stop is None else (plan.stop.figure,)
    return tuple(dict.fromkeys((*plan.table.watch, *stop)))
