"""A late day: the same for the same seed, every source by itself, and as often as its figures say."""

import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation.faults.links import DeadZone
from simulation.faults.script import ScriptedFault
from simulation.late.settings import Late
from simulation.late_day import PUNCTUAL, DrawnDisturbance, LateDay, counts_of, late_day
from simulation.setup import Setup
from simulation.world.roster import drawn_up

FIXED = {"distribution": "fixed", "mean_s": 60.0}
EXPONENTIAL = {"distribution": "exponential", "mean_s": 120.0, "max_s": 900.0}
SOURCES: dict[str, dict[str, Any]] = {
    "entry": {"share": 0.5, "seconds": EXPONENTIAL},
    "dwell": {"seconds": {"distribution": "weibull", "mean_s": 10.0, "shape": 1.4}, "stations": {"OGN": 2.0}},
    "doors": {"share": 0.2, "seconds": {"distribution": "lognormal", "mean_s": 15.0, "sigma": 0.6}},
    "dead_zones": {"per_day": 3.0, "length_low_m": 100.0, "length_high_m": 900.0, "seconds": EXPONENTIAL},
    "failures": {"kind": "motors", "cut_out": 1, "mtbf_km": 200.0, "seconds": EXPONENTIAL},
}
NAMES = st.sampled_from(["a", "b", "c"])


def late(*picked: tuple[str, str], **changed: dict[str, Any]) -> Late:
    """A table of those sources, each (kind, name); a kind's keys may be changed."""
    tables: dict[str, dict[str, Any]] = {}
    for kind, name in picked:
        tables.setdefault(kind, {})[name] = (
            SOURCES[kind] | {"source": "made for tests"} | changed.get(kind, {})
        )
    return Late.model_validate(tables)


def day(setup: Setup, table: Late, seed: int = 1, number: int = 1) -> LateDay:
    return late_day(replace(setup, late=table, seed=seed, day=number))


def of(drawn: LateDay, kind: str, name: str) -> list[DrawnDisturbance]:
    return [one for one in drawn.drawn if one.source == f"late.{kind}.{name}"]


SETS = st.sets(st.tuples(st.sampled_from(sorted(SOURCES)), NAMES), min_size=1, max_size=6)


@given(SETS, st.tuples(st.sampled_from(sorted(SOURCES)), NAMES), st.integers(0, 2**63 - 1))
def test_a_source_more_moves_no_draw_of_another(
    karasuyama_setup: Setup, picked: set[tuple[str, str]], added: tuple[str, str], seed: int
) -> None:
    ordered = sorted(picked - {added})
    before = day(karasuyama_setup, late(*ordered), seed)
    after = day(karasuyama_setup, late(*ordered, added), seed)
    first = late(added).entry  # of entries the first that fits counts: the one added stands behind
    for kind, name in ordered:
        if kind != "entry" or not first:
            assert of(after, kind, name) == of(before, kind, name)
    assert day(karasuyama_setup, late(*ordered), seed) == before


def test_another_seed_and_another_day_are_other_days(karasuyama_setup: Setup) -> None:
    table = late(*((kind, "a") for kind in SOURCES))
    days = [day(karasuyama_setup, table, seed, number) for seed, number in ((1, 1), (2, 1), (1, 2))]
    assert days[0] != days[1] and days[0] != days[2] and days[1] != days[2]


def test_without_a_table_or_with_all_switched_off_nothing_is_drawn(karasuyama_setup: Setup) -> None:
    assert late_day(karasuyama_setup) is PUNCTUAL
    off = {kind: {"on": False} for kind in SOURCES}
    drawn = day(karasuyama_setup, late(*((kind, "a") for kind in SOURCES), **off))
    assert (drawn.drawn, dict(drawn.stays), drawn.failures) == ((), {}, ())


@pytest.mark.parametrize("kind", sorted(SOURCES))
def test_a_source_can_be_switched_off_and_then_its_draws_are_gone(karasuyama_setup: Setup, kind: str) -> None:
    every = [(k, "a") for k in SOURCES]
    on, off = (day(karasuyama_setup, late(*every, **{kind: {"on": on}})) for on in (True, False))
    assert of(on, kind, "a") and not of(off, kind, "a")
    assert [one for one in on.drawn if one not in of(on, kind, "a")] == list(off.drawn)


def test_entries_are_those_of_the_trains_that_enter(karasuyama_setup: Setup) -> None:
    table = late(("entry", "a"), entry={"share": 1.0, "seconds": FIXED, "portals": ["HSK.MD"]})
    setup = replace(karasuyama_setup, late=table)
    duties = [duty for of_stock in drawn_up(setup, setup.line).values() for duty in of_stock]
    late_s = {duty.train.number: duty.late_s for duty in duties}
    enter = {duty.train.number for duty in duties if duty.enters}
    assert late_s == {number: 60.0 if number in enter else 0.0 for number in late_s}
    assert {one.who for one in late_day(setup).drawn} == enter
    assert all(duty.comes_s == duty.enter_s + duty.late_s for duty in duties)


def test_the_first_entry_that_fits_counts(karasuyama_setup: Setup) -> None:
    both = Late.model_validate(
        {
            "entry": {
                "up": {"portals": ["HSK.MU"], "seconds": FIXED, "source": "t"},
                "any": {"seconds": FIXED | {"mean_s": 5.0}, "source": "t"},
            }
        }
    )
    assert counts_of(day(karasuyama_setup, both)).keys() == {"late.entry.any"}


def test_people_take_longer_by_station_and_hour(karasuyama_setup: Setup) -> None:
    peaks = [{"from": "06:00", "to": "08:00", "times": 3.0}]
    drawn = day(karasuyama_setup, late(("dwell", "a"), dwell={"seconds": FIXED, "peaks": peaks})).drawn
    trains = (train for train in karasuyama_setup.timetable.trains.values() if train.revenue)
    on_the_way = {(train.number, call.station_id) for train in trains for call in train.calls[1:-1]}
    assert {(one.who, one.place) for one in drawn} == on_the_way
    for one in drawn:
        peak = 3.0 if one.at_s is not None and 21_600 <= one.at_s < 28_800 else 1.0
        assert one.seconds == pytest.approx(60.0 * peak * (2.0 if one.place == "OGN" else 1.0))


def test_as_many_come_late_and_break_as_the_figures_say(karasuyama_setup: Setup) -> None:
    """Counts over many seeds against what is expected of them, within 4.5 standard deviations."""
    seeds = 150
    table = late(("entry", "a"), ("doors", "a"), ("dead_zones", "a"), ("failures", "a"))
    days = [day(karasuyama_setup, table, seed) for seed in range(seeds)]
    duties = [d for of_stock in drawn_up(karasuyama_setup, karasuyama_setup.line).values() for d in of_stock]
    enter = sum(duty.enters for duty in duties)
    stops = sum(
        call.departure_s is not None
        for t in karasuyama_setup.timetable.trains.values()
        if t.revenue
        for call in t.calls
    )
    km = sum((d.mission.targets[-1].mark_m - d.mission.targets[0].mark_m) / 1000.0 for d in duties)
    for kind, mean, variance in (
        ("entry", 0.5 * enter, 0.25 * enter),
        ("doors", 0.2 * stops, 0.16 * stops),
        ("dead_zones", 3.0, 3.0),
        ("failures", km / 200.0, km / 200.0),
    ):
        counted = sum(len(of(one, kind, "a")) for one in days)
        assert counted == pytest.approx(seeds * mean, abs=4.5 * math.sqrt(seeds * variance))


def test_what_is_no_unit_breaks_by_the_hours_of_the_day(karasuyama_setup: Setup) -> None:
    off = {"kind": "power_off", "targets": ["block-manager"], "mtbf_h": 1.0, "seconds": FIXED, "source": "t"}
    table = Late.model_validate({"failures": {"manager": off}})
    duties = [d for of_stock in drawn_up(karasuyama_setup, karasuyama_setup.line).values() for d in of_stock]
    day_s = max(d.train.calls[-1].last_s for d in duties) - min(d.enter_s for d in duties)
    expected = 15 * day_s / 3600.0
    counted = sum(len(day(karasuyama_setup, table, seed).failures) for seed in range(15))
    assert abs(counted - expected) <= 4.5 * math.sqrt(expected)


def test_points_break_at_counted_throws_and_only_such_as_may_come(karasuyama_setup: Setup) -> None:
    stuck = {"kind": "stuck", "mtbf_operations": 20.0, "seconds": FIXED, "source": "t"}
    table = Late.model_validate({"failures": {"points": stuck}})
    broken = [f for seed in range(20) for f in day(karasuyama_setup, table, seed).failures]
    throws = [failure.trigger.nth for failure in broken]
    assert broken and max(throws) <= 2 * 60 and all(f.trigger.on is not None for f in broken)
    first: list[int] = []
    for seed in range(150):
        found = [
            f.trigger.nth for f in day(karasuyama_setup, table, seed).failures if f.fault.target == "OGN.11"
        ]
        first += found[:1]
    assert sum(first) / len(first) == pytest.approx(20.0, abs=4.5 * 20.0 / math.sqrt(len(first)) + 2.0)


def test_a_dead_zone_lies_in_its_section_and_heals(karasuyama_setup: Setup) -> None:
    drawn = day(karasuyama_setup, late(("dead_zones", "a"), dead_zones={"per_day": 40.0}))
    broken = day(karasuyama_setup, late(("failures", "a"), failures={"mtbf_km": 20.0}))
    for one in (drawn, broken):
        assert [f.duration_s for f in one.failures] == [told.seconds for told in one.drawn] != []
    for failure in drawn.failures:
        assert isinstance(failure, ScriptedFault) and isinstance(failure.fault, DeadZone)
        assert failure.fault.target in karasuyama_setup.line.sections
        assert 100.0 <= failure.fault.length_m <= 900.0
        assert failure.duration_s is not None and failure.duration_s >= 0.1


def test_sentences_say_when_who_and_from_what(karasuyama_setup: Setup) -> None:
    table = late(("entry", "a"), entry={"share": 1.0, "seconds": FIXED})
    assert day(karasuyama_setup, table).drawn[0].sentence == (
        "05:33:30 train 321M comes to HSK.MD 60.0 s later than planned (late.entry.a: fixed, mean 60 s)"
    )
