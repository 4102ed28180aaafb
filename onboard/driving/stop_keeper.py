"""What a train keeps of its stops (event-driven part of TASC): its own characteristic, learned from the waves.

Learning works on the deceleration as designed after the designed lag, so what is learned as dead time is the dead
time alone; Oda's designed deceleration (chapter 4) has no lag in its model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from onboard.driving.stopping import WAVE_STEPS, WaveRow
from onboard.driving.tasc import WHOLE_LAW, DesignRow, StopVerdict, TascRow
from onboard.driving.tuning import Learned, StopDecelerations, approximate, disturbance, learned_after_stop
from onboard.notes import LearnedFromStop
from onboard.records import BehaviourRow
from vehicle.records import TrainRow

LEAD_STEPS: Final = 25  # before TASC began to brake; the learner wants 2 s of quiet
END_MPS2: Final = 0.30  # Oda's train in 3.2, as in `branchline reproduce oda-table4`
END_JERK_MPS3: Final = 0.60
PATTERN_LEAST_SHARE: Final = 0.5
CORRECTION_LEAST_M: Final = 0.05  # assumed: smaller corrections are within a fix's own scatter
JERK_MPS3: Final = 2.0  # assumed, where the train file limits no jerk


def fill_design(design: DesignRow, train: TrainRow, behaviour: BehaviourRow, learned: Learned) -> None:
    """Set a DESIGN row from the train file, the driving parameters and what the train has learned."""
    strongest_mps2 = train.brake_deceleration_mps2[int(train.brake_notches)]
    design.parts = int(WHOLE_LAW)
    design.pattern_mps2 = min(behaviour.settings.stop_deceleration_mps2, strongest_mps2)
    design.pattern_least_mps2 = PATTERN_LEAST_SHARE * design.pattern_mps2
    design.brake_max_mps2 = strongest_mps2
    design.command_jerk_mps3 = train.brake_jerk_max_mps3 or JERK_MPS3
    design.end_mps2 = min(END_MPS2, design.pattern_mps2)
    design.end_jerk_mps3 = END_JERK_MPS3
    design.gain_per_s = behaviour.settings.stop_gain_per_s
    design.integral_gain_per_s2 = 0.0
    design.derivative_gain = 0.0
    design.dead_time_s = learned.dead_time_s
    design.lag_s = train.brake_lag_s
    design.offset_mps2 = learned.offset_mps2
    design.correction_least_m = CORRECTION_LEAST_M
    design.step_s = behaviour.step_s


def soft_end_s(pattern_mps2: float) -> float:
    """How much later a stop comes to rest by its soft end than if it braked evenly all the way, s.

    The deceleration falls at an even rate from b to e within (b - e) / jerk, so half of that is lost of b - e in b.
    """
    eased_mps2 = pattern_mps2 - min(END_MPS2, pattern_mps2)
    return eased_mps2**2 / (2.0 * pattern_mps2 * END_JERK_MPS3)


@dataclass(slots=True)
class StopKeeper:
    """One train's records of TASC and what it has learned. It outlives the unit's boots: the memory is kept."""

    tasc: TascRow
    design: DesignRow
    wave: WaveRow
    learned: Learned
    learns: bool = False
    last: StopDecelerations | None = None  # the last stop that was counted

    def verdict(self) -> StopVerdict:
        """Whether the present stop is possible."""
        return StopVerdict(int(self.tasc.verdict))

    def learn_from_stop(
        self, train: TrainRow, behaviour: BehaviourRow, load_share: float
    ) -> LearnedFromStop | None:
        """Learn from the stop just made and use it from the next one on; what the journal says of it."""
        record = self.record(load_share)
        if not self.learns or record is None:
            return None
        fit = approximate(record, self.learned.centre)
        why = disturbance(record, fit)
        self.learned = learned_after_stop(self.learned, record, fit)
        if why is None:
            self.last = record
        fill_design(self.design, train, behaviour, self.learned)
        return LearnedFromStop(
            left_out=why,
            dead_time_s=None if fit is None else round(fit.dead_time_s, 1),
            offset_mps2=None if fit is None else round(fit.offset_mps2, 4),
            uses_dead_time_s=round(self.learned.dead_time_s, 1),
            uses_offset_mps2=round(self.learned.offset_mps2, 4),
        )

    def record(self, load_share: float) -> StopDecelerations | None:
        """The waves of the stop just made, up to rest; None where TASC did not brake."""
        wave = self.wave
        if wave.steps == 0:
            return None
        count = min(int(wave.steps) + LEAD_STEPS, WAVE_STEPS)
        order = (int(wave.head) + 1 - count + np.arange(count)) % WAVE_STEPS
        return StopDecelerations(
            np.asarray(wave.designed_mps2, dtype=np.float64)[order],
            np.asarray(wave.actual_mps2, dtype=np.float64)[order],
            bool(wave.disturbed),
            load_share,
        )


def believed_dead_time_s(train: TrainRow) -> float:
    """Dead time (無駄時間) of the service brake as the train file has it, s, on the learner's grid of 0 to 2 s."""
    return min(float(train.brake_dead_time_s), 2.0)
