from dataclasses import replace

import numpy as np
import pytest

from network.model import Direction
from network.timetable import Call, Diagram, Stabled, TimetableTrain
from onboard.mission import plan_mission
from simulation.carriers.plain_track import PlainTrack
from simulation.scatter import ScatterSettings, Weather
from simulation.sensors.tag_reader import latch
from simulation.setup import STEP_S, Setup
from simulation.world.roster import Duty, draw_up
from simulation.world.trains import AGREEMENT_M, CarrierDisagrees, Trains

LENGTH_M = 40.0
MARK_A_M, MARK_B_M = 80.0, 660.0  # km 0.44 and km 1.02 on a path that begins at km 0.36


def plain(setup: Setup) -> PlainTrack:
    return PlainTrack({p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}, STEP_S)


def first_duty(setup: Setup) -> Duty:
    return draw_up(setup.line, setup.timetable, {"K1": LENGTH_M}, setup.operation.portal_lead_s)["K1"][0]


@pytest.fixture
def placed(rtri_setup: Setup) -> Trains:
    trains = Trains(rtri_setup, plain(rtri_setup))
    assert trains.active() == []
    trains.place(0, first_duty(rtri_setup))
    return trains


def moved(trains: Trains, run_m: float) -> None:
    """Move the truth of stock 0 as the kernel does, and the carrier by the same distance."""
    truth, plant = trains.truths[0], trains.plants[0]
    plant.travelled_m += run_m
    truth.position_m = truth.offset_m + plant.travelled_m
    trains.carrier.run([("K1", [run_m / STEP_S, 0.0])], 2)


def test_a_stock_stands_at_its_first_mark(placed: Trains) -> None:
    truth = placed.truths[0]
    assert placed.active() == [0]
    assert truth.position_m == pytest.approx(MARK_A_M)
    assert placed.units[0].position_known == 0  # putting it there tells its unit nothing
    assert placed.kilometrage_m(0) == pytest.approx(440.0)
    assert placed.direction(0) is Direction.DOWN
    assert placed.reached("K1") == (True,)
    assert (truth.front_boundary_m, truth.rear_boundary_m) == pytest.approx((110.0, 110.0))
    assert placed.pool.tag_ids[truth.tag_next] == 601  # those behind the front are passed
    assert placed.carrier.truth("K1").offset_m == pytest.approx(MARK_A_M)


def test_before_it_is_on_the_line(rtri_setup: Setup) -> None:
    trains = Trains(rtri_setup, plain(rtri_setup))
    with pytest.raises(RuntimeError, match="K1 is not on the line"):
        trains.true_path(0)
    assert trains.reached("K1") == (True,)  # who is not on the line is taken to be reached


def test_the_carrier_is_the_judge_of_the_position(placed: Trains) -> None:
    moved(placed, 40.0)
    placed.compare([0], [placed.carrier.truth("K1")])
    assert placed.truths[0].position_m == pytest.approx(MARK_A_M + 40.0)
    placed.truths[0].position_m += 2.0 * AGREEMENT_M
    with pytest.raises(CarrierDisagrees, match=r"K1: carrier has it at 120\.000000 m"):
        placed.compare([0], [placed.carrier.truth("K1")])


def test_the_next_joints_of_front_and_rear(placed: Trains) -> None:
    """Section 3 ends at 110 m, the leg of P5 at 160 m, its stem at 170 m."""
    moved(placed, 35.0)
    placed.set_boundaries(0)
    truth = placed.truths[0]
    assert (truth.front_boundary_m, truth.rear_boundary_m) == pytest.approx((160.0, 110.0))
    assert placed.crossing(0) == ("P5.normal", "P5.stem")
    moved(placed, 50.0)
    placed.set_boundaries(0)
    assert (truth.front_boundary_m, truth.rear_boundary_m) == pytest.approx((170.0, 160.0))
    moved(placed, 500.0)
    placed.set_boundaries(0)
    assert truth.front_boundary_m == pytest.approx(690.0)  # the mission ends there, the track goes on
    end_m = placed.true_path(0).length_m
    assert end_m > 690.0 and not placed.at_end_of_track(0)
    truth.position_m = end_m
    assert placed.at_end_of_track(0)


def back_duty(setup: Setup) -> Duty:
    calls = (Call("B", "1", None, 36_300), Call("A", None, 36_400, None))
    train = TimetableTrain("T2", Direction.UP, True, calls, Stabled(), Stabled())
    mission = plan_mission(setup.line, train, "8", None, None)
    return Duty("K1", train, mission, False, 36_300.0, False, None)


def test_changing_ends(placed: Trains, rtri_setup: Setup) -> None:
    """Front at km 1.02 going down: going up it is where the rear was, at km 0.98, 70 m from section 8's end."""
    moved(placed, MARK_B_M - MARK_A_M)
    unit, truth = placed.stock["board"]["unit"].copy(), placed.truths[0]
    placed.turn(0, back_duty(rtri_setup))
    assert placed.direction(0) is Direction.UP
    assert placed.kilometrage_m(0) == pytest.approx(980.0)
    assert truth.position_m == pytest.approx(70.0)
    # what its unit believes is the unit's own affair
    assert np.array_equal(placed.stock["board"]["unit"], unit)
    placed.compare([0], [placed.carrier.truth("K1")])
    assert placed.pool.tag_ids[truth.tag_next] == 851


@pytest.mark.parametrize(("at_m", "turns"), [(980.0, True), (965.0, True), (1051.0, False)])
def test_it_turns_where_all_of_it_is_on_its_way_back(
    placed: Trains, rtri_setup: Setup, at_m: float, turns: bool
) -> None:
    """At km 0.965 its rear is still on the points that it goes back over, at km 1.051 its front on those ahead."""
    moved(placed, at_m - 440.0)
    assert placed.can_turn(0, back_duty(rtri_setup)) is turns
    if turns:
        placed.turn(0, back_duty(rtri_setup))
        assert placed.kilometrage_m(0) == pytest.approx(at_m - 40.0)
        placed.compare([0], [placed.carrier.truth("K1")])


def test_it_does_not_turn_with_its_rear_on_a_way_that_it_does_not_go_back(
    placed: Trains, rtri_setup: Setup
) -> None:
    """It came over the reverse leg and is to go back over the normal one."""
    moved(placed, 965.0 - 440.0)
    placed.pieces_under = lambda _slot: {"8", "P7.reverse"}  # type: ignore[method-assign]
    assert not placed.can_turn(0, back_duty(rtri_setup))


def test_going_on_as_another_train(placed: Trains, rtri_setup: Setup) -> None:
    moved(placed, MARK_B_M - MARK_A_M)
    train = replace(
        rtri_setup.timetable.trains["T1"],
        number="T9",
        calls=(Call("B", "1", None, 0), Call("B", "1", 9, None)),
    )
    mission = plan_mission(rtri_setup.line, train, "8", "PE", None)
    placed.continue_as(0, Duty("K1", train, mission, False, 0.0, True, None))
    assert placed.kilometrage_m(0) == pytest.approx(1020.0)
    assert placed.truths[0].position_m == pytest.approx(80.0)
    placed.compare([0], [placed.carrier.truth("K1")])


def test_a_wrong_way_at_points_is_followed_by_the_truth_only(placed: Trains) -> None:
    moved(placed, 440.0 + 9.99)  # before the toe of P7, at 530 m
    placed.set_boundaries(0)
    assert placed.crossing(0) == ("P7.stem", "P7.normal")
    placed.divert(0, "P7.reverse")
    assert "P7.reverse" in placed.true_path(0)
    assert "9" in placed.true_path(0)
    duty = placed.duties[0]
    assert duty is not None
    assert "P7.reverse" not in duty.mission.path
    moved(placed, 20.0)
    assert placed.carrier.truth("K1").piece_id == "P7.reverse"
    placed.compare([0], [placed.carrier.truth("K1")])


def test_a_section_is_occupied_by_what_truly_stands_there(placed: Trains) -> None:
    """40 m long, its front at 80 m of the path: wholly on section 3, which ends at 110 m; P5's section is next."""
    assert placed.stands_in("3") and not placed.stands_in("5")
    moved(placed, 35.0)
    assert placed.stands_in("3") and placed.stands_in("5")
    moved(placed, 40.0)  # its rear at 115 m
    assert not placed.stands_in("3") and placed.stands_in("5")
    placed.remove(0)
    assert not placed.stands_in("5")


def test_leaving_the_line(placed: Trains) -> None:
    placed.remove(0)
    assert placed.active() == []
    assert placed.reached("K1") == (True,)
    with pytest.raises(RuntimeError):
        placed.true_path(0)


def test_tags_come_one_by_one_with_an_error_within_what_the_reader_keeps(placed: Trains) -> None:
    reader, tachometer = placed.tag_readers[0], placed.tachometers[0]
    tachometer.turned_m = 1000.0
    for step, tag_id in enumerate((601, 602, 603)):
        placed.stock[0]["scene"]["step"] = step
        latch(reader, tachometer, placed.stock.view(np.recarray)[0].scene, 0.0)
        passed, read, odometer_m = placed.read_tag(0)
        assert passed == read == tag_id
        error_m = placed.setup.sensors.tag_read_max_m + tachometer.pulse_m
        assert abs(odometer_m - 1000.0) <= error_m
    placed.tag_faults |= {701: None, 801: 9999}
    assert placed.read_tag(0)[:2] == (701, None)
    assert placed.read_tag(0)[:2] == (801, 9999)


def test_chance_belongs_to_the_stock_whatever_else_runs(rtri_setup: Setup) -> None:
    """The same wheels and load with another stock in front of it; other ones with another seed."""
    timetable = rtri_setup.timetable
    two = replace(timetable, diagrams=(Diagram("K0", ()), *timetable.diagrams))
    kind = rtri_setup.trains["K1"]
    more = replace(rtri_setup, timetable=two, trains={"K0": kind, "K1": kind})
    alone, beside = Trains(rtri_setup, plain(rtri_setup)), Trains(more, plain(more))
    other = Trains(replace(rtri_setup, seed=2), plain(rtri_setup))
    alone.place(0, first_duty(rtri_setup))
    beside.place(1, first_duty(rtri_setup))
    assert (
        alone.tachometers[0].wheel_factor
        == beside.tachometers[1].wheel_factor
        != other.tachometers[0].wheel_factor
    )
    assert alone.plants[0].load_share == beside.plants[1].load_share
    sigma = rtri_setup.sensors.wheel_factor_sigma
    assert abs(alone.tachometers[0].wheel_factor - 1.0) <= 3.0 * sigma


def test_the_weather_stays_under_a_slippery_rail_and_comes_back_after_it(rtri_setup: Setup) -> None:
    """Drawn anew for each leg, whether a fault is in force or not."""
    wet = ScatterSettings(
        weather=(
            Weather.model_validate(
                {"from": "00:00", "to": "24:00", "adhesion_low": 0.4, "adhesion_high": 0.8}
            ),
        )
    )
    placed = Trains(replace(rtri_setup, scatter=wet), plain(rtri_setup))
    placed.place(0, first_duty(rtri_setup))
    plant, now_s = placed.plants[0], 36_000.0
    placed.begin_leg(0, now_s)
    weather = float(plant.adhesion_factor)
    assert 0.4 <= weather <= 0.8
    placed.set_rail(0, 0.5)
    assert plant.adhesion_factor == pytest.approx(0.5 * weather)
    placed.begin_leg(0, now_s)
    assert 0.2 <= plant.adhesion_factor <= 0.4
    drawn = 2.0 * float(plant.adhesion_factor)
    assert drawn != pytest.approx(weather)
    placed.set_rail(0, 1.0)
    assert plant.adhesion_factor == pytest.approx(drawn)


@pytest.mark.parametrize("reserve", [0.0, 0.5, 1.0])
def test_a_brake_loses_no_more_than_it_has_beyond_what_supervision_counts_on(
    rtri_setup: Setup, reserve: float
) -> None:
    spread = ScatterSettings(brake_sigma=0.1, brake_leg_sigma=0.1)
    placed = Trains(replace(rtri_setup, scatter=spread), plain(rtri_setup))
    placed.place(0, first_duty(rtri_setup))
    plant, driving = placed.plants[0], rtri_setup.driving
    whole = float(plant.brake_factor)
    placed.set_brake(0, reserve)
    service, emergency = float(plant.brake_factor), float(plant.emergency_factor)
    if whole > driving.service_guaranteed_share:
        assert driving.service_guaranteed_share <= service <= whole
    assert emergency == pytest.approx(1.0 - (1.0 - reserve) * (1.0 - driving.emergency_guaranteed_share))
    placed.set_brake(0, 1.0)
    assert (plant.brake_factor, plant.emergency_factor) == (whole, 1.0)


@pytest.mark.parametrize(("cut_out", "share"), [(0, 1.0), (1, 0.75), (3, 0.25), (4, 0.0), (64, 0.0)])
def test_what_motors_pulled_that_are_cut_out_is_gone_at_once(
    placed: Trains, cut_out: int, share: float
) -> None:
    """Four motors; else force without a motor behind it would spin the wheels."""
    placed.plants[0].traction_built_n = 40_000.0
    placed.set_motors(0, cut_out)
    assert placed.plants[0].motors_share == share
    assert placed.plants[0].traction_built_n == pytest.approx(40_000.0 * share)
    placed.set_motors(0, 0)
    assert placed.plants[0].motors_share == 1.0
    assert placed.plants[0].traction_built_n == pytest.approx(40_000.0 * share)  # it builds up again
    placed.plants[0].traction_built_n = 0.0
