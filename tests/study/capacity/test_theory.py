"""Blocking times of theory: two blocks by hand, the parts and the whole, what moves what."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from onboard.duty_parameters import ReleaseRule
from radio.air import AirParameters, DelayShape, on_average
from scenario.scenario import load_scenario
from simulation.people import Pause, People
from simulation.setup import Setup
from study.capacity.links import Links
from study.capacity.occupation import Occupation, OccupationPart, conflicts_of
from study.capacity.rules import AS_UNITS, MINIMAL, VIRTUAL_BLOCKS, Rules
from study.capacity.theory import Theory, occupations
from tests.study.capacity.by_hand import TIMES, two_blocks
from tests.trains import day_of

R, A, G, T, P = (
    OccupationPart.REQUEST,
    OccupationPart.AIR,
    OccupationPart.GRANT,
    OccupationPart.THROW,
    OccupationPart.PROOF,
)
NEAR, READY, RUN, DWELL = (
    OccupationPart.APPROACH,
    OccupationPart.READY,
    OccupationPart.RUN,
    OccupationPart.DWELL,
)
LENGTH, BOUND, RULE, FREE = (
    OccupationPart.LENGTH,
    OccupationPart.BOUND,
    OccupationPart.RULE,
    OccupationPart.RELEASE,
)

# The train signs on 210 s before its departure from A, 0.1 s each way, and asks at once, 0.1 s each way: it leaves the
# portal, whose next section has no points, 0.4 s after. Run of 380 m: 11.3 + 209.747 / 11.3 + 18.833 = 48.695 s,
# and 0.3^2 / (2 0.6 0.6) = 0.125 s more as TASC eases the brake to 0.3 m/s2 before it stands.
#   front 20 m on (joint PW|1)   sqrt(40)                       6.325 s
#         60 m (rear there)      sqrt(120)                     10.954
#         30 m (approach tag)    sqrt(60)                       7.746
#         240 m (joint 1|2)      11.3 + 176.155 / 11.3         26.889
#         280 m (rear there)     48.695 - sqrt(200 / 0.6)      30.438
#         300 m (joint 2|3)      48.695 - sqrt(160 / 0.6)      32.365
#         340 m (rear there)     48.695 - sqrt(80 / 0.6)       37.148
#         352 m (arrival tag)    48.695 - sqrt(56 / 0.6)       39.034
# From A it leaves at its time; the route is asked for 45 s before. 580 m: 11.3 + 409.747 / 11.3 + 18.833 = 66.394 s.
#         30 m (joint 3|5)       sqrt(60)                       7.746
#         70 m (rear there)      11.3 + 6.155 / 11.3           11.845
#         90 m (joint 5|6)       11.3 + 26.155 / 11.3          13.615
#         130 m (rear there)     11.3 + 66.155 / 11.3          17.154
#         230 m (approach tag)   11.3 + 166.155 / 11.3         26.004
#         440 m (joint 6|7)      11.3 + 376.155 / 11.3         44.588
#         480 m (rear there)     66.394 - sqrt(200 / 0.6)      48.137
#         500 m (joint 7|8)      66.394 - sqrt(160 / 0.6)      50.064
#         540 m (rear there)     66.394 - sqrt(80 / 0.6)       54.847
#         552 m (arrival tag)    66.394 - sqrt(56 / 0.6)       56.733
# Points P2 lie right; P5 and P7 lie reverse and are thrown in 6 s. Each tag proves what lies behind at once. The safe
# rear is 0.545 m behind the true one, and a hundredth of the way since the tag before the last.
BY_HAND = {
    "PW": (
        (A, 0.1),
        (G, 0.1),
        (A, 0.1),
        (G, 0.1),
        (RUN, 6.325),
        (LENGTH, 4.629),
        (BOUND, 0.105),
        (RULE, 27.975),
        (FREE, 0.1),
    ),
    "1": (
        (A, 0.1),
        (G, 0.1),
        (NEAR, 6.325),
        (RUN, 20.564),
        (LENGTH, 3.549),
        (BOUND, 0.236),
        (RULE, 8.360),
        (FREE, 0.1),
    ),
    "2": (
        *((A, 0.1), (G, 0.1), (NEAR, 7.746), (A, 0.1), (P, 0.1), (NEAR, 18.943)),
        *((RUN, 5.476), (LENGTH, 4.783), (BOUND, 0.468), (RULE, 1.418), (FREE, 0.1)),
    ),
    "3": (
        *((A, 0.1), (G, 0.1), (NEAR, 32.365), (RUN, 16.455), (DWELL, 160.780)),
        *((RUN, 7.746), (LENGTH, 4.099), (BOUND, 0.125), (RULE, 44.764), (FREE, 0.1)),
    ),
    "5": (
        *((A, 0.1), (G, 0.1), (A, 0.1), (T, 6.0), (P, 0.1), (READY, 38.6), (NEAR, 7.746)),
        *((RUN, 5.869), (LENGTH, 3.539), (BOUND, 0.167), (RULE, 39.412), (FREE, 0.1)),
    ),
    "6": (
        *((A, 0.1), (G, 0.1), (READY, 44.8), (NEAR, 13.615)),
        *((RUN, 30.973), (LENGTH, 3.549), (BOUND, 0.236), (RULE, 8.360), (FREE, 0.1)),
    ),
    "7": (
        *((A, 0.1), (G, 0.1), (READY, 44.8), (NEAR, 26.004), (A, 0.1), (T, 6.0), (P, 0.1), (NEAR, 12.384)),
        *((RUN, 5.476), (LENGTH, 4.783), (BOUND, 0.468), (RULE, 1.418), (FREE, 0.1)),
    ),
    "8": ((A, 0.1), (G, 0.1), (READY, 44.8), (NEAR, 50.064), (RUN, 16.455), (OccupationPart.LAYOVER, 0.0)),
}


def by_id(found: tuple[Occupation, ...]) -> dict[str, Occupation]:
    return {one.section_id: one for one in found}


def test_two_blocks_agree_with_the_pencil_to_a_tenth_of_a_second(tmp_path: Path) -> None:
    found = by_id(occupations(_at_once(two_blocks(tmp_path))))
    assert set(found) == set(BY_HAND)
    for section_id, hand in BY_HAND.items():
        slices = found[section_id].slices
        assert [s.part for s in slices] == [part for part, _ in hand], section_id
        for made, (part, length_s) in zip(slices, hand, strict=True):
            assert made.length_s == pytest.approx(length_s, abs=0.1), (section_id, part)
        assert found[section_id].length_s == pytest.approx(sum(s for _, s in hand), abs=0.1), section_id


def test_by_section_each_tag_gives_back_what_it_proves(tmp_path: Path) -> None:
    """The rear has left sections 3 and 5 11.845 and 17.154 s after the departure. Tag 601, 95 m from the mark, is read
    11.3 + 31.155 / 11.3 = 14.057 s after it, the approach tag at 26.004 s; 6 and 7 go at the arrival tag, as with a
    whole route; each 0.1 s on the air.
    """
    setup = _at_once(two_blocks(tmp_path))
    by_section = setup.operation.model_copy(update={"release": ReleaseRule.SECTION})
    found = by_id(occupations(replace(setup, operation=by_section)))
    ends_s = {section_id: found[section_id].end_s - 36_000.0 for section_id in ("3", "5", "6", "7")}
    hand_s = {"3": 14.157, "5": 26.104, "6": 56.833, "7": 56.833}
    assert ends_s == {section_id: pytest.approx(s, abs=0.1) for section_id, s in hand_s.items()}


def _at_once(setup: Setup) -> Setup:
    """The same with people who take no time."""
    return replace(setup, people=People(times=0.0))


@pytest.mark.parametrize("rules", [AS_UNITS, MINIMAL, VIRTUAL_BLOCKS])
def test_a_portal_is_had_while_the_crew_takes_its_train_in(tmp_path: Path, rules: Rules) -> None:
    """The crew enters the number before the portal is asked for; the route beyond is set as the train comes in."""
    setup = replace(two_blocks(tmp_path), people=People(sign_on_s=30.0, entry_s=5.0))
    slow, quick = (by_id(occupations(one, rules)) for one in (setup, _at_once(setup)))
    assert slow["PW"].enters_s - slow["PW"].begin_s == pytest.approx(0.2 + 5.0, abs=1e-6)
    assert slow["PW"].length_s - quick["PW"].length_s == pytest.approx(5.0 - 0.2, abs=1e-6)
    if rules is AS_UNITS:
        assert slow["PW"].begin_s - quick["PW"].begin_s == pytest.approx(30.0, abs=1e-6)


@pytest.mark.parametrize("rules", [AS_UNITS, MINIMAL])
def test_a_portal_is_had_until_the_crew_has_left_through_it(rules: Rules) -> None:
    setup = load_scenario("karasuyama_weekday").setup
    taken_s = setup.people.mean_s(Pause.SIGN_OFF) + setup.people.mean_s(Pause.LEAVE)
    slow, quick = (
        {one.number: one for one in occupations(made, rules) if one.section_id == "HSK.MU"}
        for made in (setup, _at_once(setup))
    )
    assert slow.keys() == quick.keys() != set()
    for number, one in slow.items():
        left_s = one.end_s - one.enters_s, quick[number].end_s - quick[number].enters_s
        assert left_s[0] - left_s[1] == pytest.approx(taken_s, abs=1e-6)


def test_parts_and_costs_make_up_the_whole(tmp_path: Path) -> None:
    for rules in (AS_UNITS, MINIMAL, VIRTUAL_BLOCKS):
        for one in occupations(two_blocks(tmp_path), rules):
            assert math.fsum(one.of_part(part) for part in OccupationPart) == pytest.approx(
                one.length_s, abs=1e-6
            )
            assert math.fsum(one.costs_s().values()) == pytest.approx(one.length_s, abs=1e-6)


def test_half_the_throw_time_moves_what_the_parts_say(tmp_path: Path) -> None:
    """As units ask, the train stands ready, or comes nearer, for longer; set as late as it can be, all is shorter."""
    whole, half = (by_id(occupations(two_blocks(tmp_path, throw_share=s))) for s in (1.0, 0.5))
    for section_id in ("5", "7"):
        before, after = whole[section_id], half[section_id]
        gained_s = before.of_part(T) - after.of_part(T)
        assert gained_s == pytest.approx(3.0, abs=1e-6)
        assert after.of_part(READY) + after.of_part(NEAR) == pytest.approx(
            before.of_part(READY) + before.of_part(NEAR) + gained_s, abs=1e-6
        )
        assert after.length_s == pytest.approx(before.length_s, abs=1e-6)
    whole, half = (by_id(occupations(two_blocks(tmp_path, throw_share=s), MINIMAL)) for s in (1.0, 0.5))
    for section_id in ("5", "6", "7", "8"):  # one route, had whole
        gained_s = whole["5"].of_part(T) - half["5"].of_part(T)
        assert whole[section_id].length_s - half[section_id].length_s == pytest.approx(gained_s, abs=1e-6)


def test_set_as_late_as_it_can_be(tmp_path: Path) -> None:
    """A standing train has its way proven when it leaves; a running one where it would have to brake for the joint.

    At 11.3 m/s that is 15 m and 11.3^2 / 1.2 before it: 318.592 m from the mark at A, 33.844 s after the departure.
    """
    minimal = by_id(occupations(two_blocks(tmp_path), MINIMAL))
    leaves_s = 36_000.125  # it stands at A so much later by the soft end of its stop
    assert [s.part for s in minimal["5"].slices[:6]] == [A, G, A, T, P, NEAR]
    assert minimal["5"].slices[4].end_s == pytest.approx(leaves_s, abs=1e-3)
    blocks = by_id(occupations(two_blocks(tmp_path), VIRTUAL_BLOCKS))
    proofs = [s for s in blocks["7"].slices if s.part is P]
    assert proofs[-1].end_s == pytest.approx(leaves_s + 33.844, abs=0.1)
    assert blocks["7"].begin_s == pytest.approx(leaves_s + 33.844 - 6.4, abs=0.1)
    assert blocks["6"].end_s < minimal["6"].end_s - 5.0  # freed by its own rear, not at the arrival tag


def test_radio_moves_its_own_parts_alone(tmp_path: Path) -> None:
    """A telegram that takes 2.0 s instead of 0.1 s, constant: five of them lead to a proven route."""
    setup = two_blocks(tmp_path)
    slow = setup.air.model_copy(update={"delay_mean_s": 2.0, "delay_shape": DelayShape.CONSTANT})
    quick, late = (by_id(occupations(made, MINIMAL)) for made in (setup, replace(setup, air=slow)))
    for one, other in ((quick["5"], late["5"]),):
        assert other.of_part(A) - one.of_part(A) == pytest.approx(2 * 1.9, abs=1e-6)
        for part in (G, P, FREE):
            assert other.of_part(part) - one.of_part(part) == pytest.approx(1.9, abs=1e-6)
        assert other.length_s - one.length_s == pytest.approx(5 * 1.9, abs=1e-6)


def test_moved_journeys_move_their_occupations(tmp_path: Path) -> None:
    theory = Theory(two_blocks(tmp_path), MINIMAL)
    (journey,) = theory.journeys()["K1"]
    before = theory.of_day({"K1": (journey,)})
    after = theory.of_day({"K1": (journey.moved(100.0),)})
    assert len(before) == len(after) == 8
    for one, other in zip(before, after, strict=True):
        assert other.begin_s == pytest.approx(one.begin_s + 100.0, abs=1e-6)
        assert other.length_s == pytest.approx(one.length_s, abs=1e-6)


TURNS = TIMES.replace('"stabled"', '"becomes:T2"').replace('["T1"]', '["T1", "T2"]') + day_of(
    "T2 up, from:T1 to stabled: B 1 -/10:01:20; A 1 10:03:00/-"
)


@pytest.mark.parametrize("change_s", [30.0, 60.0])
def test_a_set_asks_for_its_way_back_when_its_ends_are_changed(tmp_path: Path, change_s: float) -> None:
    """It stands at B at 10:01:06.519, has given back all behind it, and would ask 45 s before 10:01:20."""
    setup = _at_once(two_blocks(tmp_path, times=TURNS))
    setup = replace(setup, operation=setup.operation.model_copy(update={"change_ends_s": change_s}))
    (back,) = (one for one in occupations(setup) if (one.section_id, one.number) == ("6", "T2"))
    assert back.begin_s == pytest.approx(36_000.0 + 66.519 + change_s, abs=0.1)


def test_a_set_that_turns_back_keeps_its_track() -> None:
    """One occupation from the route in to the release behind it, with change of ends and layover."""
    found = occupations(load_scenario("karasuyama_weekday").setup)
    assert conflicts_of(found) == ()
    turned = next(one for one in found if one.section_id == "KRS.1" and one.number == "321M")
    parts = [s.part for s in turned.slices]
    assert parts.index(OccupationPart.CHANGE_ENDS) < parts.index(OccupationPart.LAYOVER) < parts.index(LENGTH)
    assert turned.of_part(OccupationPart.CHANGE_ENDS) == pytest.approx(60.0)
    alone = [one for one in found if one.section_id == "KRS.1" and one.number == "324M"]
    assert alone == []  # it is in the occupation of the train that it was


def test_charging_is_part_of_the_occupation() -> None:
    found = occupations(load_scenario("karasuyama_battery").setup)
    turned = next(one for one in found if one.section_id == "KRS.1" and one.number == "321M")
    assert turned.of_part(OccupationPart.CHARGING) > 600.0
    assert turned.of_part(OccupationPart.CHANGE_ENDS) == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("air", "mean_s"),
    [
        (AirParameters(), 0.1),
        (AirParameters(delay_min_s=0.1, delay_mean_s=0.25, delay_shape=DelayShape.CONSTANT), 0.3),
        # 0.1 s and an exponential tail of 0.1 s, rounded up: 0.1 + 0.1 / (1 - 1 / e)
        (AirParameters(delay_min_s=0.1, delay_mean_s=0.2), 0.2581977),
    ],
)
def test_mean_delay_counts_whole_steps(air: AirParameters, mean_s: float) -> None:
    assert air.mean_delay_s() == pytest.approx(mean_s, abs=1e-6)
    assert Links.of(on_average(air, None)).delay_s == pytest.approx(mean_s, abs=1e-6)


def test_lost_telegrams_cost_repeats() -> None:
    half = Links.of(on_average(AirParameters(loss_good_p=0.5), None))
    assert half.request_s == pytest.approx(2.0)  # as many again as get through, 2 s each
    assert half.answer_s == pytest.approx(4.0)


def test_rules_are_told_apart() -> None:
    assert Rules() == AS_UNITS != MINIMAL != VIRTUAL_BLOCKS
