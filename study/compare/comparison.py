"""What changed between two runs, or between one and several: everything that is reported, drawn and written of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Final

from study.compare.changes import InputChange, input_changes
from study.compare.measures import TABLES, ComparedRow, Measure, compare_rows, measures_of
from study.compare.meets import MeetChange, MeetFate, compare_meets
from study.compare.side import ComparedRun
from study.compare.times import ComparedTimes, compare_times
from study.record.tables import RunTables
from study.wording import compared as words
from study.wording.catalogue import phrase
from study.wording.phrase import Phrase, joined_phrases


@dataclass(frozen=True, slots=True)
class RunComparison:
    """What changed from `base` to `new`. `over_s` is the threshold, s; `broken` are failures that one of both has.

    `same_journal` and `same_tables` say what did not differ at all; `rows` are by table.
    """

    base: str
    new: str
    over_s: float
    same_journal: bool
    same_tables: bool
    inputs: tuple[InputChange, ...]
    times: ComparedTimes
    meets: tuple[MeetChange, ...]
    rows: Mapping[str, tuple[ComparedRow, ...]]
    broken_base: tuple[str, ...]
    broken_new: tuple[str, ...]

    @property
    def same_inputs(self) -> bool:
        """Whether both ran the same."""
        return not self.inputs

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
            "inputs": [change.model_dump(mode="json") for change in self.inputs],
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

    sides: tuple[ComparedRun, ...]
    measures: tuple[Measure, ...]
    pairs: tuple[RunComparison, ...]

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


def compare(sides: Sequence[ComparedRun], over_s: float) -> Comparisons:
    """The first run is what the others are compared with."""
    base = sides[0]
    return Comparisons(
        tuple(sides), measures_of(sides), tuple(compare_two(base, side, over_s) for side in sides[1:])
    )


def compare_two(base: ComparedRun, new: ComparedRun, over_s: float) -> RunComparison:
    """What changed from one run to another; times that moved by at most `over_s` are not listed."""
    mine, others = base.run.tables, new.run.tables
    return RunComparison(
        base.label,
        new.label,
        over_s,
        base.summary.get("digest") == new.summary.get("digest"),
        all(getattr(mine, f.name).equals(getattr(others, f.name)) for f in fields(RunTables)),
        input_changes(base, new),
        compare_times(base.run, new.run, over_s),
        compare_meets(base.run, new.run, over_s),
        rows={table: compare_rows(base, new, table) for table in TABLES},
        broken_base=tuple(text for text in base.broken if text not in new.broken),
        broken_new=tuple(text for text in new.broken if text not in base.broken),
    )


def verdict_of(found: RunComparison) -> tuple[str, ...]:
    """`verdict_said` in English."""
    return tuple(sentence.en for sentence in verdict_said(found))


def verdict_said(found: RunComparison) -> tuple[Phrase, ...]:
    """What changed, in sentences: what a planner wants to know first."""
    if found.nothing_differs:
        inputs = words.SAME_INPUTS if found.same_inputs else words.OTHER_INPUTS
        return (words.NOTHING_AT_ALL.fill(inputs=inputs),)
    times = found.times
    sentences = [_moved(found)]
    for numbers, where in ((times.only_new, found.new), (times.only_base, found.base)):
        if numbers:
            sentences.append(words.ONLY_IN.fill(where=where, trains=_trains(numbers)))
    if times.once:
        sentences.append(words.CAME_ONCE.fill(count=_count(len(times.once), _TIME)))
    sentences.append(_meets(found.meets))
    for texts, where in ((found.broken_new, found.new), (found.broken_base, found.base)):
        if texts:
            sentences.append(words.BROKEN_ONLY.fill(where=where, texts="; ".join(texts)))
    return tuple(sentences)


def _moved(found: RunComparison) -> Phrase:
    """The sentence on times."""
    times = found.times
    if not times.compared:
        return words.NONE_COMPARED
    over = words.SECONDS.fill(over_s=found.over_s)
    both = words.BOTH.fill(count=f"{times.compared:,}")
    largest = words.LARGEST.fill(largest_s=times.largest_s)
    if not times.moved:
        return words.NOTHING_MOVED.fill(over=over, both=both, largest=largest)
    later = sum(moved.by_s > 0.0 for moved in times.moved)
    return words.MOVED.fill(
        count=f"{len(times.moved):,}",
        both=both,
        over=over,
        later=f"{later:,}",
        earlier=f"{len(times.moved) - later:,}",
        trains=_count(len({moved.train for moved in times.moved}), _TRAIN),
        largest=largest,
    )


def _meets(meets: Sequence[MeetChange]) -> Phrase:
    """The sentence on meets."""
    if not meets:
        return words.NO_MEET
    counts = Counter(change.fate for change in meets)
    each = joined_phrases(FATES[fate].fill(count=count) for fate, count in counts.items())
    return words.MEETS.fill(count=_count(len(meets), _MEET), each=each)


def _trains(numbers: Sequence[str]) -> Phrase:
    shown, rest = ", ".join(numbers[:8]), len(numbers) - 8
    form = words.ONE_TRAIN if len(numbers) == 1 else words.MORE_TRAINS if rest > 0 else words.TRAINS
    return form.fill(shown=shown, rest=rest)


FATES: Final[Mapping[MeetFate, Phrase]] = {
    MeetFate.ELSEWHERE: phrase("{count} elsewhere"),
    MeetFate.OTHER_TIME: phrase("{count} at another time"),
    MeetFate.GONE: phrase("{count} gone"),
    MeetFate.NEW: phrase("{count} new"),
}
# One and several of a thing.
_TIME: Final = (
    phrase("{count} arrival or departure", "counted"),
    phrase("{count} arrivals and departures", "counted"),
)
_TRAIN: Final = (phrase("{count} train", "counted"), phrase("{count} trains", "counted"))
_MEET: Final = (phrase("{count} meet", "counted"), phrase("{count} meets", "counted"))


def _count(count: int, names: tuple[Phrase, Phrase]) -> Phrase:
    return names[count != 1].fill(count=f"{count:,}")
