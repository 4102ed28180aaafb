"""Stretches that the kernel has run and the carrier has not, so that they can still be cut shorter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulation.setup import STEP_S
from simulation.world.kernel import Sheet, advance, new_sheet
from simulation.world.records import TRACE
from simulation.world.trains import Trains

TRACE_ROWS_FIRST: Final = 20_000
SAMPLES_BACK: Final = 6000  # looked at for the last one of a train


class TrainMotion(NamedTuple):
    """Where a train's front is on its path, m, and how fast it runs, m/s."""

    position_m: float
    speed_mps: float


class ForeseenStretch(NamedTuple):
    """`before` and `first_row`: the stocks and the use of the trace as it began, so that it can be run anew."""

    done: int  # steps
    movers: int
    first_row: int
    before: NDArray[np.void] | None

    def moving(self, sheet: Sheet) -> list[int]:
        """Slots of the trains that move in it."""
        movers: list[int] = sheet.movers[: self.movers].tolist()
        return movers

    def motion_of(self, slot: int, steps: int, sheet: Sheet) -> TrainMotion:
        """A train after so many steps of the stretch, of which `sheet` tells. ValueError where it is not foreseen."""
        if self.before is None:
            raise ValueError("nobody foresees this stretch")
        begun = self.before[slot]
        position_m, speed_mps = float(begun["truth"]["position_m"]), float(begun["plant"]["speed_mps"])
        movers = self.moving(sheet)
        if slot not in movers or steps == 0:
            return TrainMotion(position_m, speed_mps)
        speeds = np.concatenate(([speed_mps], sheet.speeds_mps[movers.index(slot), :steps]))
        run_m = float(np.sum(speeds[:-1] + speeds[1:])) * STEP_S / 2.0
        return TrainMotion(position_m + run_m, float(speeds[-1]))


class Stretches:
    """The compiled kernel at work, and the trace of all that it ran. `sheet` is of the stretch that it ran last."""

    def __init__(self, trains: Trains) -> None:
        self._trains = trains
        self._trace = np.zeros(TRACE_ROWS_FIRST, dtype=TRACE)
        self._trace_used = 0
        self.sheet: Final = new_sheet(len(trains.stock_ids))

    def run(self, step: int, end_step: int, *, keep: bool) -> ForeseenStretch:
        """Run the stretch that begins at `step`; if its beginning is to be kept, it can be run `again`."""
        stock = self._trains.stock
        # As bytes: numpy copies records field by field, which takes as long as a stretch itself.
        return self._run(step, end_step, stock.view(np.uint8).copy().view(stock.dtype) if keep else None)

    def again(self, ahead: ForeseenStretch, step: int, end_step: int) -> ForeseenStretch:
        """Run a stretch whose beginning was kept as far as `end_step` instead."""
        if ahead.before is None:
            raise ValueError("the beginning of this stretch was not kept")
        self._trains.stock[:] = ahead.before
        self._trace_used = ahead.first_row
        return self._run(step, end_step, ahead.before)

    def _run(self, step: int, end_step: int, before: NDArray[np.void] | None) -> ForeseenStretch:
        trains, steps, first_row = self._trains, end_step - step, self._trace_used
        if first_row + steps * len(trains.stock_ids) > self._trace.size:
            self._trace = np.concatenate([self._trace, np.zeros(self._trace.size, dtype=TRACE)])
        done, self._trace_used, movers = advance(
            trains.stock, trains.pool.track, self.sheet, self._trace, first_row, step, steps
        )
        return ForeseenStretch(done, movers, first_row, before)

    def columns(self, ahead: ForeseenStretch, first: int, last: int) -> list[tuple[str, Sequence[float]]]:
        """Who moves in the stretch that was run last, and his speeds, m/s, in its steps `first` to `last` - 1."""
        speeds = self.sheet.speeds_mps[: ahead.movers, first:last].tolist()
        stock_ids = [self._trains.stock_ids[slot] for slot in ahead.moving(self.sheet)]
        return list(zip(stock_ids, speeds, strict=True))

    def sample_at(self, slot: int, step: int) -> np.void | None:
        """The last sample of a train's run until a step; None: it has not run for long, or not yet."""
        first = max(0, self._trace_used - SAMPLES_BACK)
        own = self._trace[first : self._trace_used]
        own = own[(own["slot"] == slot) & (own["step"] <= step)]
        return own[-1] if own.size else None

    def trace(self) -> NDArray[np.void]:
        """All samples, in the order in which they were run."""
        return self._trace[: self._trace_used].copy()
