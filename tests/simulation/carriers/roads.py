"""A road over the RTRI test line's open section, in SUMO, with a detector that remembers what it was told."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from network.files.crossing_road import CrossingRoad
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Line
from simulation.carriers.sumo_road import SumoRoadCarrier
from study.evaluate.road_queueing import Closures, RoadByList, RoadRun
from sumo_cfg.build import net_for
from sumo_cfg.road_net import RoadAt

LINE: Final[Line] = load_line(shipped_line("rtri_test_line"))
CROSSING: Final = "C1"
PIECE: Final = "6"  # from 530 m to 880 m
POSITION_M: Final = 700.0


def road_of(**settings: object) -> CrossingRoad:
    """A road without vehicles, but for what is set."""
    return CrossingRoad.model_validate({"vehicles_per_h": (0.0,)} | settings)


def road_at(road: CrossingRoad) -> RoadAt:
    return RoadAt(CROSSING, PIECE, POSITION_M, road, has_detector=True)


@dataclass
class Detected:
    """What a detector was told, with the step."""

    told: list[tuple[str, int, bool]] = field(default_factory=list)

    def obstacle(self, crossing_id: str, at_step: int, *, present: bool) -> None:
        self.told.append((crossing_id, at_step, present))


def carried(
    folder: Path, road: CrossingRoad, closures: Sequence[tuple[float, float]] = (), end_s: float = 3600.0
) -> RoadRun:
    """From midnight on; close the carrier."""
    at = road_at(road)
    made = RoadByList(LINE, [at], folder, seed=1, end_s=end_s)
    made.closures = Closures(closures)
    return RoadRun(made, SumoRoadCarrier(net_for(LINE, folder, [at]), 0.0, made), Detected())
