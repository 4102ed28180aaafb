"""Least headways driven where a train that follows is let onto the part of its way that is free.

The test line has its section between A and B in three blocks; T1 goes from A, T3 comes there by the portal behind it
and follows to B, where T1 leaves by the other portal.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Final

import pytest

from host.scratch import scratch
from network.model import SectionKind
from plan.equipping.options import options_of
from scenario.scenario import load_scenario
from study.capacity import claims, two_trains
from study.capacity.claims import LegRun
from study.capacity.headway import HeadwayCase, HeadwayKind, line_cases
from study.capacity.rules import MINIMAL
from study.capacity.theory import occupations
from study.capacity.two_trains import undisturbed_setup
from study.drilling.drill import find_drill
from study.evaluate import headways_driven
from study.evaluate.headways_driven import LATE_S, OFF_S, DrivenHeadway, HeadwayDrives
from tests.nightly import others_nightly
from tests.study.capacity.test_headway_driven import drives_of

DRILL: Final = "rtri/77_follows_in_blocks"
FOLLOWS_FROM_A: Final = "A", HeadwayKind.FOLLOWING
COMES_TO_A: Final = "A", HeadwayKind.DEPARTURE_ARRIVAL
FOLLOWS_FROM_B: Final = "B", HeadwayKind.FOLLOWING
COMES_TO_B: Final = "B", HeadwayKind.DEPARTURE_ARRIVAL
ROWS: Final = (FOLLOWS_FROM_A, COMES_TO_A, FOLLOWS_FROM_B, COMES_TO_B)


@contextmanager
def driven_row(key: tuple[str, HeadwayKind]) -> Iterator[tuple[HeadwayDrives, HeadwayCase]]:
    """What drives a row of the test line in blocks, and the row."""
    with drives_of(find_drill(DRILL)) as (drives, cases):
        yield drives, next(c for c in cases if (c.station_id, c.headway.kind) == key)


def drive(key: tuple[str, HeadwayKind], *, searched: bool = False) -> DrivenHeadway:
    with driven_row(key) as (drives, case):
        return drives.drive_headway(case, searched=searched)


@pytest.mark.parametrize("key", others_nightly(ROWS, [FOLLOWS_FROM_A, COMES_TO_A]))
def test_in_blocks_a_least_headway_is_kept_and_a_second_less_is_late(key: tuple[str, HeadwayKind]) -> None:
    found = drive(key, searched=True)
    assert found.kept_s <= LATE_S < found.nearer_s, found.text
    assert abs(found.needs_s - (found.case.headway.least_s + found.driving_s - found.spared_s)) <= 1.2


def test_who_is_held_up_behind_its_departure_is_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """T3 leaves A in time whatever T1 does, as the first block is free; it waits before B."""
    monkeypatch.setattr(headways_driven, "WAY_COUNTS", False)
    assert drive(FOLLOWS_FROM_A).nearer_s <= LATE_S


def test_who_asks_for_the_rest_seconds_after_it_is_free_is_late(monkeypatch: pytest.MonkeyPatch) -> None:
    with driven_row(COMES_TO_B) as (drives, case):
        asks = drives.drive_headway(case, searched=False)
        monkeypatch.setattr(headways_driven, "ASKS_AS_FREED", False)
        asks_at_intervals = drives.drive_headway(case, searched=False)
    assert asks.agrees, asks.text
    assert asks.nearer_s < 1.0 < 2.0 < asks_at_intervals.nearer_s


def test_the_first_goes_on_where_the_second_comes_to_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else no order is known in which both finish, and no part of a way is granted."""
    with driven_row(COMES_TO_A) as (drives, case):
        both = two_trains.two_trains(drives.setup, case.headway)
        ends = {t.number: t.ends for t in (*both.first.trains, *both.second.trains)}
        assert ends["T1"] == drives.setup.timetable.trains["T1"].ends  # out by its portal
        kept = drives.drive_headway(case, searched=False)
        monkeypatch.setattr(two_trains, "FIRST_GOES_ON", False)
        assert kept.kept_s <= LATE_S < 10.0 < drives.drive_headway(case, searched=False).kept_s


def test_who_aims_early_at_an_arrival_comes_to_its_portal_no_earlier(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who comes earlier has time left, runs slowly, and may then be held up without being late."""
    assert abs(drive(COMES_TO_A).driving_s) < 0.5
    monkeypatch.setattr(two_trains, "EARLY_AIM_IS_NO_LEAD", False)
    monkeypatch.setattr(claims, "NEED_ON_THE_WAY_COUNTS", False)
    assert drive(COMES_TO_A).driving_s > 2.0


def test_what_lies_before_a_need_on_the_way_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """The stretch ends the chain: it begins as the train comes into the section it waits for, not as it departs."""
    with driven_row(COMES_TO_A) as (_, case):
        last: LegRun = case.headway.claims.runs[-1]
    leg = case.headway.second.leg
    need = next(o for o in leg.occupations if o.section_id == last.enters)
    assert last.lasts_s == pytest.approx(leg.arrives_s - need.enters_s)
    assert leg.departs_s < need.begin_s < need.enters_s
    monkeypatch.setattr(claims, "NEED_ON_THE_WAY_COUNTS", False)
    with driven_row(COMES_TO_A) as (_, case):
        assert not case.headway.claims.runs[-1].enters


def test_what_was_not_found_is_said_in_words() -> None:
    with driven_row(COMES_TO_A) as (_, case):
        texts = [DrivenHeadway(case, kept_s=0.0, nearer_s=0.0, needs_s=s).text for s in (math.inf, -math.inf)]
    assert f"over {OFF_S} s more" in texts[0]
    assert f"over {OFF_S} s less" in texts[1]
    assert not any("inf " in text for text in texts)


@pytest.mark.nightly
def test_who_chose_another_cruising_speed_at_another_time_was_not_held_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Down the busy line in three blocks a section: 0.3 s late, also a minute further on, with nobody in its way."""
    setup = load_scenario("busy_line").setup
    covered = next(o for o in options_of(setup) if o.name == "coverage").tables["patch"]["line"]["set"]
    between = [s.id for s in setup.line.sections.values() if s.kind is SectionKind.BETWEEN]
    cut = {f"sections.{section_id}.virtual_blocks": 3 for section_id in between}
    parts = {"operation": {"release": "section"}, "dispatch": {"certificate": True}}
    scenario = load_scenario("busy_line", tables={"patch": {"line": {"set": covered | cut}}} | parts)
    setup = undisturbed_setup(scenario.setup)
    cases = line_cases(setup.line, occupations(setup, MINIMAL), setup.unit.dwell_min_s)
    key = "IZU", HeadwayKind.DEPARTURE_ARRIVAL, "down, IZU.1", "down, IZU.1"
    case = next(c for c in cases if (c.station_id, c.headway.kind, c.first, c.second) == key)
    with scratch("branchline-") as folder:
        drives = HeadwayDrives(replace(scenario, setup=setup), folder)
        found = drives.drive_headway(case, searched=False)
        assert found.agrees, found.text
        monkeypatch.setattr(headways_driven, "AT_THAT_TIME", False)
        assert drives.drive_headway(case, searched=False).kept_s > LATE_S
