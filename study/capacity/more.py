"""How many more trains a day fits, and where: standard paths put in, and the day with them judged like any other plan.

What fits between occupations is a claim; it is made only when `study.feasibility` finds nothing impossible in the
timetable with the new trains. Those that it names go out again, until it finds nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, Final

from exchange.timetable_writer import file_of_timetable
from network.clock import clock
from network.timetable import Diagram
from simulation.setup import Setup
from study.capacity.legs import SetLeg, legs_of, places_of
from study.capacity.line_capacity import Period
from study.capacity.room import OccupiedSpans, PathSearch, PlacedPath, fill_period
from study.capacity.rules import Rules
from study.capacity.standard import (
    ALONE,
    Added,
    StandardPath,
    added_path,
    extended_day,
    path_alone,
    standard_paths,
)
from study.capacity.theory import occupations
from study.feasibility.check import feasibility

STANDARD: Final = Rules(throws=True)
ROUNDS_MAX: Final = 12  # of taking out what the judgement names


@dataclass(frozen=True, slots=True)
class MorePath:
    """One more path: what it is, when it leaves its portal's first station and is at its last, s, how long it waits."""

    name: str
    numbers: tuple[str, ...]
    departs_s: float
    arrives_s: float
    waits_s: float
    trains: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        return {
            "path": self.name,
            "trains": " ".join(self.numbers),
            "departs": clock(self.departs_s),
            "arrives": clock(self.arrives_s),
            "waits_s": round(self.waits_s, 1),
        }


@dataclass(frozen=True, slots=True)
class AddedTrains:
    """What fits into a day: `paths` verified, `dropped` the sets that the judgement threw out, `names` of the kinds.

    `sets`: that of each path, and the path that it was made of.
    """

    names: tuple[str, ...]
    paths: tuple[MorePath, ...]
    sets: tuple[tuple[Added, StandardPath], ...]
    dropped: tuple[str, ...]
    search: PathSearch

    @property
    def trains(self) -> int:
        """How many more trains."""
        return sum(path.trains for path in self.paths)

    def trains_in(self, period: Period) -> int:
        """Those of paths that leave within a period."""
        return sum(p.trains for p in self.paths if period.from_s <= p.departs_s < period.to_s)


def more_trains(setup: Setup, period: Period, search: PathSearch) -> AddedTrains:
    """As many standard paths as fit into a period of the day and hold when the day is judged; see `fill`."""
    paths = standard_paths(setup)
    occupied = OccupiedSpans.of_occupations(occupations(setup))
    templates = [template(setup, path) for path in paths]
    placed = fill_period(templates, (period.from_s, period.to_s), occupied, search)
    numbers = (number for number in count(1) if f"X{number}" not in setup.trains)
    found = [_added_path(setup, paths, templates, *one) for one in zip(placed, numbers, strict=False)]
    dropped: list[str] = []
    for _ in range(ROUNDS_MAX):
        named = _impossible(setup, [(one, path) for _, one, path in found])
        out = {n for _, one, _ in found if (n := one.stock_id) and named & {t.number for t in one.trains}}
        if not out:
            if named and found:  # the day itself is at fault with them in it: nothing is claimed
                dropped += [one.stock_id for _, one, _ in found]
                found = []
            break
        dropped += sorted(out)
        found = [entry for entry in found if entry[1].stock_id not in out]
    else:
        dropped += [one.stock_id for _, one, _ in found]
        found = []
    return AddedTrains(
        tuple(path.name for path in paths),
        tuple(shown for shown, _, _ in found),
        tuple((one, path) for _, one, path in found),
        tuple(dropped),
        search,
    )


def patch_with(setup: Setup, more: AddedTrains) -> dict[str, Any]:
    """The tables of a scenario whose timetable has the paths too, each run by a set of its own."""
    trains = {train.number: train for one, _ in more.sets for train in one.trains}
    diagrams = tuple(
        Diagram(one.stock_id, tuple(train.number for train in one.trains)) for one, _ in more.sets
    )
    file = file_of_timetable(replace(setup.timetable, trains=trains, diagrams=diagrams))
    add = file.model_dump(
        by_alias=True, exclude_none=True, exclude_defaults=True, include={"trains", "diagrams"}
    )
    return {"patch": {"timetable": {"add": add}}}


def template(
    setup: Setup, path: StandardPath, rules: Rules = STANDARD, stock_id: str = ALONE
) -> tuple[SetLeg, ...]:
    """The legs of a standard path alone on its line."""
    return legs_of(occupations(path_alone(setup, path, stock_id), rules), places_of(setup.line))


def _added_path(
    setup: Setup,
    paths: Sequence[StandardPath],
    templates: Sequence[tuple[SetLeg, ...]],
    placed: PlacedPath,
    number: int,
) -> tuple[MorePath, Added, StandardPath]:
    path = paths[templates.index(placed.legs)]
    one = added_path(setup, path, number, placed.moves_s)
    numbers = tuple(train.number for train in one.trains)
    departs_s = float(one.trains[0].calls[0].last_s)
    arrives_s = float(one.trains[-1].calls[-1].first_s)
    return MorePath(path.name, numbers, departs_s, arrives_s, placed.waits_s, len(numbers)), one, path


def _impossible(setup: Setup, more: Sequence[tuple[Added, StandardPath]]) -> set[str]:
    """The trains that are named in what is impossible of the day with more trains in it, but was not without."""
    if not more:
        return set()
    before = {(f.kind, f.trains) for f in feasibility(setup).not_as_printed}
    after = feasibility(extended_day(setup, more)).not_as_printed
    return {number for f in after if (f.kind, f.trains) not in before for number in f.trains}
