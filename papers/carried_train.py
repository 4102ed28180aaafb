"""The bench's train on the plain carrier, a step at a time: for sensors that are not compiled, such as a real camera.

The same rows, kernel and tick as in `single_train`, by `simulation.world.kernel.advance`; the carrier executes the
speeds and its position is compared with theirs after every step, as on the line.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from network.model import Direction
from papers.single_run import Rows, begin, lay_track
from papers.single_train import STOCK_ID, Bench
from simulation.carriers.plain_track import PlainTrack
from simulation.setup import STEP_S
from simulation.world.kernel import advance, new_sheet
from simulation.world.records import TRACE, StockRow
from simulation.world.trains import AGREEMENT_M, CarrierDisagrees

PIECE: str = "track"


class CarriedTrain:
    """One stop in progress. `row` is the train's row of STOCK; path coordinates, the mark at `mark_m`."""

    def __init__(self, bench: Bench, stop: Rows) -> None:
        """`stop`: shape (1,); its beacons and signs are left to whoever steps."""
        self.track, heights = bench.track(stop)
        self.stock = bench.prepared.copy()
        self.row: StockRow = self.stock.view(np.recarray)[0]
        self.begin_m = bench.begin_m
        self.mark_m = self.begin_m + float(stop["start_m"][0])
        self.row.board.unit.path_rows = self.track.pattern.size
        self.row.truth.profile_rows = self.track.profile.size
        lay_track(self.track, heights, stop[0], self.stock[0], self.mark_m)
        begin(self.stock[0], stop[0], self.begin_m, bench.unit.standoff_m)
        self.steps = 0
        self._sheet, self._trace = new_sheet(1), np.zeros(1, dtype=TRACE)
        self._carrier = PlainTrack({PIECE: float(self.track.profile.size - 1)}, STEP_S)
        length_m, speed_mps = float(self.row.body.length_m), float(self.row.plant.speed_mps)
        self._carrier.insert(STOCK_ID, [PIECE], Direction.DOWN, self.begin_m, length_m, speed_mps)

    @property
    def stands(self) -> bool:
        """Whether the train has come to rest."""
        return bool(self.row.plant.speed_mps <= 0.0)

    @property
    def past_mark_m(self) -> float:
        """How far the front is past the mark, m; negative before it."""
        return float(self.row.truth.position_m) - self.mark_m

    def step(self) -> None:
        """One step of the world: kernel, carrier, comparison. CarrierDisagrees if they differ."""
        advance(self.stock, self.track, self._sheet, self._trace, 0, self.steps, 1)
        self.steps += 1
        speeds: Any = self._sheet.speeds_mps[0, :1]
        self._carrier.run([(STOCK_ID, speeds)], 1)
        seen_m, sum_m = self._carrier.truth(STOCK_ID).offset_m, float(self.row.truth.position_m)
        if abs(seen_m - sum_m) > AGREEMENT_M:
            raise CarrierDisagrees(f"carrier has the train at {seen_m:.6f} m, its speeds at {sum_m:.6f} m")
