"""Why a train waits, against what its unit shows its driver and against what a drill does to it."""

import re
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import pytest

from scenario.scenario import load_scenario
from simulation.events import MANAGER
from simulation.result import Waiting
from simulation.setup import STEPS_PER_S, Setup
from study.drilling.drill import find_drill
from study.measures.register_holds import section_holds
from study.measures.wait_text import text_of
from study.measures.waits import waits_of
from study.record.wait import AwaitedRequest, Cause, Wait
from study.runner.run import CarrierKind, simulation_of
from study.wording.phrase import names_of
from tests.nightly import others_nightly

ON_LINE_UNIT = (Cause.RUNS, Cause.STOP_LIMIT, Cause.STARTING)
BEFORE_ITS_TIME = (Cause.DEPARTURE_TIME, Cause.DWELL, Cause.SET_BACK)
# named first; a unit shows what it asks for before them
ABNORMAL = (Cause.EMERGENCY, Cause.VEHICLE, Cause.UNABLE)
ON_SIGHT = (Cause.ON_SIGHT, Cause.POINTS_BY_EYE, Cause.STARTING, Cause.RUNS)
# What a unit shows (`onboard.duty.shown`), and the causes that agree with it.
AGREES: Mapping[str, tuple[Cause, ...]] = {
    r"departure time": BEFORE_ITS_TIME,
    r"its next train": (Cause.TURN_BACK, Cause.NEXT_TRAIN, Cause.STABLED),
    r"agreement with the block manager": (Cause.CONTRADICTION,),
    r"signing on : held|signing on: held": (Cause.ROUTE_HELD, Cause.ANSWER, *ABNORMAL),
    r"signing on: (undefined|claim needed)": (Cause.REFUSED, *ABNORMAL),
    r"signing on: no answer": (Cause.ANSWER, Cause.COVERAGE, Cause.RUNS, *ABNORMAL),
    r"signing off: ": (Cause.ANSWER, Cause.REFUSED),
    r"route .*: held": (Cause.ROUTE_HELD, Cause.ANSWER, *BEFORE_ITS_TIME, *ABNORMAL),
    r"(route .*|signing on): no way on": (Cause.NO_WAY_ON, *BEFORE_ITS_TIME, *ABNORMAL),
    r"(route .*|signing on): not its turn": (Cause.NOT_ITS_TURN, *BEFORE_ITS_TIME, *ABNORMAL),
    r"route .*: overlap": (Cause.OVERLAP, *BEFORE_ITS_TIME, *ABNORMAL),
    r"route .*: undefined": (Cause.REFUSED, *BEFORE_ITS_TIME, *ABNORMAL),
    r"route .*: no answer": (Cause.ANSWER, Cause.COVERAGE, Cause.STARTING, *BEFORE_ITS_TIME, *ABNORMAL),
    r"points .*: not detected": (Cause.POINTS_REFUSED, *BEFORE_ITS_TIME, *ABNORMAL),
    r"points .*: not proven": (
        Cause.POINTS_MOVE,
        Cause.POINTS_PROOF,
        Cause.POINTS_BY_EYE,
        Cause.STARTING,  # from a halt, towards points far ahead
        *BEFORE_ITS_TIME,
        *ABNORMAL,
    ),
    r"vehicle: ": (Cause.VEHICLE,),
    r"what takes it to ": (Cause.UNABLE,),
    r"level crossing .* to be proved closed": (Cause.LEVEL_CROSSING, *BEFORE_ITS_TIME, *ABNORMAL),
    r"release of the emergency brake": (Cause.EMERGENCY, Cause.VEHICLE),
    r"the driver's (confirmation|word)": (
        Cause.ARRIVAL_BY_EYE,
        Cause.ANSWER,  # to the report by which it gives back what is behind
        Cause.DEPARTURE_TIME,
        Cause.DWELL,
    ),
    r"the block manager's confirmation": (Cause.ANSWER, *BEFORE_ITS_TIME),
    r"the end of the hold on its route": (Cause.SET_BACK, Cause.RUNS),
    r"its run to ": (
        *ON_LINE_UNIT,
        Cause.EMERGENCY,
        Cause.LEVEL_CROSSING,
    ),  # the last while its brakes release
    r"a tag or another fix: its position is unknown": (*ON_SIGHT, *BEFORE_ITS_TIME, Cause.EMERGENCY),
    r"the track ahead: ": (*ON_SIGHT, Cause.ANSWER),
    r"its crew to enter the train number": (Cause.NUMBER,),
    r"its crew to take it in through the portal": (Cause.ENTRY,),
    r"its crew to sign off": (Cause.SIGN_OFF,),
    r"its train to leave the line": (Cause.LEAVING,),
    r"its unit to be switched on|its unit: it has lost its durable state": (Cause.UNIT_OFF,),
    r"leave by people or a signal": (Cause.BY_HAND,),
    r"its unit, which is frozen": (Cause.UNIT_FROZEN,),
}


@dataclass(frozen=True)
class Observed:
    """A run, what its units showed whenever anything happened, and the waits that its journal gives."""

    setup: Setup
    begin_s: float
    end_s: float
    shown: Sequence[tuple[float, Waiting]]
    waits: Sequence[Wait]

    def of(self, unit: str) -> list[Wait]:
        return [wait for wait in self.waits if wait.unit == unit]


@cache
def observed(name: str) -> Observed:
    """Run a scenario or drill, and look at every unit whenever something has happened."""
    scenario = load_scenario(find_drill(name) if "/" in name else name)
    shown: list[tuple[float, Waiting]] = []
    with simulation_of(scenario.setup, carrier=CarrierKind.PLAIN) as simulation:
        simulation.begin()
        while simulation.settle() is None:
            shown += [(simulation.now_s, waiting) for waiting in simulation._duties.waiting()]
            simulation.advance()
        result = simulation.finish()
    setup = scenario.setup
    waits = waits_of(result, setup, section_holds(result, setup.line, setup.lengths_m))
    return Observed(
        scenario.setup, result.begin_step / STEPS_PER_S, result.end_step / STEPS_PER_S, shown, waits
    )


DRILLS = (
    "rtri/03_block_held",
    "rtri/05_unit_power_position_unknown",
    "rtri/09_manager_power",
    "rtri/12_terminal_power",
    "rtri/14b_manager_and_units_on_open_line",
    "rtri/20_route_given_back",
    "rtri/21_points_stuck",
    "rtri/40_clock_wrong",
    "rtri/42_doors",
    "rtri/43_brake",
    "rtri/51_not_at_its_mark",
    "rtri/52_unit_frozen",
    "rtri/53_word_without_a_place",
    "rtri/55_unit_dead_for_good",
    "rtri/90_other_track",
    "rtri/91_route_back",
    "rtri/92_ends_early",
    "rtri/92d_ends_early_report_lost",
    "rtri/93_left_out",
    "rtri/95_substitute_working",
    "shigaraki/01_as_it_was",
    "karasuyama/28_unit_restart_out_of_coverage",
    "rtri/102_crossing_link",
    "rtri/103_crossing_barriers_stuck",
    "rtri/104_crossing_undetected",
    "rtri/105_crossing_asked_late",
    "rtri/109_crossing_obstacle",
    "rtri/114_crossing_guarded",
    "rtri/120_crossing_departure",
)
SHIPPED = (
    "rtri_test_line",
    "karasuyama_weekday",
    "karasuyama_without_loop",
    "karasuyama_stressed",
    "busy_line",
)
EVERY_RUN = (  # whose waits are looked at below besides
    "rtri/03_block_held",
    "rtri/05_unit_power_position_unknown",
    "rtri/09_manager_power",
    "rtri/20_route_given_back",
    "rtri/21_points_stuck",
    "rtri/42_doors",
    "rtri/52_unit_frozen",
    "rtri/53_word_without_a_place",
    "rtri/92_ends_early",
    "rtri/103_crossing_barriers_stuck",
    "rtri_test_line",
)
EVERY = pytest.mark.parametrize("name", others_nightly((*DRILLS, *SHIPPED), EVERY_RUN))


@EVERY
def test_every_stock_has_one_wait_at_every_moment(name: str) -> None:
    run = observed(name)
    units = [diagram.stock_id for diagram in run.setup.timetable.diagrams]
    for unit in units:
        waits = run.of(unit)
        assert waits[0].from_s == run.begin_s
        assert waits[-1].to_s == run.end_s
        assert all(wait.to_s > wait.from_s for wait in waits)
        assert all(before.to_s == after.from_s for before, after in pairwise(waits))


@EVERY
def test_every_wait_is_a_sentence(name: str) -> None:
    run = observed(name)
    names = names_of(run.setup.line)
    for wait in run.waits:
        english, japanese = text_of(wait, names).both
        assert english.endswith(".") and japanese.endswith("。")
        assert not re.search(r"None|\{|\}|  | \.|：。|（）", english + japanese)
        assert "\n" not in english + japanese


@EVERY
def test_waits_agree_with_what_units_show(name: str) -> None:
    run = observed(name)
    by_unit: dict[str, list[Wait]] = defaultdict(list)
    for wait in run.waits:
        by_unit[wait.unit].append(wait)
    begins = {unit: [wait.from_s for wait in waits] for unit, waits in by_unit.items()}
    others: list[tuple[float, Waiting, Wait]] = []
    looked = 0
    for t_s, waiting in run.shown:
        if not waiting.stands:
            continue
        looked += 1
        at = bisect_right(begins[waiting.stock_id], t_s) - 1
        wait = by_unit[waiting.stock_id][at]
        causes = next((causes for said, causes in AGREES.items() if re.match(said, waiting.waits_for)), ())
        if wait.cause not in causes:
            others.append((t_s, waiting, wait))
    assert looked > 10
    assert not others, others[:3]


def length_s(wait: Wait) -> float:
    return wait.to_s - wait.from_s


def the(run: Observed, unit: str, cause: Cause, **fields: object) -> Wait:
    """The longest wait of a stock for a cause, with some fields."""
    found = [
        wait
        for wait in run.of(unit)
        if wait.cause is cause and all(getattr(wait, name) == value for name, value in fields.items())
    ]
    assert found, [wait.cause for wait in run.of(unit)]
    return max(found, key=length_s)


def test_a_route_that_another_train_holds_names_it_and_until_when() -> None:
    run = observed("rtri/03_block_held")
    wait = the(run, "K2", Cause.ROUTE_HELD, place="A")
    assert (wait.section, wait.party, wait.party_train, wait.asked) == ("8", "K1", "T1", AwaitedRequest.ROUTE)
    assert wait.from_s == 10 * 3600 + 300  # its departure time, until which it waits for that
    assert wait.until_s == wait.to_s
    assert wait.since_s is not None and wait.since_s < wait.from_s
    names = names_of(run.setup.line)
    assert text_of(wait, names).en.startswith(
        "T3 waits at A for its way: section 8 is held by T1 (K1) since "
    )
    assert "8区間をT1 (K1)が" in text_of(wait, names).ja


def test_who_goes_on_as_another_train_waits_for_the_time_of_that_one() -> None:
    """T1 ends at A by order; T2, which was to begin at B, is to leave A at 10:12."""
    wait = the(observed("rtri/92_ends_early"), "K1", Cause.DEPARTURE_TIME, train="T2")
    assert (wait.place, wait.until_s, wait.to_s) == ("A", 36720.0, 36720.0)


def test_a_manager_without_power_is_named() -> None:
    run = observed("rtri/09_manager_power")
    wait = the(run, "K2", Cause.ANSWER, reason="no power")
    assert (wait.party, wait.asked) == (MANAGER, AwaitedRequest.SIGN_ON)
    refused = the(run, "K2", Cause.REFUSED)  # switched on again, it knows nothing
    assert refused.reason.startswith("undefined")
    assert refused.from_s > wait.to_s


def test_points_that_do_not_move_are_named_with_their_terminal() -> None:
    run = observed("rtri/21_points_stuck")
    wait = the(run, "K1", Cause.POINTS_REFUSED)
    terminal = run.setup.line.points["P7"].terminal_id
    assert (wait.points, wait.section, wait.party, wait.reason) == ("P7", "7", terminal, "not detected")
    assert length_s(wait) > 240.0  # from 10:01 to the repair at 10:06
    slowed = the(run, "K1", Cause.STOP_LIMIT)
    assert (slowed.section, slowed.to_s) == ("7", wait.from_s)


@pytest.mark.parametrize(
    ("drill", "unit", "cause", "fields"),
    [
        ("rtri/42_doors", "K1", Cause.VEHICLE, {"reason": "doors not closed"}),
        ("rtri/43_brake", "K1", Cause.VEHICLE, {"reason": "brake not in order"}),
        ("rtri/05_unit_power_position_unknown", "K1", Cause.UNIT_OFF, {}),
        ("rtri/05_unit_power_position_unknown", "K1", Cause.EMERGENCY, {}),
        ("rtri/20_route_given_back", "K1", Cause.SET_BACK, {}),
        ("rtri/52_unit_frozen", "K1", Cause.UNIT_FROZEN, {}),
        ("rtri/57_motors_on_a_gradient", "K1", Cause.UNABLE, {}),
    ],
)
def test_what_is_out_of_order_is_named(
    drill: str, unit: str, cause: Cause, fields: Mapping[str, object]
) -> None:
    assert length_s(the(observed(drill), unit, cause, **fields)) > 1.0


def test_an_emergency_stop_is_over_when_its_driver_has_acknowledged_it() -> None:
    run = observed("rtri/05_unit_power_position_unknown")
    release_s = run.setup.unit.emergency_release_s
    stands = [wait for wait in run.of("K1") if wait.cause is Cause.EMERGENCY]
    assert stands
    assert all(length_s(wait) <= release_s + 1.0 for wait in stands)
    assert max(map(length_s, stands)) > release_s / 3.0


def test_a_train_before_a_level_crossing_is_not_about_to_start() -> None:
    """The barriers stay up until 10:01, and T1 stands before them; 15 s later they are down, for 15 s at least."""
    run = observed("rtri/103_crossing_barriers_stuck")
    wait = the(run, "K1", Cause.LEVEL_CROSSING)
    assert (wait.party, wait.train, wait.place) == ("C1", "T1", "")
    assert (wait.at_m or 0.0) < 747.0, "before the road"
    assert wait.since_s is not None
    assert wait.since_s < wait.from_s < 10 * 3600 + 60.0 < wait.to_s < 10 * 3600 + 90.0
    assert "level crossing C1" in text_of(wait).en
    assert max(length_s(one) for one in run.of("K1") if one.cause is Cause.STARTING) < 5.0
