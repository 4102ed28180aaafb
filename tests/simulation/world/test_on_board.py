"""The world's one door to a unit: what it tells, and that it writes nothing of what a unit believes."""

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from host.units import LocalUnits
from onboard.duty.records import DutyPhase
from onboard.notes import UnitRestarted
from onboard.records import EMERGENCY_INTERVENTION, UNIT
from radio.envelope import header_of
from simulation.carriers.plain_track import PlainTrack
from simulation.clock import Clock
from simulation.setup import STEP_S, Setup, unit_configs
from simulation.world.kernel import advance, new_sheet
from simulation.world.on_board import OnBoard
from simulation.world.records import TRACE
from simulation.world.roster import Duty, draw_up
from simulation.world.trains import Trains
from vehicle.wheel import pulse_m

ROOT = Path(__file__).resolve().parents[3]
DRIVERS_HAND = {"notch"}  # what a driver on sight does with the brake handle, not what the unit believes


class Cab:
    """One train at its first mark, its unit switched on for its train."""

    def __init__(self, setup: Setup) -> None:
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
        self.units = LocalUnits(unit_configs(setup, b"k" * 32))
        self.on_board = OnBoard(setup, self.trains, self.units)
        self.duty: Duty = draw_up(setup.line, setup.timetable, {"K1": 40.0}, 0.0)["K1"][0]
        self.trains.place(0, self.duty)
        happened = self.on_board.enter_number(0, self.duty, comes_on_line=True, turned=False)
        self.on_board.tell(0, 0.0, happened)

    def run(self, steps: int) -> None:
        sheet, trace = new_sheet(1), np.zeros(5000, dtype=TRACE)
        while steps > 0:
            done, _, _ = advance(
                self.trains.stock, self.trains.pool.track, sheet, trace, 0, 0, min(steps, 50)
            )
            steps -= done

    def belief(self) -> bytes:
        return self.trains.stock["board"]["unit"].tobytes()


@pytest.fixture
def cab(rtri_setup: Setup) -> Cab:
    return Cab(rtri_setup)


def test_a_unit_knows_where_its_train_stands_when_it_comes_onto_the_line(cab: Cab) -> None:
    unit = cab.trains.units[0]
    assert unit.position_known == 1
    assert unit.position_m == cab.duty.mission.targets[0].mark_m
    accuracy_m = cab.trains.setup.unit.tag_accuracy_m + pulse_m(cab.trains.bodies[0])
    assert unit.bound_ahead_m == unit.bound_behind_m == accuracy_m
    assert not cab.on_board.drives_on_sight(0)


def test_a_dead_unit_brakes_by_its_missing_power_and_does_not_tick(cab: Cab) -> None:
    """20 m/s: the emergency brake of the train brings it to a stand; the unit sees nothing of it."""
    plant = cab.trains.plants[0]
    plant.speed_mps = plant.wheel_speed_mps = 20.0
    cab.trains.units[0].notch = 4.0
    cab.on_board.power_off(0)
    before = cab.belief()
    assert cab.trains.units[0].emergency == 0  # nobody sets its outputs: they fall
    cab.run(600)
    assert plant.speed_mps == 0.0
    run_m = float(cab.trains.truths[0].position_m) - cab.duty.mission.targets[0].mark_m
    strongest_mps2 = float(cab.trains.bodies[0].emergency_deceleration_mps2)
    assert 20.0**2 / (2.0 * 1.2 * strongest_mps2) < run_m < 2.0 * 20.0**2 / (2.0 * strongest_mps2)
    assert cab.belief() == before


def test_nothing_reaches_a_dead_unit(cab: Cab) -> None:
    cab.on_board.power_off(0)
    before = cab.belief()
    assert cab.on_board.tell(0, 1.0, ()) is None
    assert cab.on_board.tag_read(0, 601, 10.0) == []
    assert cab.on_board.tick_events(0, 255) == []
    assert cab.belief() == before
    with pytest.raises(KeyError):
        cab.units.advance("K1", 1.0, (), None)  # type: ignore[arg-type]


def test_a_unit_that_boots_has_forgotten_and_brakes(cab: Cab) -> None:
    cab.on_board.power_off(0)
    cab.on_board.power_on(0)
    answered = cab.on_board.tell(0, 60.0, cab.on_board.switch_on(0, cab.duty, 0))
    assert answered is not None
    answer, notes = answered
    assert UnitRestarted(epoch=2) in notes
    assert answer.command.held == ()
    assert cab.units._running["K1"].state.phase is DutyPhase.ON_SIGHT
    assert cab.trains.units[0].position_known == 0
    assert cab.trains.units[0].intervention == EMERGENCY_INTERVENTION
    assert cab.on_board.drives_on_sight(0)
    cab.trains.units[0].position_known = 1  # by a tag, while the manager has not yet said what it holds
    assert cab.on_board.drives_on_sight(0)


@pytest.mark.parametrize("drift", [0.1, -0.1])
def test_a_timer_runs_out_by_the_units_own_clock(cab: Cab, drift: float) -> None:
    """The sign-on is repeated after 2 s of it; its telegrams are stamped with it, too."""
    cab.on_board.clocks[0] = Clock().wrong(100.0, drift, 0.0)
    first = cab.on_board.tell(0, 10.0)  # set forward: what was due has run out
    assert first is not None
    (repeated,) = first[0].telegrams
    header = header_of(repeated.data)
    assert header is not None
    assert header.sent_s == pytest.approx(100.0 + 10.0 * (1.0 + drift))
    wake_at_s = first[0].wake_at_s
    assert wake_at_s == pytest.approx(10.0 + 2.0 / (1.0 + drift))
    before, after = cab.on_board.tell(0, wake_at_s - 0.01), cab.on_board.tell(0, wake_at_s)
    assert before is not None and not before[0].telegrams
    assert after is not None and len(after[0].telegrams) == 1


def test_what_the_vehicle_shows_outlives_a_boot_of_its_unit(cab: Cab) -> None:
    cab.on_board.power_off(0)
    assert cab.on_board.vehicle_shows(0, "doors_closed", False) == []
    cab.on_board.power_on(0)
    answered = cab.on_board.tell(0, 60.0, cab.on_board.switch_on(0, cab.duty, 0))
    assert answered is not None
    assert cab.units._running["K1"].state.place.unfit == "doors not closed"


def test_the_driver_is_shown_what_the_unit_says(cab: Cab) -> None:
    shown = cab.on_board.shown_to_driver(0)
    assert shown.waits_for == "signing on: no answer from the block manager"
    assert not shown.drive
    assert shown.held == ("3",)  # what it stands in it claims


# the world writes no belief ---------------------------------------------------------------------------------------


def written(tree: ast.AST) -> Iterator[tuple[str, str, int]]:
    """Fields of objects that are assigned: what holds them, the field, the line."""
    for node in ast.walk(tree):
        targets = node.targets if isinstance(node, ast.Assign) else ()
        targets = (node.target,) if isinstance(node, ast.AugAssign | ast.AnnAssign) else targets
        for target in targets:
            for part in target.elts if isinstance(target, ast.Tuple) else (target,):
                if isinstance(part, ast.Attribute):
                    yield ast.unparse(part.value), part.attr, part.lineno
                elif isinstance(part, ast.Subscript) and isinstance(part.slice, ast.Constant):
                    yield ast.unparse(part.value), str(part.slice.value), part.lineno


def is_unit(holder: str) -> bool:
    """Whether an expression is a unit's row, by how rows are named everywhere."""
    return holder == "unit" or holder.endswith((".unit", "['unit']")) or "units[" in holder


def beliefs_written(source: str) -> list[tuple[str, str, int]]:
    return [
        (holder, name, line)
        for holder, name, line in written(ast.parse(source))
        if is_unit(holder) and name in (UNIT.names or ()) and name not in DRIVERS_HAND
    ]


@pytest.mark.parametrize(
    "file", sorted((ROOT / "simulation").rglob("*.py")), ids=lambda file: str(file.relative_to(ROOT))
)
def test_the_world_writes_no_belief(file: Path) -> None:
    assert beliefs_written(file.read_text("utf-8")) == []


@pytest.mark.parametrize(
    "line",
    [
        "trains.units[slot].position_m = 3.0",
        "self.units[0].position_known, x.y = 1, 2",
        "unit.restricted_mps += 1.0",
        "row.board.unit.mode = 1",
        "stock['board']['unit']['stop_limit_m'] = 0.0",
    ],
)
def test_a_belief_written_would_be_found(line: str) -> None:
    assert len(beliefs_written(line)) == 1
