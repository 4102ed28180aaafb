"""Why a train that stands at a stop may not leave: by its unit's own model, as its place says it."""

import math
from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from onboard import ability
from onboard.ability import Ability, Means, WayAhead, too_steep, why_not
from onboard.charge import ChargeWatch
from onboard.duty.records import DrivingCommand, Looked, VehicleChecked
from onboard.duty.unable import TooSteep, Unable
from onboard.mission import Mission
from onboard.records import MODE_DRIVE, MODE_HOLD, BehaviourRow
from onboard.vehicle import IN_ORDER
from tests.onboard.unit_bench import Bench
from vehicle.records import TrainRow

STEEP = 35.0


@pytest.fixture
def way(mission: Mission) -> WayAhead:
    return up(mission, STEEP)


def up(mission: Mission, permille: float) -> WayAhead:
    metres = math.ceil(mission.path.length_m) + 2
    climb_m: NDArray[np.float64] = np.arange(metres) * permille * 1e-3
    return WayAhead(mission, 0, mission.targets[0].mark_m, climb_m, np.full(metres, 18.0))


@pytest.fixture
def means(train: TrainRow, behaviour: BehaviourRow) -> Means:
    return Means(train, behaviour, 0.2, IN_ORDER)


def with_(means: Means, motors_share: float = 1.0, adhesion_factor: float = 1.0) -> Means:
    vehicle = replace(means.vehicle, motors_share=motors_share)
    return Means(means.train, means.behaviour, means.load_share, vehicle, adhesion_factor)


def test_with_all_its_motors_on_a_dry_rail_it_gets_there(way: WayAhead, means: Means) -> None:
    assert why_not(way, means) is None


@pytest.mark.parametrize(("motors_share", "adhesion_factor"), [(0.5, 1.0), (1.0, 0.2)])
def test_it_says_where_it_would_stall_and_what_is_missing(
    way: WayAhead, means: Means, motors_share: float, adhesion_factor: float
) -> None:
    why = too_steep(way, with_(means, motors_share, adhesion_factor))
    assert isinstance(why, TooSteep)
    assert why.station == way.mission.targets[1].station_id
    piece_id, kilometrage_m = way.mission.path.locate(way.front_m)
    assert (why.piece_id, why.kilometrage_m) == (piece_id, pytest.approx(kilometrage_m))
    assert why.gradient_permille == pytest.approx(STEEP)
    assert why.pull_n < why.needed_n
    assert (why.motors_share, why.adhesion_factor) == (motors_share, adhesion_factor)
    assert f"{why.needed_n / 1e3:.1f} kN on {STEEP:.1f} permille" in why.words
    assert ("of the dry rail's adhesion" in why.words) is (adhesion_factor < 1.0)


def test_at_its_last_stop_nothing_is_ahead(way: WayAhead, means: Means) -> None:
    end = len(way.mission.targets) - 1
    last = WayAhead(way.mission, end, way.mission.targets[end].mark_m, way.climb_m, way.limit_mps)
    assert why_not(last, with_(means, 0.0)) is None


def test_it_looks_again_only_where_something_has_changed(
    mission: Mission, way: WayAhead, means: Means, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[WayAhead] = []

    def counted(there: WayAhead, has: Means) -> TooSteep | None:
        looks.append(there)
        return too_steep(there, has)

    monkeypatch.setattr(ability, "why_not", counted)
    asked = Ability()
    for _ in range(3):
        assert asked.why_not(way, means) is None
    assert len(looks) == 1
    assert asked.why_not(way, with_(means, 0.5)) is not None
    assert asked.why_not(way, with_(means, 0.5, 0.9)) is not None
    assert asked.why_not(way, means) is None
    assert asked.why_not(up(mission, STEEP), means) is None  # the same mission from the same place
    assert len(looks) == 4


# the driving part makes its place of it -----------------------------------------------------------------------------


def test_a_place_at_a_stop_says_it_and_one_on_the_way_does_not(granted: Bench) -> None:
    """On level track a train without motors cannot start at all."""
    motion = granted.motion
    assert motion.place().unable is None
    assert motion.vehicle_shows(replace(IN_ORDER, motors_share=0.0)) == [Looked()]
    unable = motion.place().unable
    assert isinstance(unable, TooSteep)
    assert unable.pull_n == 0.0
    granted.row.speed_mps = 5.0
    assert motion.place().unable is None
    granted.row.speed_mps = 0.0
    granted.row.position_m += 100.0
    assert motion.place().unable is None
    assert motion.vehicle_shows(replace(IN_ORDER, doors_closed=False)) == [VehicleChecked()]


def test_a_train_without_motors_stays_and_shows_its_driver_why(granted: Bench) -> None:
    granted.tell(granted.motion.vehicle_shows(replace(IN_ORDER, motors_share=0.0)))
    assert granted.notes == ["unable_to_leave"]
    assert granted.motion.command.unable is not None
    assert granted.waits_for.startswith(("route", "points", "what takes it to"))
    granted.tell(granted.motion.vehicle_shows(IN_ORDER))
    assert "able_to_leave" in granted.notes
    assert granted.motion.command.unable is None


@dataclass
class Pantograph:
    """A watch whose set stands at a charger."""

    connected: bool
    asked: list[int] = field(default_factory=list)

    def why_not(self, _mission: Mission, _at: int) -> None:
        return None

    def told(self, _unable: Unable | None) -> None:
        """Why its train may not leave is nothing to this one."""

    def on_sight(self, _mission: Mission, at: int) -> None:
        self.asked.append(at)


def test_on_sight_at_a_stop_it_is_held_while_its_pantograph_is_up(granted: Bench) -> None:
    motion, watch = granted.motion, Pantograph(connected=True)
    motion.charge = cast("ChargeWatch", watch)
    command = DrivingCommand(drive=True, on_sight=True, stands_at=0)
    motion.obey(command, granted.now_s)
    assert granted.row.mode == MODE_HOLD and watch.asked == [0]
    watch.connected = False
    motion.obey(command, granted.now_s)
    assert granted.row.mode == MODE_DRIVE
