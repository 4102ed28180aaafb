"""What a unit that collates curvature shows along a stretch of the way, every few metres, for figures 4 and 6."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.curvature_row import WINDOW_MAX
from simulation.world.trains import Trains
from study.papers.position_run import Moment

EVERY_M: Final = 10.0
ROWS: Final = np.dtype(
    [
        ("true_m", "f8"),  # kilometrage
        ("speed_mps", "f8"),
        ("wheel_mps", "f8"),
        ("map_per_m", "f8"),  # where the unit believes to be
        ("run_per_m", "f8"),
        ("mismatch_per_m", "f8"),
        ("outcome", "i8"),
        ("error_m", "f8"),
        ("behind_m", "f8"),
        ("ahead_m", "f8"),
        ("slid_m", "f8"),  # train's way less that of its measured wheels, since the run began
    ]
)


@dataclass(slots=True)
class Watch:
    """Looks while the front is between two kilometrages (m)."""

    from_m: float
    to_m: float
    threshold_per_m: float
    _seen: list[tuple[float, ...]] = field(default_factory=list[tuple[float, ...]])

    def moments(self) -> list[Moment]:
        """To be given to a run."""
        return [
            Moment(float(at_m), lambda trains, slot, at_m=at_m: self._look(trains, slot, float(at_m)))  # type: ignore[misc]
            for at_m in np.arange(self.from_m, self.to_m, EVERY_M)
        ]

    @property
    def rows(self) -> NDArray[np.void]:
        """Rows of ROWS, one a look."""
        return np.array(self._seen, dtype=ROWS)

    def between(self, from_m: float, to_m: float) -> NDArray[np.void]:
        """Those of a stretch."""
        rows = self.rows
        return rows[(rows["true_m"] >= from_m) & (rows["true_m"] < to_m)]

    def _look(self, trains: Trains, slot: int, at_m: float) -> None:
        unit, plant, truth = trains.units[slot], trains.plants[slot], trains.truths[slot]
        own: Any = trains.readers[slot].curvature
        newest = (int(own.at) - 1) % WINDOW_MAX
        row = min(max(round(float(unit.position_m)), 0), int(unit.path_rows) - 1) + int(unit.path_offset)
        self._seen.append(
            (
                at_m,
                float(plant.speed_mps),
                float(unit.speed_mps),
                float(trains.pool.pattern["curvature_per_m"][row]),
                float(own.bent_per_m[newest]),
                float(own.mismatch_per_m),
                outcome_of(trains, slot),
                float(unit.position_m - truth.position_m),
                float(unit.bound_behind_m),
                float(unit.bound_ahead_m),
                float(plant.travelled_m - plant.wheel_travelled_m),
            )
        )


def outcome_of(trains: Trains, slot: int) -> int:
    """What came of the last comparison that said anything."""
    from onboard.localisation.table import READER_NAMES

    return int(trains.readers[slot].outcome[READER_NAMES.index("curvature")])
