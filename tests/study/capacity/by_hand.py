"""Two blocks by hand: what is asked of theory and what a pencil says of it.

The paper's test line, level and straight; a train comes in by portal PW, stops at A and ends at B. So that a pencil
suffices the train is a stone of 80 t that pulls 80 kN at any speed and answers at once: 1 m/s2 up to 45 km/h less the
driver's 1.2 m/s, 11.3 m/s, and 0.6 m/s2 down to its marks. Telegrams take 0.1 s and none is lost.

Up to 11.3 m/s: 11.3 s, 63.845 m. Down from it: 18.833 s, 106.408 m. Fronts in m from the mark that the train leaves.
"""

from pathlib import Path

from scenario.scenario import load_scenario
from simulation.result import RunResult
from simulation.setup import Setup
from study.capacity.observed import occupations_run
from study.capacity.occupation import Occupation
from study.measures.register_holds import section_holds
from tests.trains import timetable_of

TIMES = timetable_of(
    "two_blocks",
    "rtri_test_line",
    "T1 down, portal:PW to stabled: A 1 -/10:00:00; B 1 10:00:30/-",
    dwell_min_s=20,
    K1="T1",
)

STONE = """
[patch.train.ev_e301.set]
"body.mass_empty_t" = 80.0
"body.rotating_mass_factor" = 0.0
"body.motored_axle_mass_share" = 1.0
"resistance.motored_constant_n_per_kn" = 0.0
"resistance.motored_linear_n_per_kn_kmh" = 0.0
"resistance.trailer_constant_n_per_kn" = 0.0
"resistance.trailer_linear_n_per_kn_kmh" = 0.0
"resistance.air_n_per_kmh2" = 0.0
"resistance.starting_n_per_kn" = 0.0
"traction.force_max_kn" = 80.0
"traction.power_max_kw" = 4000.0
"traction.dead_time_s" = 0.0
"traction.lag_s" = 0.0
"traction.jerk_max_mps3" = 0.0
"brakes.dead_time_s" = 0.0
"brakes.lag_s" = 0.0
"brakes.jerk_max_mps3" = 0.0
"""

SCENARIO = """
id = "two_blocks"
name = "Two blocks by hand"
line = "rtri_test_line"
timetable = "two_blocks_times.toml"

[trains]
default = "ev_e301"
load_share_mean = 0.0
load_share_spread = 0.0

[air]
delay_min_s = 0.1
delay_mean_s = {delay_s}
"""

POINTS = """
[patch.line.times]
"points.P5.throw_time_s" = {throw_share}
"points.P7.throw_time_s" = {throw_share}
"""


def two_blocks(folder: Path, *, throw_share: float = 1.0, delay_s: float = 0.1, times: str = TIMES) -> Setup:
    """The setup; points take `throw_share` of 6 s to throw."""
    (folder / "two_blocks_times.toml").write_text(times, "utf-8")
    file = folder / "two_blocks.toml"
    text = POINTS.replace("{throw_share}", str(throw_share))
    head = SCENARIO.replace("{delay_s}", str(delay_s))
    file.write_text(head + STONE + text, "utf-8")
    return load_scenario(str(file)).setup


def occupations_of_run(result: RunResult, setup: Setup) -> tuple[Occupation, ...]:
    """The blocking times of a run."""
    return occupations_run(result, setup.line, section_holds(result, setup.line, setup.lengths_m))
