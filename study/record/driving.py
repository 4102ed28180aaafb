"""How a hop was driven: the rows of the table `driving`, and what their figures are called and mean.

A hop is a way from a place where the train stops to the next. Notches and jerk are counted in every step of 0.1 s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from study.record.columns import From, Revenue, To, Train, kwh
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.catalogue import phrase

_EVERYWHERE: Final = ShownIn.SUMS | ShownIn.TOTALS_COMPARED | ShownIn.ROWS_COMPARED | ShownIn.ROWS_LISTED
_FILES: Final = ShownIn.SUMS | ShownIn.TOTALS_COMPARED | ShownIn.ROWS_COMPARED
_TOTALS: Final = ShownIn.SUMS | ShownIn.TOTALS_COMPARED
LAW: Final = Figure(phrase("driving law"), seen=ShownIn.REPORT, kind=Kind.TEXT)


def _changes(name: str, seen: ShownIn) -> Figure:
    return Figure(phrase(name), "", 1, Adds.MEAN, seen=seen)


def _share(name: str, over: str, seen: ShownIn = ShownIn.NOWHERE) -> Figure:
    of = phrase("{what}, of the time" if over == "run_s" else "{what}, of the way")
    return Figure(of.fill(what=phrase(name)), "%", 1, Adds.WEIGHED_MEAN, over, seen)


@dataclass(frozen=True, slots=True)
class DrivenHop:
    """One hop as driven: running energy is traction less what came back, without auxiliaries.

    Shares are of the time in which the train moved and of the way. `late_s` counts from the latest arrival that keeps
    the plan, negative when early, as `HopMargin.left_s` does; it is None where nothing was planned, `stop_error_m` also
    where the train did not come.
    """

    unit: str
    train: Train
    revenue: Revenue
    law: Annotated[str, LAW, "`onboard.driving.laws.table`"]
    from_station: From
    to_station: To
    begin_s: Annotated[float, "when it began to move"]
    run_s: Annotated[float, "moving"]
    distance_m: float
    traction_kwh: Annotated[float, kwh("traction", ShownIn.SUMS)]
    regenerated_kwh: Annotated[float, kwh("regenerated", ShownIn.SUMS)]
    running_kwh: Annotated[float, kwh("traction less what came back", _EVERYWHERE)]
    power_changes: Annotated[int, _changes("power notch changes a hop", _EVERYWHERE), "the first one too"]
    brake_changes: Annotated[
        int, _changes("brake notch changes a hop", _FILES), "the release at the start too"
    ]
    jerk_max_mps3: Annotated[
        float,
        Figure(phrase("largest jerk"), "m/s³", 2, Adds.LARGEST, seen=_TOTALS),
        "of the true acceleration from step to step; the step that ends in a stand left out",
    ]
    jerk_rms_mps3: Annotated[
        float,
        Figure(phrase("jerk, rms"), "m/s³", 3, Adds.WEIGHED_ROOT_MEAN_SQUARE, "run_s", _FILES),
    ]
    jolt_mps2: Annotated[
        float,
        Figure(phrase("jolt at the stop"), "m/s²", 2, Adds.LARGEST),
        "deceleration in the last whole step before the stand",
    ]
    coasting_time_percent: Annotated[float, _share("coasting", "run_s", ShownIn.TOTALS_COMPARED)]
    coasting_way_percent: Annotated[float, _share("coasting", "distance_m", _EVERYWHERE)]
    cruising_time_percent: Annotated[
        float, _share("even speed under power", "run_s"), "within 0.1 m/s² of even speed"
    ]
    cruising_way_percent: Annotated[float, _share("even speed under power", "distance_m", _TOTALS)]
    braking_time_percent: Annotated[float, _share("braking", "run_s")]
    braking_way_percent: Annotated[float, _share("braking", "distance_m", _TOTALS)]
    late_s: Annotated[
        float | None, Figure(phrase("late"), "s", 1, seen=ShownIn.ROWS_COMPARED | ShownIn.ROWS_LISTED)
    ]
    stop_error_m: float | None


# Of several hops together alone.
EARLY: Final = Figure(phrase("arrival before the time, mean"), "s", 1, kind=Kind.SIGNED)
