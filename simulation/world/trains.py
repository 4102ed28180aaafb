"""The trains of a run: one slot a stock, with its rows of truth, body, unit and kind, and its place on the carrier."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from network.graph import next_pieces
from network.model import Direction
from network.path import Path, path_of
from onboard.authority.coverage import covered_by
from onboard.driving.laws.by_hand import by_hand
from onboard.driving.laws.settings import choose_law, fit_law
from onboard.driving.laws.table import LAW_NAMES, LawsRow
from onboard.driving.stopping import WaveRow
from onboard.driving.tasc import DesignRow, TascRow
from onboard.localisation.curvature_map import Mounting
from onboard.localisation.table import READER_NAMES, ReadersRow
from onboard.records import BehaviourRow, UnitRow
from radio.chance import generator
from simulation.carriers.carrier import Carrier, Truth
from simulation.ride import RideRow
from simulation.sensors.gnss import GnssReceiverRow
from simulation.sensors.lidar import LidarSensorRow
from simulation.sensors.table import SENSORS
from simulation.sensors.tachometer import TachometerRow
from simulation.sensors.tag_air import channel_at, read_bits
from simulation.sensors.tag_reader import TagReaderRow
from simulation.settings import PositionSensor
from simulation.setup import Setup, behaviour_rows
from simulation.subscribers import Subscribers
from simulation.world.collation import fit as fit_collation
from simulation.world.collation import map_of_run
from simulation.world.dead_zones import DeadZonesInForce
from simulation.world.irregularities import Irregularities
from simulation.world.path_pool import PathPool, PathRows
from simulation.world.premises import FalsePositions
from simulation.world.records import STOCK, TruthRow
from simulation.world.roster import Duty
from vehicle.record import cells_of
from vehicle.records import PlantRow, TrainRow
from vehicle.train_file import new_plant

AGREEMENT_M = (
    1e-4  # the carrier's position against the sum of speeds; SUMO takes less than 1 mm/s for standing
)

SIGN: Final = {Direction.DOWN: "+", Direction.UP: "-"}  # of SUMO's edges
LEAD_BOGIE_M: Final = 3.1  # assumed: of a car of 20 m with its bogies 13.8 m apart, as most of JR's are
BOGIE_BASE_M: Final = 13.8
MOUNTING: Final = Mounting(LEAD_BOGIE_M, BOGIE_BASE_M)
HELD_SHARE: Final = 0.2  # of the standing brake, built up: a train with less has let go of it
END_OF_TRACK_M = 0.01  # this near the end of the last piece, a train has run off it


def _rows(part: NDArray[np.void]) -> list[Any]:
    """One view a slot into a part of `Trains.stock`, its fields as attributes."""
    return list(part.view(np.recarray))


def _first_beyond(positions_m: NDArray[np.float64], first: int, end: int, position_m: float) -> int:
    """The first of rows `first` to `end`, by position, that lies beyond `position_m`; `end` if none does."""
    return first + int(np.searchsorted(positions_m[first:end], position_m, side="right"))


def _reduced(factor: float, guaranteed: float, reserve: float) -> float:
    """A brake's factor without a part of what it has beyond the guaranteed share."""
    return factor if reserve == 1.0 else factor - (1.0 - reserve) * max(factor - guaranteed, 0.0)


class CarrierDisagrees(RuntimeError):  # noqa: N818 - names what happened
    """The carrier put a train elsewhere than its speeds say: nothing after this would be true."""


class Trains:
    """All stocks; arrays are indexed by slot, one slot a stock in the order of the diagrams."""

    def __init__(self, setup: Setup, carrier: Carrier) -> None:
        self.setup = setup
        self.carrier = carrier
        self.stock_ids = tuple(d.stock_id for d in setup.timetable.diagrams)
        self.slot_of = {stock_id: slot for slot, stock_id in enumerate(self.stock_ids)}
        n = len(self.stock_ids)
        self.stock = np.zeros(n, dtype=STOCK)
        self.stock["plant"] = new_plant(n)
        self.stock["board"]["behaviour"] = behaviour_rows(setup, self.stock_ids)
        board = self.stock["board"]
        # Each stock's parts, for what is not done in every stretch: writing to them writes to `stock`.
        self.truths: Sequence[TruthRow] = [cells_of(TruthRow, row) for row in _rows(self.stock["truth"])]
        self.plants: Sequence[PlantRow] = [cells_of(PlantRow, row) for row in _rows(self.stock["plant"])]
        self.sensors = {sensor.name: _rows(self.stock["sensors"][sensor.name]) for sensor in SENSORS}
        self.tachometers: Sequence[TachometerRow] = self.sensors["tachometer"]
        self.tag_readers: Sequence[TagReaderRow] = self.sensors["tag_reader"]
        self.receivers: Sequence[GnssReceiverRow] = self.sensors["gnss_receiver"]
        self.lidars: Sequence[LidarSensorRow] = self.sensors["lidar"]
        self.bodies: Sequence[TrainRow] = _rows(self.stock["body"])  # the trains as they are
        self.kinds: Sequence[TrainRow] = _rows(board["kind"])  # as their units believe them to be
        self.laws: Sequence[LawsRow] = _rows(board["laws"])
        self.units: Sequence[UnitRow] = _rows(board["unit"])
        self.readers: Sequence[ReadersRow] = _rows(board["readers"])
        self.behaviours: Sequence[BehaviourRow] = _rows(board["behaviour"])
        self.tascs: Sequence[TascRow] = _rows(board["tasc"])
        self.designs: Sequence[DesignRow] = _rows(board["design"])
        self.waves: Sequence[WaveRow] = _rows(board["wave"])
        self.rides: Sequence[RideRow] = [cells_of(RideRow, row) for row in _rows(self.stock["ride"])]
        self._active = self.stock["truth"]["active"]
        self._on_line: list[int] | None = None  # the slots that are active; None: to be looked up
        self._position_m = self.stock["truth"]["position_m"]
        self._offset_m = self.stock["truth"]["offset_m"]
        self._travelled_m = self.stock["plant"]["travelled_m"]
        rails = None
        if setup.sensors.any_gyro:
            rails = Irregularities(setup.line, setup.curvature.rails, setup.seed, setup.today)
        self.pool = PathPool(setup.line, setup.believed_line, rails, map_of_run(setup, MOUNTING))
        self.paths: list[Path | None] = [None] * n  # the true path, which wrong points change
        self.duties: list[Duty | None] = [None] * n
        self.premises = FalsePositions(self.tachometers, self.units)
        self.dead_zones = DeadZonesInForce(setup.line)
        self.tag_faults: dict[int, int | None] = {}  # id read instead of the tag's own; None: not read
        self.rail_is: Final = Subscribers[
            int, float
        ]()  # the adhesion under a train (slot), of the dry rail's
        self._brake_factors = np.ones(n)
        self._brake_drawn = np.ones(n)  # of the leg
        self._brake_reserve = np.ones(n)  # what faults leave beyond the guaranteed share
        self._adhesion = np.ones(n)  # as the weather has it
        self._rail = np.ones(n)  # what faults leave of it
        self._legs = [generator(setup.seed, "legs", s, *setup.today) for s in self.stock_ids]
        for slot in range(n):
            self._fit_out(slot)

    def _fit_out(self, slot: int) -> None:
        """Fill one stock's row, and give it its unit."""
        setup, stock_id, row = self.setup, self.stock_ids[slot], self.stock[slot]
        row["board"]["kind"] = setup.believed_train(stock_id).row[0]
        law = self._law(stock_id)
        chance = generator(setup.seed, "driver", stock_id)
        fit_law(self.laws[slot], law, setup.law, lambda _law, _field: float(chance.normal()))
        body, self._brake_factors[slot] = setup.scatter.body(setup.seed, stock_id, setup.trains[stock_id].row)
        row["body"] = body[0]
        for sensor in SENSORS:
            sensor.fit(self.sensors[sensor.name][slot], setup, stock_id)
            sensor.fit_reader(self.readers[slot], setup, stock_id)
        fit_collation(self.readers[slot].curvature, setup, stock_id, MOUNTING)
        truth = self.truths[slot]
        truth.powered = 1
        truth.sight_m = truth.sign_m = truth.crossing_m = math.inf
        truth.carries_more = int(bool(setup.sensors.carried_by(stock_id) - {PositionSensor.TAGS}))
        truth.wheels_vary = int(setup.sensors.wheels_vary)
        truth.lead_bogie_m, truth.bogie_base_m = LEAD_BOGIE_M, BOGIE_BASE_M

    def _law(self, stock_id: str) -> str:
        return self.setup.laws.get(stock_id, LAW_NAMES[0])

    def drive(self, slot: int, notch: float | None) -> None:
        """A driver has the handle, and has set this notch; None: the law that the scenario has for the stock drives."""
        laws = self.laws[slot]
        if notch is not None:
            laws.by_hand.notch = notch  # type: ignore[attr-defined]
        choose_law(laws, self._law(self.stock_ids[slot]) if notch is None else by_hand.__name__)

    def position_fixed(self, slot: int, *, lies: bool = False) -> None:
        """A fix has told the unit's position anew; whether it was not what its source promises."""
        unit = self.units[slot]
        beyond_m = float(self.truths[slot].position_m - unit.position_m)
        holds = bool(-unit.bound_behind_m <= beyond_m <= unit.bound_ahead_m)
        self.premises.note_fix(slot, holds=holds, lies=lies)

    def last_fix_lies(self, slot: int) -> bool:
        """Whether satellites gave the last fix, and err by more than their protection level."""
        by_satellites = READER_NAMES[self.units[slot].fix_reader] == PositionSensor.GNSS.value
        receiver = self.receivers[slot]
        return by_satellites and abs(receiver.error_m) > receiver.receiver.protection_m

    # where trains are ------------------------------------------------------------------------------------------

    def active(self) -> list[int]:
        """Slots of the trains on the line."""
        if self._on_line is None:
            self._on_line = np.flatnonzero(self._active).tolist()
        return self._on_line.copy()

    def true_path(self, slot: int) -> Path:
        """The path that the train is really on. RuntimeError before it is on the line."""
        path = self.paths[slot]
        if path is None:
            raise RuntimeError(f"{self.stock_ids[slot]} is not on the line")
        return path

    def kilometrage_m(self, slot: int) -> float:
        """True kilometrage of the front, m."""
        return self.true_path(slot).kilometrage_m(float(self.truths[slot].position_m))

    def place_m(self, stock_id: str) -> float:
        """True kilometrage of the front, m; of stock outside, where it comes onto the line."""
        slot = self.slot_of[stock_id]
        if self.truths[slot].active:
            return self.kilometrage_m(slot)
        duty = self.duties[slot]
        return math.nan if duty is None else duty.mission.path.kilometrage_m(0.0)

    def reached(self, stock_id: str) -> tuple[bool, ...]:
        """Which radio networks truly reach the train; off the line all do."""
        slot, networks = self.slot_of.get(stock_id), self.setup.networks
        if slot is None or not self.truths[slot].active:
            return (True,) * len(networks)
        path, front_m = self.true_path(slot), float(self.truths[slot].position_m)
        covered = covered_by(self.setup.line, path, front_m, len(networks))
        return tuple(
            reaches and not self.dead_zones.hides(path, front_m, name)
            for reaches, name in zip(covered, networks, strict=True)
        )

    def radio_place(self, stock_id: str) -> tuple[str, float] | None:
        """Where the front of a train is as dead zones see it: alignment, kilometrage, m; None outside."""
        slot = self.slot_of.get(stock_id)
        if slot is None or not self.truths[slot].active:
            return None
        return self.dead_zones.place_of(self.true_path(slot), float(self.truths[slot].position_m))

    def compare(self, slots: Sequence[int], seen: Sequence[Truth]) -> None:
        """Take the carrier's positions as the truth; CarrierDisagrees when a train is not where its speeds lead."""
        for slot, truth in zip(slots, seen, strict=True):
            position_m = self.true_path(slot).step_of(truth.piece_id).start_m + truth.offset_m
            if abs(position_m - self._position_m[slot]) > AGREEMENT_M:
                message = (
                    f"{self.stock_ids[slot]}: carrier has it at {position_m:.6f} m of its path on"
                    f" {truth.piece_id}, its speeds at {float(self._position_m[slot]):.6f} m"
                )
                raise CarrierDisagrees(message)
            self._position_m[slot] = position_m
            self._offset_m[slot] = position_m - self._travelled_m[slot]

    # coming, going, turning --------------------------------------------------------------------------------------

    def place(self, slot: int, duty: Duty) -> None:
        """Put the stock on the line where its duty begins."""
        mission = duty.mission
        stock_id = self.stock_ids[slot]
        position_m = mission.targets[0].mark_m
        self.truths[slot].active, self._on_line = 1, None
        self.premises.position_told(slot)
        self._enter_path(slot, duty, position_m)
        pieces = self.true_path(slot).piece_ids
        step = mission.path.step_at(position_m)
        first = pieces.index(step.piece_id)
        self.carrier.insert(
            stock_id,
            pieces[first:],
            mission.direction,
            position_m - step.start_m,
            float(self.bodies[slot].length_m),
        )

    def can_turn(self, slot: int, duty: Duty) -> bool:
        """Whether the whole train stands on the way of its next duty, which begins there: no overrun onto points."""
        front = self.carrier.truth(self.stock_ids[slot]).piece_id
        return {front, *self.pieces_under(slot)} <= set(duty.mission.path.piece_ids)

    def turn(self, slot: int, duty: Duty) -> None:
        """Change ends on the spot: what was the rear is the front, on the next duty's path."""
        mission = duty.mission
        old = self.true_path(slot)
        length_m = float(self.bodies[slot].length_m)
        rear = old.locate(float(self.truths[slot].position_m) - length_m)
        self._enter_path(slot, duty, mission.path.to_path_m(*rear))
        pieces = self.true_path(slot).piece_ids
        first = pieces.index(self.carrier.truth(self.stock_ids[slot]).piece_id)
        self.carrier.reverse(self.stock_ids[slot], pieces[first:], mission.direction)

    def continue_as(self, slot: int, duty: Duty) -> None:
        """Go on in the same direction as another train."""
        old = self.true_path(slot)
        path = duty.mission.path
        truth = self.truths[slot]
        self._enter_path(slot, duty, path.to_path_m(*old.locate(float(truth.position_m))))
        pieces = self.true_path(slot).piece_ids
        first = pieces.index(path.step_at(float(truth.position_m)).piece_id)
        self.carrier.reroute(self.stock_ids[slot], pieces[first:], path.direction)

    def go_by(self, slot: int, duty: Duty) -> None:
        """Go on as the same train by another way, the same as far as the train is."""
        self.duties[slot] = duty
        path, position_m = self._onward(duty.mission.path), float(self.truths[slot].position_m)
        self.paths[slot] = path
        self._use_rows(slot, self.rows_of(slot, path), position_m)
        self.set_boundaries(slot)
        first = path.piece_ids.index(path.step_at(position_m).piece_id)
        self.carrier.reroute(self.stock_ids[slot], path.piece_ids[first:], path.direction)

    def stands_in(self, section_id: str) -> bool:
        """Whether any train truly stands in a section, wholly or in part."""
        return any(section_id in under for under in self.sections_under().values())

    def pieces_under(self, slot: int) -> set[str]:
        """The pieces that a train truly stands on, wholly or in part."""
        front_m = float(self.truths[slot].position_m)
        rear_m = front_m - float(self.bodies[slot].length_m)
        steps = self.true_path(slot).steps
        return {step.piece_id for step in steps if step.end_m > rear_m and step.start_m < front_m}

    def sections_under(self) -> dict[str, set[str]]:
        """The sections that each train on the line truly stands in, by stock id."""
        pieces = self.setup.line.pieces
        return {
            self.stock_ids[slot]: {pieces[piece_id].section_id for piece_id in self.pieces_under(slot)}
            for slot in self.active()
        }

    def train_ahead_m(self, slot: int) -> float:
        """Where on its path (m) the nearest part of another train is, ahead of this one; infinite if none."""
        path, front_m, nearest_m = self.true_path(slot), float(self._position_m[slot]), math.inf
        for other in self.active():
            if other == slot:
                continue
            to_m = float(self._position_m[other])
            from_m = to_m - float(self.bodies[other].length_m)
            for step in self.true_path(other).steps:
                if step.end_m <= from_m or step.start_m >= to_m or step.piece_id not in path:
                    continue
                ends_m = (max(from_m, step.start_m), min(to_m, step.end_m))
                there_m = [path.to_path_m(step.piece_id, step.kilometrage_m(end_m)) for end_m in ends_m]
                if max(there_m) > front_m:
                    nearest_m = min(nearest_m, max(min(there_m), front_m))
        return nearest_m

    def remove(self, slot: int) -> None:
        """Take the stock off the line."""
        self.carrier.remove(self.stock_ids[slot])
        self.truths[slot].active, self._on_line = 0, None
        self.paths[slot] = None
        if not self._is_braked(slot):
            self._shut_off(slot)

    def _is_braked(self, slot: int) -> bool:
        """Whether a train stands with its brakes applied, or has let go of them to start."""
        plant = self.plants[slot]
        if plant.speed_mps > 0.0:
            return False
        built_mps2 = max(plant.service_deceleration_mps2, plant.emergency_deceleration_mps2)
        return bool(built_mps2 > HELD_SHARE * self._standing_mps2(slot))

    def _standing_mps2(self, slot: int) -> float:
        notch = int(self.behaviours[slot].standing_brake_notch)
        return float(self.bodies[slot].brake_deceleration_mps2[notch])

    def _shut_off(self, slot: int) -> None:
        """Its driver leaves it braked, whatever it was about to do: so it stands when it comes back."""
        plant = self.plants[slot]
        notch = float(self.behaviours[slot].standing_brake_notch)
        self.stock["plant"]["command_notch"][slot] = -notch
        plant.traction_built_n = plant.traction_force_n = 0.0
        plant.service_deceleration_mps2 = self._standing_mps2(slot)
        plant.speed_mps = plant.acceleration_mps2 = plant.wheel_speed_mps = plant.last_wheel_speed_mps = 0.0

    def _enter_path(self, slot: int, duty: Duty, position_m: float) -> None:
        self.duties[slot] = duty
        truth, plant = self.truths[slot], self.plants[slot]
        self.paths[slot] = self._onward(duty.mission.path)
        truth.position_m = position_m
        truth.offset_m = position_m - plant.travelled_m
        self._use_rows(slot, self.rows_of(slot, self.true_path(slot)), position_m)
        self.set_boundaries(slot)
        chance = generator(self.setup.seed, "load", duty.train.number, *self.setup.today)
        spread = self.setup.load.load_share_spread
        plant.load_share = float(
            np.clip(self.setup.load.load_share_mean + chance.uniform(-spread, spread), 0.0, 1.0)
        )

    def begin_leg(self, slot: int, now_s: float) -> None:
        """Draw what passes, for the run to the next stop: the brake's factor, the rail's adhesion."""
        scatter, chance = self.setup.scatter, self._legs[slot]
        self._brake_drawn[slot] = self._brake_factors[slot] * scatter.brake_of_leg(chance)
        self.set_brake(slot, float(self._brake_reserve[slot]))
        self._adhesion[slot] = scatter.adhesion_of_leg(chance, now_s)
        self.set_rail(slot, float(self._rail[slot]))

    def set_brake(self, slot: int, reserve: float) -> None:
        """What faults of the brake leave of the force that it has beyond the guaranteed share."""
        self._brake_reserve[slot] = reserve
        plant, driving, drawn = self.plants[slot], self.setup.driving, float(self._brake_drawn[slot])
        plant.brake_factor = _reduced(drawn, driving.service_guaranteed_share, reserve)
        plant.emergency_factor = _reduced(1.0, driving.emergency_guaranteed_share, reserve)

    def set_motors(self, slot: int, cut_out: int) -> float:
        """How many of a train's motors are cut out; what those pulled is gone at once. The share that is left."""
        plant, motors = self.plants[slot], float(self.bodies[slot].motors)
        share = max(motors - cut_out, 0.0) / motors
        if share < plant.motors_share:
            plant.traction_built_n *= share / plant.motors_share
        plant.motors_share = share
        return share

    def set_rail(self, slot: int, share: float) -> None:
        """What faults of the rail leave of the weather's adhesion."""
        self._rail[slot] = share
        self.plants[slot].adhesion_factor = self._adhesion[slot] * share
        self.rail_is(slot, float(self._adhesion[slot] * share))

    def _onward(self, path: Path) -> Path:
        """The path with the track that really goes on beyond it, to the end of the line: for who overruns."""
        pieces = list(path.piece_ids)
        while following := next_pieces(self.setup.line, pieces[-1], path.direction):
            pieces.append(following[0])
        return path_of(self.setup.line, pieces, path.direction)

    def rows_of(self, slot: int, path: Path) -> PathRows:
        """Rows of the pool for a path of this stock."""
        stock_id = self.stock_ids[slot]
        return self.pool.rows_for(
            path, self.setup.believed_train(stock_id).id, self.kinds[slot], self.behaviours[slot]
        )

    def _use_rows(self, slot: int, rows: PathRows, position_m: float) -> None:
        truth = self.truths[slot]
        truth.profile_offset, truth.profile_rows = rows.offset, rows.rows
        ahead = _first_beyond(self.pool.tag_positions_m, rows.tag_first, rows.tag_end, position_m)
        truth.tag_next, truth.tag_end = ahead, rows.tag_end
        places_m = self.pool.places["position_m"]
        truth.beacon_next = _first_beyond(places_m, rows.beacon_first, rows.markers_first, position_m)
        truth.markers_next = _first_beyond(places_m, rows.markers_first, rows.markers_end, position_m)
        truth.beacon_end, truth.markers_end = rows.markers_first, rows.markers_end

    def set_boundaries(self, slot: int) -> None:
        """The next ends of pieces that the front and the rear pass."""
        truth = self.truths[slot]
        path = self.true_path(slot)
        rear_m = float(truth.position_m) - float(self.bodies[slot].length_m)
        front_end_m = path.step_at(float(truth.position_m)).end_m
        truth.track_end_m = path.length_m
        truth.front_boundary_m = min(front_end_m, path.length_m - END_OF_TRACK_M)
        rear_end_m = path.step_at(rear_m).end_m
        truth.rear_boundary_m = rear_end_m if rear_end_m < path.length_m - 1e-9 else math.inf

    def divert(self, slot: int, onto_piece: str) -> None:
        """Points lie otherwise than the path expects: the train runs onto `onto_piece` and straight on from there."""
        path = self.true_path(slot)
        at = path.piece_ids.index(self._piece_before(slot))
        pieces = [*path.piece_ids[: at + 1], onto_piece]
        while following := next_pieces(self.setup.line, pieces[-1], path.direction):
            pieces.append(following[0])
        diverted = path_of(self.setup.line, pieces, path.direction)
        self.carrier.reroute(self.stock_ids[slot], pieces[at:], path.direction)
        self.paths[slot] = diverted
        self._use_rows(slot, self.rows_of(slot, diverted), float(self.truths[slot].position_m))

    def at_end_of_track(self, slot: int) -> bool:
        """Whether the front has reached the end of all track."""
        return bool(self.truths[slot].position_m >= self.true_path(slot).length_m - END_OF_TRACK_M)

    def _piece_before(self, slot: int) -> str:
        """The piece whose end the front has just reached."""
        return self.true_path(slot).step_at(float(self.truths[slot].front_boundary_m) - 1e-6).piece_id

    def crossing(self, slot: int) -> tuple[str, str]:
        """The piece that the front leaves and the one that its path expects next."""
        path = self.true_path(slot)
        before = self._piece_before(slot)
        return before, path.piece_ids[path.piece_ids.index(before) + 1]

    # sensors -------------------------------------------------------------------------------------------------------

    def read_tag(self, slot: int) -> tuple[int, int | None, float]:
        """The tag just passed: its id, the id read (None: not read), the tachometer reading latched with it."""
        truth = self.truths[slot]
        tag_id = self.pool.tag_ids[int(truth.tag_next)]
        truth.tag_next += 1
        says_id = self.tag_faults.get(tag_id, tag_id) if self.reads_tags(slot) else None
        if self.setup.sensors.tags == "bits" and says_id is not None:
            says_id = self._read_bits(slot, says_id)
        return tag_id, says_id, float(self.tag_readers[slot].latched_m)

    def fixes(self) -> dict[str, dict[str, int]]:
        """How many fixes each reader has taken, by stock id and its name."""
        return {
            stock_id: {name: int(readers.taken[number]) for number, name in enumerate(READER_NAMES)}
            for stock_id, readers in zip(self.stock_ids, self.readers, strict=True)
        }

    def reads_tags(self, slot: int) -> bool:
        """Whether the stock carries a reader of tags."""
        return PositionSensor.TAGS in self.setup.sensors.carried_by(self.stock_ids[slot])

    def _read_bits(self, slot: int, tag_id: int) -> int | None:
        """What the reader makes of the telegrams of a tag; drawn by seed, stock and time, whatever came before."""
        setup, now_s = self.setup, float(self.stock["sensed"]["now_s"][slot])
        chance = generator(setup.seed, "tag bits", self.stock_ids[slot], f"{now_s:.1f}", *setup.today)
        channel = channel_at(float(self.plants[slot].speed_mps), setup.sensors.tag_bit_error_factor)
        return read_bits(chance, tag_id, channel)

    def direction(self, slot: int) -> Direction:
        """Direction of travel of the present path."""
        return self.true_path(slot).direction
