"""What a unit keeps for curvature collation: what it knows beforehand, the ring of the last metres, the comparison."""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from network.files.kinds import about
from network.files.quantities import CurvatureError, MatchedWay, SearchedWay, Sigmas
from network.files.toml_input import Record

BY_SPACE: Final = 0  # what run and map are filtered by
BY_TIME: Final = 1
UNFILTERED: Final = 2

WINDOW_MAX: Final = 800
SEARCH_MAX: Final = 400
RISES_M: Final = 60  # metres over which the filter takes up a step, but for some thousandths
MARGIN_M: Final = 5  # searched beyond the bounds
SHIFTS: Final = 2 * (SEARCH_MAX + MARGIN_M) + 4


class CurvatureReading(Protocol):
    """What the gyro shows."""

    taken: Annotated[int, "0: it shows nothing"]
    yaw_radps: Annotated[float, "mean yaw rate of the step, to the right"]


class CurvatureComparison(Record):
    """Of `[curvature]`, how run and map are compared."""

    window_m: Annotated[MatchedWay, about("longest distance compared, N_r", "Harada, figure 2: 600 m")] = (
        600.0
    )
    window_least_m: Annotated[
        MatchedWay, about("shortest distance compared, after a path has begun", "assumed: about a curve")
    ] = 100.0
    search_m: Annotated[
        SearchedWay,
        about(
            "greatest distance searched in both directions, N_s; never beyond the bounds",
            "Harada, figure 2: 200 m",
        ),
    ] = 200.0
    every_m: Annotated[
        MatchedWay, about("distance between two comparisons", "assumed: about one a second at line speed")
    ] = 25.0
    transition_m: Annotated[
        MatchedWay,
        about("least length of transition curve in what is compared (section 3.4)", "assumed: half of one"),
    ] = 20.0
    mismatch_per_m: Annotated[
        CurvatureError,
        about(
            "root mean square of the difference beyond which the track counts as foreign (equation 3)",
            "assumed: four times what rails of high disturbance leave after the filter",
        ),
    ] = 2.5e-4
    sure_sigmas: Annotated[
        Sigmas, about("standard deviations covered by the bounds of a fix", "assumed: one in two million")
    ] = 5.0


class CurvatureRow(Protocol):
    """What the unit knows of its gyro and its line, and keeps of the last metres."""

    # known beforehand
    fitted: int
    filtered: Annotated[int, "BY_SPACE, BY_TIME or UNFILTERED"]
    numbers: Annotated[list[float], 10, "of the filter's sections, by metre or by step"]
    rises: Annotated[list[float], RISES_M, "what it has made of a step of 1 by each metre behind it"]
    settings: CurvatureComparison
    worn_share: Annotated[float, "most that wheels are worn by"]
    varies_share: Annotated[
        float, "most that their count differs from their mean, on any way: a climb, curves to one side"
    ]
    doubtful_share: Annotated[float, "bounds that grow faster are those of a unit in doubt of its wheels"]
    gain_share: Annotated[float, "the gyro's gain may be wrong by this"]
    bias_walk_radps: Annotated[float, "deviation of the bias in the long run"]
    bias_walk_s: float
    yaw_density: Annotated[float, "variance of the yaw rate times the step: white noise, rad^2/s"]
    body_delay_s: float
    delay_share: Annotated[float, "what body_delay_s may be wrong by"]
    filter_delay_m: Annotated[float, "of the filter, where it is not the map's; 0: it is"]
    filter_mps: float
    map_error_m: float
    map_slope2_per_m: Annotated[
        float, "what a metre of rails, and no curve, adds to slope2 of a measured map"
    ]
    rail_level: Annotated[float, "variance of the rails' heading a metre, as of white noise"]
    rail_peak: Annotated[
        float, "greatest spectral density of their filtered curvature, as a variance a metre"
    ]
    rail_variance_per_m2: Annotated[float, "of their filtered curvature"]
    rail_heading_rad: Annotated[float, "deviation of their filtered heading"]
    forgives_jumps: Annotated[int, "1: no jump of the bias is in the interval; for experiments alone"]
    # the wheels
    path: Annotated[int, "unit.paths_taken_up as it was"]
    odometer_m: float
    slid_ahead_m: Annotated[float, "unit's, as it was"]
    slipped_behind_m: float
    along_m: Annotated[float, "run since the path was taken up, by the calibrated wheels"]
    ahead_m: Annotated[float, "what the run may be short by in all"]
    behind_m: float
    scale_low: Annotated[float, "true way over the wheels' count in the long run, at least"]
    scale_high: float
    anchored: Annotated[int, "1: there is a fix to compare the wheels with"]
    anchor_odometer_m: float
    anchor_low_m: float
    anchor_high_m: float
    anchor_slid_m: float
    anchor_slipped_m: float
    # the estimate, apart from its bounds
    within_m: Annotated[float, "half the interval that it came from, and the run since; 0: not known"]
    bounds_m: Annotated[float, "both bounds of the unit, as they were"]
    # the gyro
    bias_radps: float
    bias_radps2: Annotated[float, "its variance"]
    bias_metre: Annotated[int, "in the ring, when map and run last told of it"]
    stood_steps: int
    last_radps: float
    same: Annotated[int, "readings in a row that were equal"]
    # the metres
    heading_rad: Annotated[float, "turned since the path was taken up"]
    reached_m: Annotated[float, "where along the heading has come to"]
    metre: Annotated[int, "the last whole metre in the ring"]
    metre_rad: Annotated[float, "heading there"]
    metres: Annotated[int, "in the ring without a break"]
    settling_m: Annotated[float, "until the filter has settled"]
    held_per_m: Annotated[float, "the last curvature, while the train crawls"]
    kept: Annotated[list[float], 4, "of the filter"]
    next_m: Annotated[float, "along, of the next comparison"]
    at: Annotated[int, "where the next metre goes"]
    bent_per_m: Annotated[
        list[float], 2 * WINDOW_MAX, "the ring, twice, so that every window lies in one piece"
    ]
    slow_s_per_m: Annotated[list[float], 2 * WINDOW_MAX, "one over the speed then"]
    then_ahead_m: Annotated[list[float], 2 * WINDOW_MAX, "ahead_m then"]
    then_behind_m: Annotated[list[float], 2 * WINDOW_MAX]
    then_jolt_m: Annotated[list[float], 2 * WINDOW_MAX, "slides and slips until then"]
    # the last comparison
    compared: Annotated[int, "how many there have been"]
    whole: Annotated[int, "metres of it, by which the mismatch goes"]
    count: Annotated[int, "of these, by which the fix goes"]
    low: Annotated[int, "the first shift, m"]
    span: Annotated[int, "shifts beyond it"]
    mismatch_per_m: Annotated[float, "root of the least mean square of the difference"]
    mean_per_m: Annotated[float, "mean difference at the best shift: bias"]
    slope2: Annotated[float, "of the map at the best shift: sum of squares of its change from metre to metre"]
    bend2: Annotated[float, "and of the change of that"]
    left: Annotated[float, "of slope2 without its mean, and without what rails make of it"]
    slow_mean_s_per_m: float
    misfit: Annotated[float, "sum of squares that scale, gain and bias may leave"]
    pull_ahead_m: Annotated[float, "by which the front may be further than a fix says, for all but noise"]
    pull_behind_m: float
    unseen_m: Annotated[float, "of it, what a foreign track may do before it is noticed"]
    known_per_m: Annotated[list[float], WINDOW_MAX + SHIFTS, "the map in the window"]
    energy: Annotated[list[float], SHIFTS]
    free: Annotated[list[float], SHIFTS]
