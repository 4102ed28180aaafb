"""Where a train has called is judged by where it truly stands; what its unit believes is never asked."""

from dataclasses import replace

import pytest

from network.model import Direction
from network.timetable import Call, Stabled, TimetableTrain
from onboard.mission import plan_mission
from simulation.carriers.plain_track import PlainTrack
from simulation.result import EnergyPhase
from simulation.setup import STEP_S, Setup
from simulation.tolerance import CALLS_BEYOND_M
from simulation.world.books import Books
from simulation.world.roster import Duty, draw_up
from simulation.world.trains import Trains

MARK_B_M = 660.0  # km 1.02 on a path that begins at km 0.36; the track of B ends at 690 m


# platform of B, train and mark: where the whole train is alongside
REAR_AT_PLATFORM_M = 965.0 + 40.0 - 1020.0


class Desk:
    """One train on the paper's line, put wherever a test wants it, and the books that are kept of it."""

    def __init__(self, setup: Setup, duty: Duty) -> None:
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
        self.books = Books(self.trains)
        self.trains.place(0, duty)
        self.books.begin_train(0, duty, 0)

    def stand_at(self, position_m: float, now_s: float = 100.0) -> None:
        self.trains.truths[0].position_m = position_m
        self.books.look_for_arrival(0, now_s)

    def called(self) -> int:
        return self.books.next_target(0) - 1


@pytest.fixture
def duty(rtri_setup: Setup) -> Duty:
    return draw_up(rtri_setup.line, rtri_setup.timetable, {"K1": 40.0}, 0.0)["K1"][0]


@pytest.fixture
def desk(rtri_setup: Setup, duty: Duty) -> Desk:
    return Desk(rtri_setup, duty)


@pytest.mark.parametrize(
    ("away_m", "calls"),
    [
        (REAR_AT_PLATFORM_M - 0.1, False),  # its rear is not yet at the platform
        (REAR_AT_PLATFORM_M + 0.1, True),
        (0.0, True),
        (CALLS_BEYOND_M - 0.1, True),
        (CALLS_BEYOND_M + 0.1, False),
    ],
)
def test_who_stands_near_enough_to_the_mark_has_arrived(desk: Desk, away_m: float, calls: bool) -> None:
    desk.stand_at(MARK_B_M + away_m)
    assert desk.called() == calls
    assert desk.books.arrived == (["T1"] if calls else [])
    if calls:
        (_, stop) = desk.books.stops
        assert stop.error_m == pytest.approx(away_m)
        assert stop.arrival_s == 100.0


def test_who_moves_through_has_not_arrived(desk: Desk) -> None:
    desk.trains.plants[0].speed_mps = 0.1
    desk.stand_at(MARK_B_M)
    assert desk.called() == 0
    assert desk.books.stands_at(0) is None


def test_who_stands_on_another_track_has_not_arrived(desk: Desk) -> None:
    """Points have sent it to section 9, as far along as its mark on section 8."""
    desk.trains.truths[0].position_m = 529.99
    desk.trains.set_boundaries(0)
    desk.trains.carrier.run([("K1", [449.99 / STEP_S])], 1)
    desk.trains.divert(0, "P7.reverse")
    desk.stand_at(MARK_B_M)
    assert desk.called() == 0
    assert desk.books.arrived == []


def test_the_units_own_belief_is_not_asked(desk: Desk) -> None:
    desk.trains.units[0].position_m = 0.0
    desk.trains.units[0].position_known = 0
    desk.stand_at(MARK_B_M)
    assert desk.called() == 1


def three_stops(setup: Setup) -> Duty:
    """Up from B by A's track to the western portal; what it misses, it goes past."""
    calls = (Call("B", "1", None, 100.0), Call("A", None, 200.0, 220.0))
    train = TimetableTrain("T2", Direction.UP, True, calls, Stabled(), Stabled())
    mission = plan_mission(setup.line, train, "8", "PW", None)
    return Duty("K1", train, mission, False, 100.0, True, None)


def test_a_missed_stop_stays_missed(rtri_setup: Setup) -> None:
    """Beyond the next call at the one after it: that one counts, and the call missed has no record."""
    duty = three_stops(rtri_setup)
    desk = Desk(rtri_setup, duty)
    assert len(duty.mission.targets) == 3
    desk.stand_at(duty.mission.targets[2].mark_m)
    assert desk.called() == 2
    assert [stop.station_id for stop in desk.books.stops] == ["B"]
    desk.stand_at(duty.mission.targets[1].mark_m)  # and never back
    assert desk.called() == 2


def test_a_departure_is_when_it_truly_moves(desk: Desk) -> None:
    (first,) = desk.books.stops
    desk.books.look_for_departure(0, 50.0)
    assert first.departure_s is None
    desk.trains.plants[0].speed_mps = 0.01
    desk.books.look_for_departure(0, 51.0)
    desk.books.look_for_departure(0, 52.0)
    assert first.departure_s == 51.0


def test_where_a_train_stands_is_what_its_crew_enters_after_a_power_cut(desk: Desk) -> None:
    assert desk.books.stands_at(0) == 0
    desk.trains.truths[0].position_m = MARK_B_M - 100.0
    assert desk.books.stands_at(0) is None
    desk.stand_at(MARK_B_M + 1.0)
    assert desk.books.stands_at(0) == 1


def test_energy_is_booked_to_the_train_that_used_it(desk: Desk, duty: Duty) -> None:
    desk.trains.plants[0].energy_traction_j = 5e6
    desk.books.close_energy(0, 10)
    desk.trains.plants[0].energy_traction_j = 6e6  # between two trains: nobody's
    desk.books.begin_train(0, replace(duty, train=replace(duty.train, number="T3")), 20)
    desk.trains.plants[0].energy_traction_j = 7e6
    desk.books.close_energy(0, 30)
    assert [(e.number, e.counted_j["traction"]) for e in desk.books.energy] == [("T1", 5e6), ("T3", 1e6)]


def test_the_step_in_which_a_train_begins_to_move_is_running(desk: Desk) -> None:
    """It stood for 100 steps before; its auxiliaries of the 101st, and the first traction, belong to the run."""
    power_w, plant = float(desk.trains.bodies[0].auxiliary_power_w), desk.trains.plants[0]
    plant.energy_auxiliary_j = power_w * 101 * STEP_S
    plant.energy_traction_j, plant.speed_mps = 40.0, 0.01
    desk.books.look_for_departure(0, 10.1)
    desk.books.close_energy(0, 101)
    stood, ran = desk.books.energy
    assert (stood.phase, stood.counted_j["auxiliary"], stood.end_s) == (
        EnergyPhase.LAYOVER,
        pytest.approx(power_w * 10.0),
        10.0,
    )
    assert (stood.counted_j["traction"], ran.counted_j["traction"]) == (0.0, 40.0)
    assert (ran.phase, ran.counted_j["auxiliary"]) == (EnergyPhase.RUNNING, pytest.approx(power_w * STEP_S))


def test_a_leg_ends_where_the_train_truly_calls(desk: Desk) -> None:
    plant = desk.trains.plants[0]
    for position_m, now_s in ((MARK_B_M - 200.0, 50.0), (MARK_B_M, 90.0)):
        plant.speed_mps = 5.0
        desk.books.look_for_departure(0, now_s - 10.0)
        plant.speed_mps = 0.0
        desk.stand_at(position_m, now_s)
    desk.books.close_energy(0, 1000)
    told = [(e.phase, e.from_id, e.to_id) for e in desk.books.energy]
    assert told == [
        (EnergyPhase.LAYOVER, "A", "A"),
        (EnergyPhase.RUNNING, "A", "B"),
        (EnergyPhase.HELD, "A", "B"),  # it stood 200 m before the mark
        (EnergyPhase.RUNNING, "A", "B"),
        (EnergyPhase.LAYOVER, "B", "B"),
    ]


def test_a_train_that_draws_up_to_its_mark_calls_once(desk: Desk) -> None:
    """It stood along the platform, then went on to its mark: that is where it has arrived, and when."""
    desk.stand_at(MARK_B_M - 10.0, now_s=100.0)
    desk.trains.plants[0].speed_mps = 1.0
    desk.books.look_for_departure(0, 105.0)
    desk.trains.plants[0].speed_mps = 0.0
    desk.stand_at(MARK_B_M, now_s=115.0)
    (_, stop) = desk.books.stops
    assert (stop.arrival_s, stop.departure_s) == (115.0, None)
    assert stop.error_m == pytest.approx(0.0)
    assert desk.books.arrived == ["T1"]
