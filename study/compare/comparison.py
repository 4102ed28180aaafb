"""What changed between two runs, or between one and several: everything that is told, drawn and written of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from study.compare.changes import InputChange, input_changes
from study.compare.measures import TABLES, Measure, Row, compare_rows, measures_of
from study.compare.meets import MeetChange, compare_meets
from study.compare.side import Side
from study.compare.times import Times, compare_times
from study.run.tables import RunTables


@dataclass(frozen=True, slots=True)
class Comparison:
    """What changed from `base` to `new`. `over_s` is the threshold, s; `broken` are failures that one of both has.

    `same_inputs`, `same_journal` and `same_tables` say what did not differ at all; `rows` are by table.
    """

    base: str
    new: str
    over_s: float
    same_inputs: bool
    same_journal: bool
    same_tables: bool
    inputs: tuple[InputChange, ...]
    times: Times
    meets: tuple[MeetChange, ...]
    rows: Mapping[str, tuple[Row, ...]]
    broken_base: tuple[str, ...]
    broken_new: tuple[str, ...]

    @property
    def nothing_differs(self) -> bool:
        """Whether one run is the other: its journal and every figure of every table."""
        return self.same_journal and self.same_tables

    def as_dict(self) -> dict[str, Any]:
        """For JSON; rows have their names, then old and new of each column."""
        times = self.times
        return {
            "base": self.base,
            "new": self.new,
            "over_s": self.over_s,
            "verdict": list(verdict_of(self)),
            "nothing_differs": self.nothing_differs,
            "same_inputs": self.same_inputs,
            "same_journal": self.same_journal,
            "inputs": [change.as_dict() for change in self.inputs],
            "times": {
                "compared": times.compared,
                "largest_s": times.largest_s,
                "moved": [moved.as_dict() for moved in times.moved],
                "in_one_only": [once.as_dict() for once in times.once],
            },
            "trains": {"only_base": list(times.only_base), "only_new": list(times.only_new)},
            "meets": [change.as_dict() for change in self.meets],
            **{table: [asdict(row) for row in rows] for table, rows in self.rows.items()},
            "broken": {"only_base": list(self.broken_base), "only_new": list(self.broken_new)},
        }


@dataclass(frozen=True, slots=True)
class Comparisons:
    """The first run with each of the others, and the figures of all."""

    sides: tuple[Side, ...]
    measures: tuple[Measure, ...]
    pairs: tuple[Comparison, ...]

    def of_two(self, index: int) -> Comparisons:
        """The first run with one of the others alone."""
        measures = tuple(
            replace(m, values=(m.values[0], m.values[index + 1]), where=(m.where[0], m.where[index + 1]))
            for m in self.measures
        )
        return Comparisons((self.sides[0], self.sides[index + 1]), measures, (self.pairs[index],))

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "runs": [
                {
                    "label": side.label,
                    "scenario": side.summary.get("scenario"),
                    "name": side.name,
                    "directory": None if side.directory is None else str(side.directory),
                    "digest": side.summary.get("digest"),
                }
                for side in self.sides
            ],
            "measures": [measure.as_dict() for measure in self.measures],
            "comparisons": [pair.as_dict() for pair in self.pairs],
        }


def compare(sides: Sequence[Side], over_s: float) -> Comparisons:
    """The first run is what the others are compared with."""
    base = sides[0]
    return Comparisons(
        tuple(sides), measures_of(sides), tuple(compare_two(base, side, over_s) for side in sides[1:])
    )


def compare_two(base: Side, new: Side, over_s: float) -> Comparison:
    """What changed from one run to another; times that moved by at most `over_s` are not listed."""
    inputs = input_changes(base, new)
    mine, others = base.run.tables, new.run.tables
    return Comparison(
        base=base.label,
        new=new.label,
        over_s=over_s,
        same_inputs=not inputs,
        same_journal=base.summary.get("digest") == new.summary.get("digest"),
        same_tables=all(getattr(mine, f.name).equals(getattr(others, f.name)) for f in fields(RunTables)),
        inputs=inputs,
        times=compare_times(base.run, new.run, over_s),
        meets=compare_meets(base.run, new.run, over_s),
        rows={table: compare_rows(base, new, table) for table in TABLES},
        broken_base=tuple(text for text in base.broken if text not in new.broken),
        broken_new=tuple(text for text in new.broken if text not in base.broken),
    )


def verdict_of(found: Comparison) -> tuple[str, ...]:
    """What changed, in sentences: what a planner wants to know first."""
    if found.nothing_differs:
        inputs = "from the same inputs" if found.same_inputs else "though the inputs differ"
        return (f"Nothing differs at all, {inputs}: the journals of both runs are the same.",)
    times = found.times
    told = [_moved(found)]
    for numbers, where in ((times.only_new, found.new), (times.only_base, found.base)):
        if numbers:
            told.append(f"Only in {where}: {_trains(numbers)}.")
    if times.once:
        told.append(
            f"{_count(len(times.once), 'arrival or departure', 'arrivals and departures')} of trains that"
            " run in both came in one run only."
        )
    told.append(_meets(found.meets))
    for texts, where in ((found.broken_new, found.new), (found.broken_base, found.base)):
        if texts:
            told.append(f"Broken only in {where}: {'; '.join(texts)}.")
    return tuple(told)


def _moved(found: Comparison) -> str:
    """The sentence on times."""
    times, over = found.times, f"{found.over_s:g} s"
    if not times.compared:
        return "No arrival and no departure came in both runs: there is nothing to compare."
    both = f"{times.compared:,} arrivals and departures"
    largest = f"the largest difference is {times.largest_s:.1f} s"
    if not times.moved:
        return f"Nothing moved by more than {over}: {both} compared, {largest}."
    trains = {moved.train for moved in times.moved}
    later = sum(moved.by_s > 0.0 for moved in times.moved)
    return (
        f"{len(times.moved):,} of {both} moved by more than {over}, {later:,} later and"
        f" {len(times.moved) - later:,} earlier, of {_count(len(trains), 'train', 'trains')}; {largest}."
    )


def _meets(meets: Sequence[MeetChange]) -> str:
    """The sentence on meets."""
    if not meets:
        return "No meet moved."
    counts: dict[str, int] = {}
    for change in meets:
        counts[change.fate.value] = counts.get(change.fate.value, 0) + 1
    each = ", ".join(
        f"{count} {'at ' if fate == 'another time' else ''}{fate}" for fate, count in counts.items()
    )
    return f"{_count(len(meets), 'meet', 'meets')} changed: {each}."


def _trains(numbers: Sequence[str]) -> str:
    shown = ", ".join(numbers[:8])
    rest = len(numbers) - 8
    return f"{'train' if len(numbers) == 1 else 'trains'} {shown}{f' and {rest} more' if rest > 0 else ''}"


def _count(count: int, one: str, more: str) -> str:
    return f"{count:,} {one if count == 1 else more}"
