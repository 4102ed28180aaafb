"""What each part of the stop law is worth on the stops of table 4: the law with one part left out at a time.

A part that could be left out without any measure noticing would have no place in the law. Each has the measure by
which it was put in, and leaving it out must at least double that.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from onboard.driving.tasc import StopLawPart
from papers.reproduction import CaseRow
from papers.single_train import Bench
from papers.table4_stops import ACCURACY_M, CASES, NOTHING, cells_of_table4, controller, trial_stops

WORSE_TIMES: Final = 1.5


class StopMeasure(Enum):
    """How a controller is judged; the value is how it is printed."""

    UNHINDERED_M = "mean distance from the mark without position error, m"
    WORST_M = "worst of the 20 stops that the paper makes within 1 m, m"
    REST_MPS2 = "deceleration that ends at rest, m/s^2"


@dataclass(frozen=True, slots=True)
class Ablation:
    """What is left out of the law, and the measure that must be worse for it."""

    name: str
    without: StopLawPart
    measure: StopMeasure
    gain_share: float = 1.0


ABLATIONS: Final = (
    Ablation("prediction", StopLawPart.PREDICTION, StopMeasure.UNHINDERED_M),
    Ablation("redrawing", StopLawPart.REDRAWING, StopMeasure.WORST_M),
    Ablation("the pattern's own deceleration", StopLawPart.FEED_FORWARD, StopMeasure.WORST_M),
    Ablation("gradient and running resistance", StopLawPart.RESISTANCE, StopMeasure.UNHINDERED_M),
    Ablation("the soft end", StopLawPart.SOFT_END, StopMeasure.REST_MPS2),
    Ablation("gain", NOTHING, StopMeasure.WORST_M, gain_share=0.0),
)


def all_measures(bench: Bench) -> dict[StopMeasure, float]:
    """All measures of one controller."""
    trials, _ = bench.run(trial_stops())
    cells, _ = bench.run(cells_of_table4())
    passing = [case.paper_m <= ACCURACY_M for case in CASES]
    return {
        StopMeasure.UNHINDERED_M: float(np.abs(trials["error_m"]).mean()),
        StopMeasure.WORST_M: float(np.abs(cells["error_m"][passing]).max()),
        StopMeasure.REST_MPS2: float(trials["rest_mps2"].max()),
    }


def controller_without(ablation: Ablation, gain_per_s: float) -> Bench:
    """The controller of table 4 with a part left out."""
    bench = controller(gain_per_s, without=ablation.without)
    bench.design.gain_per_s *= ablation.gain_share
    return bench


def ablation_rows(gain_per_s: float) -> tuple[CaseRow, ...]:
    """A row for each part: the whole law's measure, and that without the part."""
    whole = all_measures(controller(gain_per_s))
    rows: list[CaseRow] = []
    for ablation in ABLATIONS:
        measure = ablation.measure
        less = all_measures(controller_without(ablation, gain_per_s))
        ours = {"whole": round(whole[measure], 4), "without": round(less[measure], 4)}
        worse = less[measure] >= WORSE_TIMES * whole[measure]
        criterion = f"{measure.value}: at least {WORSE_TIMES:g} times as much without"
        rows.append(CaseRow(f"law without {ablation.name}", None, ours, worse, criterion))
    return tuple(rows)
