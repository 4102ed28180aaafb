"""As few sets as can be: against every roster of small days, and on the shipped weekdays; certificates recounted."""

import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from network.model import Direction
from plan.roster.cover import FewerCannot, least_roster
from plan.roster.facts import RosterTerms, RosterTrain, SetEvent
from plan.roster.least import fewest_sets
from plan.roster.recount import RosterRecount
from scenario.scenario import load_scenario

TERMS = RosterTerms(outside_s=10)


def train(number: str, at: tuple[str, int], to: tuple[str, int], kind: str = "one") -> RosterTrain:
    """From a place outside the line to another."""
    begins, ends = (SetEvent(place, True, time_s, 0.0) for place, time_s in (at, to))
    return RosterTrain(number, kind, Direction.DOWN, begins, ends, None, 0)


def fewest(trains: Sequence[RosterTrain], terms: RosterTerms) -> int:
    """By trying all: each train in turn goes to each set that can run it, or to a new one."""

    def may(one: RosterTrain, other: RosterTrain) -> bool:
        waits_s = other.begins.time_s - one.ends.time_s
        return one.kind == other.kind and one.ends.place == other.begins.place and waits_s >= terms.outside_s

    def from_here(left: Sequence[RosterTrain], sets: tuple[RosterTrain, ...]) -> int:
        if not left:
            return len(sets)
        own, rest = left[0], left[1:]
        counts = [from_here(rest, (*sets, own))]
        counts += [
            from_here(rest, (*sets[:at], own, *sets[at + 1 :]))
            for at, last in enumerate(sets)
            if may(last, own)
        ]
        return min(counts)

    return from_here(sorted(trains, key=lambda t: t.begins.time_s), ())


def small_days() -> Iterator[list[RosterTrain]]:
    draw = random.Random(7)
    for _ in range(60):
        trains: list[RosterTrain] = []
        for number in range(draw.randint(1, 7)):
            begins_s = draw.randint(0, 100)
            ends_s = begins_s + draw.randint(5, 40)
            places = draw.choice("AB"), draw.choice("AB")
            kind = draw.choice(("one", "one", "other"))
            trains.append(train(str(number), (places[0], begins_s), (places[1], ends_s), kind))
        yield trains


def test_no_roster_has_fewer_sets_of_all_that_there_are() -> None:
    counts: set[int] = set()
    for trains in small_days():
        found = least_roster(trains, TERMS)
        counts.add(len(found.sets))
        assert len(found.sets) == fewest(trains, TERMS) == found.why.at_least
        RosterRecount(trains, TERMS).refuse(found.sets, found.why)
    assert counts >= {1, 2, 3, 4}


def test_two_that_come_and_two_that_go_with_one_between_need_three_sets() -> None:
    """Of trains that exclude each other there are only two: either of the first could be before either of the last."""
    trains = [
        train("1", ("A", 0), ("B", 10)),
        train("2", ("A", 1), ("B", 11)),
        train("3", ("B", 30), ("C", 40)),
        train("4", ("C", 60), ("A", 70)),
        train("5", ("C", 61), ("A", 71)),
    ]
    found = least_roster(trains, TERMS)
    assert len(found.sets) == 3
    assert len(found.why.begin) - len(found.why.after) == 3


def test_a_certificate_with_anything_changed_is_refused() -> None:
    for trains in small_days():
        why = least_roster(trains, TERMS).why
        recount = RosterRecount(trains, TERMS)
        assert recount.objections(why) == []
        changed = [msgspec.structs.replace(why, sets=why.sets + 1)]
        changed += [msgspec.structs.replace(why, after=why.after[1:])] if why.after else []
        changed += [msgspec.structs.replace(why, begin=(*why.begin, why.begin[0]))] if why.begin else []
        for wrong in changed:
            assert recount.objections(wrong) != []


def test_a_set_that_cannot_be_there_is_refused() -> None:
    trains = [train("1", ("A", 0), ("B", 10)), train("2", ("B", 15), ("A", 25))]
    with pytest.raises(ValueError, match="2 cannot follow 1"):
        RosterRecount(trains, TERMS).refuse([("1", "2")], FewerCannot(1, ("1",), ()))
    with pytest.raises(ValueError, match="not every train"):
        RosterRecount(trains, TERMS).refuse([("1",)], FewerCannot(1, ("1",), ()))


PAGE = (Path(__file__).resolve().parents[2] / "docs/best.md").read_text("utf-8")
SHOWN = re.findall(r"^\| `(\w+)` \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", PAGE, re.MULTILINE)


@pytest.mark.parametrize(("name", "trains", "today", "least", "with_empties"), SHOWN)
def test_the_page_shows_the_sets_of_shipped_days(
    name: str, trains: str, today: str, least: str, with_empties: str
) -> None:
    """Recounted as they are found; `check` lets them run."""
    found = fewest_sets(load_scenario(name).setup, RosterTerms())
    counts = len(found.trains), found.today, len(found.roster.sets), found.at_least_with_empty_workings
    assert counts == (int(trains), int(today), int(least), int(with_empties))
    assert found.judged.good
    own = {number: t for t in found.trains for number in [t.number]}
    for diagram in found.timetable.diagrams:
        for before, after in pairwise(diagram.train_numbers):
            assert own[after].begins.time_s > own[before].ends.time_s
            assert own[after].begins.place == own[before].ends.place


def test_a_crew_that_needs_longer_leaves_a_train_without_a_set() -> None:
    setup = load_scenario("isumi_weekday").setup
    assert fewest_sets(setup, RosterTerms()).stranded == ()
    assert fewest_sets(setup, replace(RosterTerms(), turn_s=3600)).stranded != ()
