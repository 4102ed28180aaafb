"""A road over the RTRI test line's open section, barriers that move by a list of times, and SUMO with both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from network.files.crossing_road import CrossingRoad
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Line
from simulation.carriers.road import Road
from simulation.carriers.road_shown import OPEN, CrossingShown
from simulation.carriers.sumo_road import SumoRoadCarrier
from simulation.events import BarrierState
from sumo_cfg.build import net_for
from sumo_cfg.road_net import RoadAt

LINE: Final[Line] = load_line(shipped_line("rtri_test_line"))
CROSSING: Final = "C1"
PIECE: Final = "6"  # from 530 m to 880 m
POSITION_M: Final = 700.0
WARNING_S, LOWERING_S, RISING_S = 5.0, 7.0, 6.0


def road_of(**settings: object) -> CrossingRoad:
    """A road without vehicles, but for what is set."""
    return CrossingRoad.model_validate({"vehicles_per_h": (0.0,)} | settings)


def road_at(road: CrossingRoad) -> RoadAt:
    return RoadAt(CROSSING, PIECE, POSITION_M, road, has_detector=True)


@dataclass
class Closures:
    """Barriers that are to be shut in some times, s from midnight: before, lamps flash and they come down."""

    times_s: Sequence[tuple[float, float]]

    def shown(self, now_s: float) -> CrossingShown:
        for shut_s, until_s in self.times_s:
            if shut_s - LOWERING_S - WARNING_S <= now_s < shut_s - LOWERING_S:
                return CrossingShown(BarrierState.RAISED, lamps=True)
            if shut_s - LOWERING_S <= now_s < shut_s:
                return CrossingShown(BarrierState.LOWERING, lamps=True)
            if shut_s <= now_s < until_s:
                return CrossingShown(BarrierState.LOWERED, lamps=True)
            if until_s <= now_s < until_s + RISING_S:
                return CrossingShown(BarrierState.RISING, lamps=False)
        return OPEN


class RoadByList(Road):
    """A road whose crossings show what a list of times says, at each look."""

    closures: Closures = Closures(())

    def _look(self) -> None:
        for at in self.roads:
            self.show(at.crossing_id, self.closures.shown(self._step / 10.0))
        super()._look()


@dataclass
class Detected:
    """What a detector was told, with the step."""

    told: list[tuple[str, int, bool]] = field(default_factory=list)

    def obstacle(self, crossing_id: str, at_step: int, *, present: bool) -> None:
        self.told.append((crossing_id, at_step, present))


@dataclass
class Carried:
    """A carrier with a road, and what SUMO said of the road's vehicles in each step."""

    road: Road
    carrier: SumoRoadCarrier
    detectors: Detected
    steps: int = 0

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> None:
        """Run so many steps, whatever happens between."""
        done = 0
        while done < steps:
            left = [(unit_id, speeds[done:]) for unit_id, speeds in columns]
            done += self.carrier.run(left, steps - done) or steps - done
            self.road.tell(self.detectors)
        self.steps += steps

    def over(self) -> set[str]:
        """Vehicles with their front between the stop lines."""
        import libsumo

        lanes = (lane for lane in libsumo.lane.getIDList() if ".over_" in lane)
        return {vehicle_id for lane in lanes for vehicle_id in libsumo.lane.getLastStepVehicleIDs(lane)}


def carried(
    folder: Path, road: CrossingRoad, closures: Sequence[tuple[float, float]] = (), end_s: float = 3600.0
) -> Carried:
    """From midnight on; close the carrier."""
    at = road_at(road)
    made = RoadByList(LINE, [at], folder, seed=1, end_s=end_s)
    made.closures = Closures(closures)
    return Carried(made, SumoRoadCarrier(net_for(LINE, folder, [at]), 0.0, made), Detected())
