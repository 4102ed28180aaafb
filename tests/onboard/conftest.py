"""The RTRI test line, its one train and records to work on, for the tests of the on-board unit."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Direction, Line, Position
from network.timetable import AtPortal, Call, Stabled, TimetableTrain, load_timetable
from onboard.board import BOARD, BoardRow
from onboard.driving.pattern import pattern_of
from onboard.driving.stop_keeper import StopKeeper, believed_dead_time_s, fill_design
from onboard.driving.stopping import WAVE
from onboard.driving.tasc import DESIGN, TASC
from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.duty.records import DutyPhase
from onboard.mission import Mission, plan_mission
from onboard.motion import UnitMotion
from onboard.records import BEHAVIOUR, EVENT_MOVING, MODE_DRIVE, UNIT, BehaviourRow, PathData, UnitRow
from onboard.unit_records import UnitParameters
from radio.messages import (
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    RouteGranted,
    RouteRequest,
    SignOn,
    SignOnAccepted,
)
from tests.onboard.unit_bench import (
    DEPARTURE_S,
    LEAD_S,
    MANAGER,
    MARK_B_M,
    SECTIONS,
    TOKEN,
    Bench,
    capabilities,
    proof,
)
from tests.onboard.unit_bench import UNIT as UNIT_ID
from tests.rows import Rows
from vehicle.record import put_settings
from vehicle.records import TrainRow
from vehicle.train_file import load_train, shipped_train

LINE_SPEED_MPS = 18.0


@pytest.fixture(scope="session")
def rtri() -> Line:
    return load_line(shipped_line("rtri_test_line"))


@pytest.fixture(scope="session")
def mission(rtri: Line) -> Mission:
    """The paper's running test: from section 3 to section 8."""
    timetable = load_timetable(shipped_timetable("rtri_test_line"), rtri)
    return plan_mission(rtri, timetable.trains["T1"], "3", None, None)


@pytest.fixture(scope="session")
def through(rtri: Line) -> Mission:
    """From portal to portal, calling at A only: B is passed."""
    train = TimetableTrain(
        "T2", Direction.DOWN, True, (Call("A", "1", 0, 60),), AtPortal("PW"), AtPortal("PE")
    )
    return plan_mission(rtri, train, "PW", "PE", 60.0)


@pytest.fixture(scope="session")
def back(rtri: Line) -> Mission:
    """UP, from section 8 to section 3's station: track 2 is the usual one there."""
    calls = (Call("B", "1", None, 300), Call("A", None, 400, None))
    train = TimetableTrain("T3", Direction.UP, True, calls, Stabled(), Stabled())
    return plan_mission(rtri, train, "8", None, None)


@pytest.fixture(scope="session")
def train() -> TrainRow:
    row: TrainRow = load_train(shipped_train("ev_e301")).row.view(np.recarray)[0]
    return row


@pytest.fixture
def behaviour(train: TrainRow) -> BehaviourRow:
    row: BehaviourRow = np.zeros(1, dtype=BEHAVIOUR).view(np.recarray)[0]
    row.service_guaranteed_mps2 = 0.8
    row.service_reaction_s = 1.4
    row.emergency_guaranteed_mps2 = 1.0
    row.emergency_reaction_s = 1.4
    put_settings(row.settings, Driving())
    row.standing_brake_notch = train.brake_notches / 2.0
    row.step_s = 0.1
    return row


@pytest.fixture
def unit() -> UnitRow:
    """A unit that knows it stands at 100 m of an endless free track."""
    row: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    row.position_m = 100.0
    row.position_known = 1
    row.odometer_scale = 1.0
    row.bound_growth = 0.02
    row.expected_tag_m = row.stop_limit_m = row.restricted_mps = np.inf
    row.rear_trigger_m = row.position_trigger_m = np.inf
    row.cruise_mps = row.target_stop_m = np.inf
    row.tag_window_m = 5.0
    row.mode = MODE_DRIVE
    return row


@pytest.fixture
def track(train: TrainRow, behaviour: BehaviourRow) -> Callable[..., Rows]:
    """Rows of PATTERN over `elevation_m`, with one limit everywhere."""

    def make(elevation_m: np.ndarray, limit_mps: float = LINE_SPEED_MPS) -> Rows:
        limits = np.full(elevation_m.size, limit_mps)
        return pattern_of(
            np.ascontiguousarray(elevation_m), np.zeros(elevation_m.size), limits, train, behaviour
        ).view(np.recarray)

    return make


@pytest.fixture
def keeper(train: TrainRow, behaviour: BehaviourRow) -> Callable[[], StopKeeper]:
    """What a train that has made no stop yet keeps of its stops; new at each call."""

    def make() -> StopKeeper:
        tasc, design, wave = (np.zeros(1, dtype=t).view(np.recarray)[0] for t in (TASC, DESIGN, WAVE))
        learned = Learned("K1", believed_dead_time_s(train))
        fill_design(design, train, behaviour, learned)
        return StopKeeper(tasc, design, wave, learned)

    return make


@pytest.fixture
def new_board(
    train: TrainRow, behaviour: BehaviourRow, keeper: Callable[[], StopKeeper]
) -> Callable[[UnitRow], BoardRow]:
    """All that the tick of a train with this unit works on; new at each call."""

    def make(unit: UnitRow) -> BoardRow:
        kept, rows = keeper(), np.zeros(1, dtype=BOARD)
        for name, part in (("unit", unit), ("kind", train), ("behaviour", behaviour)):
            rows[name][0] = part
        rows["tasc"][0], rows["design"][0], rows["wave"][0] = kept.tasc, kept.design, kept.wave
        board: BoardRow = rows.view(np.recarray)[0]
        return board

    return make


@pytest.fixture
def boards(unit: UnitRow, new_board: Callable[[UnitRow], BoardRow]) -> Callable[[], BoardRow]:
    """The board of a train at START_M on an endless free track, for each example a new one."""
    return lambda: new_board(unit)


@pytest.fixture
def path(track: Callable[..., Rows], mission: Mission) -> Rows:
    return track(np.zeros(math.ceil(mission.path.length_m) + 1))


@pytest.fixture
def at_start(
    rtri: Line,
    mission: Mission,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    path: Rows,
) -> Callable[..., UnitMotion]:
    """The driving part of a unit at the mark of section 3, with options of `UnitMotion`; new at each call."""

    def make(**options: Any) -> UnitMotion:  # noqa: ANN401
        motion = UnitMotion(rtri, UnitParameters(), unit, train, behaviour, keeper(), **options)
        motion.stand_at_start(mission, PathData(path, 0), 0.0)
        return motion

    return make


# a unit and its driving part, phase by phase --------------------------------------------------------------------


@pytest.fixture
def bench_on(
    mission: Mission,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    path: Rows,
) -> Callable[[Line], Bench]:
    """A unit on a line, switched off; new at each call."""
    return lambda line: Bench(line, mission, unit, train, behaviour, keeper(), path)


@pytest.fixture
def switched_off(bench_on: Callable[[Line], Bench], rtri: Line) -> Bench:
    return bench_on(rtri)


@pytest.fixture
def bench(switched_off: Bench) -> Bench:
    """Standing at A, signed on."""
    bench = switched_off
    bench.begin()
    assert bench.said == [SignOn(UNIT_ID, ("3",))]
    assert bench.phase is DutyPhase.SIGNING_ON
    bench.hear(MANAGER, SignOnAccepted(("3",), 10, None, ()))
    assert bench.phase is DutyPhase.STANDING
    return bench


@pytest.fixture
def granted(bench: Bench) -> Bench:
    """It has its route and has commanded the departure points."""
    assert bench.wake_at_s == DEPARTURE_S - LEAD_S
    bench.at(DEPARTURE_S - LEAD_S)
    assert bench.said == [RouteRequest(UNIT_ID, "3>8", SECTIONS, 10)]
    bench.hear(MANAGER, RouteGranted("3>8", SECTIONS, TOKEN, capabilities()))
    assert bench.said == [PointsCommand("P5", Position.NORMAL, "5", TOKEN, b"five")]
    return bench


@pytest.fixture
def running(granted: Bench) -> Bench:
    """It has left A on time and runs at the open line's beginning, tag 601 read."""
    granted.hear("A-E", proof("P5"))
    assert granted.row.stop_limit_m == pytest.approx(520.0)  # before the arrival points
    assert granted.wake_at_s == DEPARTURE_S
    granted.at(DEPARTURE_S)
    assert "departs" in granted.notes
    assert granted.phase is DutyPhase.RUNNING
    granted.row.speed_mps = 10.0
    granted.ticked(EVENT_MOVING)
    assert granted.notes == ["moving"]
    granted.read(601)
    assert granted.said == []  # nothing is given back before the arrival tag
    return granted


@pytest.fixture
def cleared_to_b(running: Bench) -> Bench:
    """It has passed the approach tag and its points are proven."""
    running.read(602)
    assert running.commanded == [PointsCommand("P7", Position.NORMAL, "7", TOKEN, b"seven")]
    running.hear("B-W", proof("P7"))
    return running


@pytest.fixture
def at_b(cleared_to_b: Bench) -> Bench:
    """It stands at B, its tags read and what is behind given back."""
    cleared_to_b.read(801)
    assert cleared_to_b.said == [HoldingReport(("8",), TOKEN)]
    cleared_to_b.hear(MANAGER, HoldingConfirmed(("8",), TOKEN))
    cleared_to_b.stop(MARK_B_M)
    return cleared_to_b
