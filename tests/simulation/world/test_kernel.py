"""The compiled loop on the plain carrier: a unit driven by hand from A to the arrival points of B."""

import numpy as np
import pytest

from host.units import LocalUnits
from network.profile import PROFILE
from onboard.records import EVENT_MOVING, EVENT_STOPPED, MODE_DRIVE, MODE_HOLD
from simulation.carriers.plain_track import PlainTrack
from simulation.setup import STEP_S, Setup, unit_configs
from simulation.world import records
from simulation.world.kernel import advance, new_sheet, passed_in_step, track_under
from simulation.world.on_board import OnBoard
from simulation.world.roster import draw_up
from simulation.world.trains import Trains

STEPS, EVERY = 50, 10


class Bench:
    """One train, free up to 480 m of its path; the kernel and the plain carrier take turns."""

    def __init__(self, setup: Setup, speed_mps: float = 12.0) -> None:
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
        duty = draw_up(setup.line, setup.timetable, {"K1": 40.0}, 0.0)["K1"][0]
        self.trains.place(0, duty)
        on_board = OnBoard(setup, self.trains, LocalUnits(unit_configs(setup, b"k" * 32)))
        on_board.enter_number(0, duty, comes_on_line=True, turned=False)
        unit = self.trains.units[0]
        unit.mode, unit.stop_limit_m, unit.target_stop_m, unit.cruise_mps = (
            MODE_DRIVE,
            520.0,
            480.0,
            speed_mps,
        )
        unit.expected_tag_m = unit.rear_trigger_m = unit.position_trigger_m = unit.restricted_mps = np.inf
        self.sheet = new_sheet(1)
        self.trace = np.zeros(5000, dtype=records.TRACE)
        self.used, self.step = 0, 0
        self.seen: list[int] = []

    def advance(self, steps: int = STEPS) -> int:
        """One turn; returns the events."""
        trains, pool = self.trains, self.trains.pool
        done, self.used, movers = advance(
            trains.stock, pool.track, self.sheet, self.trace, self.used, self.step, steps
        )
        self.course = self.sheet.speeds_mps[:movers, :done].tolist()
        trains.carrier.run([("K1", course) for course in self.course], done)
        self.step += done
        trains.compare([0], [trains.carrier.truth("K1")])
        self.passed, events = int(self.sheet.passed[0]), int(self.sheet.events[0])
        if self.passed & records.PASSED_TAG:
            tag_id, _, odometer_m = trains.read_tag(0)
            self.seen.append(tag_id)
            tag_m = trains.pool.tag_positions_m[int(trains.truths[0].tag_next) - 1]
            # By the true circumference the wheel had run to the tag; the reader errs by 0.2 m at the most.
            run_m = (odometer_m - self.first_odometer_m) * float(trains.tachometers[0].wheel_factor)
            assert run_m == pytest.approx(tag_m - 80.0, abs=0.25)
        if self.passed & (records.PASSED_FRONT | records.PASSED_REAR):
            trains.set_boundaries(0)
        return events

    first_odometer_m = 0.0


def test_the_carrier_executes_what_the_kernel_ran_ahead(rtri_setup: Setup) -> None:
    """`compare` holds the two to a micrometre at every turn; every joint and tag up to the stop is reported."""
    bench = Bench(rtri_setup)
    fronts = rears = 0
    events = 0
    for _ in range(400):
        events = bench.advance()
        fronts += bench.passed & records.PASSED_FRONT > 0
        rears += bench.passed & records.PASSED_REAR > 0
        if events & EVENT_STOPPED:
            break
    assert events & EVENT_STOPPED
    assert bench.trains.truths[0].position_m == pytest.approx(480.0, abs=4.0)  # without tags: 1 % of 400 m
    assert bench.seen == [601, 602, 603]
    assert (fronts, rears) == (3, 3)  # out of section 3, the leg and the stem of P5


def test_standing_and_going_are_told_by_the_truth(rtri_setup: Setup) -> None:
    """A silent tachometer, with no other axle shown, hides both from the unit: it sees neither a start nor a stop."""
    bench = Bench(rtri_setup)
    bench.trains.tachometers[0].gain = 0.0
    bench.trains.stock["sensors"]["slide_protection"]["shows_axle"][0] = 0
    stood, went = [], []
    unit_events = 0
    before_mps = 0.0
    while bench.step < 600 and not stood:
        unit_events |= bench.advance()
        events = bench.passed
        now_mps = float(bench.trains.plants[0].speed_mps)
        assert bool(events & records.PASSED_FROM_A_STAND) == (
            before_mps == 0.0 < now_mps and events & records.PASSED_TO_A_STAND == 0
        )
        went += [bench.step] if events & records.PASSED_FROM_A_STAND else []
        stood += [bench.step] if events & records.PASSED_TO_A_STAND else []
        before_mps = now_mps
        if now_mps > 3.0:
            bench.trains.truths[0].powered = 0  # the emergency brake brings it to a stand
    assert len(went) == len(stood) == 1
    assert before_mps == 0.0
    assert unit_events & (EVENT_STOPPED | EVENT_MOVING) == 0


def test_the_turns_do_not_change_the_course(rtri_setup: Setup) -> None:
    """Run ahead by one step or by fifty: the same speeds to the bit."""
    courses = []
    for steps in (1, 7, STEPS):
        bench, course = Bench(rtri_setup), []
        while bench.step < 700:
            bench.advance(min(steps, 700 - bench.step))
            course.extend(bench.course[0])
        courses.append(course)
    assert courses[0] == courses[1] == courses[2]


def test_it_stops_after_the_first_step_with_an_event(rtri_setup: Setup) -> None:
    bench = Bench(rtri_setup)
    while True:
        before = bench.step
        if (bench.advance() or bench.passed) and bench.step > 5:
            break
    assert bench.step - before <= STEPS
    last = bench.trace[bench.used - 1]
    assert last["step"] == bench.step  # the step of an event is always in the trace


def test_the_trace_has_every_tenth_step_while_the_train_moves(rtri_setup: Setup) -> None:
    bench = Bench(rtri_setup)
    while bench.step < 300:
        bench.advance(min(STEPS, 300 - bench.step))
    steps = bench.trace["step"][: bench.used]
    assert set(range(EVERY, 301, EVERY)) <= set(steps.tolist())
    assert np.all(np.diff(steps) > 0)


def test_a_stock_off_the_line_is_left_alone(rtri_setup: Setup) -> None:
    bench = Bench(rtri_setup)
    bench.trains.truths[0].active = 0
    before = bench.trains.stock.copy()
    done = advance(bench.trains.stock, bench.trains.pool.track, bench.sheet, bench.trace, 0, 0, STEPS)
    assert done == (STEPS, 0, 0)
    assert np.array_equal(bench.trains.stock, before)


def truth_at(position_m: float, rows: int) -> records.TruthRow:
    row: records.TruthRow = np.zeros(1, dtype=records.TRUTH).view(np.recarray)[0]
    row.position_m, row.profile_rows = position_m, rows
    row.front_boundary_m = row.rear_boundary_m = row.sign_m = row.crossing_m = np.inf
    return row


def test_mean_gradient_and_curvature_under_the_train() -> None:
    """10 permille up to 100 m, level beyond; a curve of 200 m radius from 50 m on."""
    profile = np.zeros(201, dtype=PROFILE)
    metres = np.arange(201)
    profile["elevation_m"] = np.minimum(metres, 100) * 0.01
    profile["turn_rad"] = np.maximum(metres - 50.0, 0.0) / 200.0
    rows = profile.view(np.recarray)
    for front_m, permille, curvature in (
        (45.0, 10.0, 0.0),
        (70.0, 10.0, 0.5 / 200.0),
        (110.5, 10.0 * 29.5 / 40.0, 1.0 / 200.0),
        (180.0, 0.0, 1.0 / 200.0),
    ):
        assert track_under(truth_at(front_m, 201), rows, 40.0) == pytest.approx((permille, curvature))


def test_what_front_and_rear_pass() -> None:
    tags_m = np.array([100.0, 150.0])
    truth = truth_at(100.4, 300)
    truth.tag_end = 2
    truth.front_boundary_m, truth.rear_boundary_m = 100.4, 60.5
    assert passed_in_step(truth, tags_m, 40.0) == records.PASSED_TAG | records.PASSED_FRONT
    truth.tag_next, truth.front_boundary_m, truth.rear_boundary_m = 1, np.inf, 60.4
    assert passed_in_step(truth, tags_m, 40.0) == records.PASSED_REAR
    truth.tag_next = 2
    truth.position_m, truth.rear_boundary_m = 200.0, np.inf
    assert passed_in_step(truth, tags_m, 40.0) == 0  # no tag left
    truth.crossing_m = 200.1
    assert passed_in_step(truth, tags_m, 40.0) == 0
    truth.crossing_m = 200.0
    assert passed_in_step(truth, tags_m, 40.0) == records.PASSED_CROSSING


def test_stock_that_stood_without_driving_tells_the_carrier_how_it_begins_to_move(rtri_setup: Setup) -> None:
    """Its command gone while the motors still pull: the carrier is told of its first step as of any other."""
    bench = Bench(rtri_setup)
    unit, plant = bench.trains.units[0], bench.trains.plants[0]
    unit.mode = MODE_HOLD
    plant.traction_built_n = 2.0e5
    bench.advance()
    assert bench.passed & records.PASSED_FROM_A_STAND
    (course,) = bench.course  # no mover as the stretch begins
    assert len(course) == bench.step
    assert course[-1] == plant.speed_mps > 0.0
    assert course[:-1] == [0.0] * (len(course) - 1)
    run_m = float(bench.trains.truths[0].position_m) - 80.0
    assert run_m == pytest.approx(0.5 * plant.speed_mps * STEP_S, abs=1e-9)


def test_who_stands_is_judged_in_every_step_too(rtri_setup: Setup) -> None:
    """What it sees while it stands may tell it that it is elsewhere, until it sees better."""
    bench = Bench(rtri_setup)
    bench.trains.units[0].mode = MODE_HOLD
    bench.trains.units[0].position_m += 500.0
    bench.advance()
    assert bench.course == []
    assert bench.sheet.worst[0, 0] > 400.0
