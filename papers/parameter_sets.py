"""How trains of the reproductions are driven: four sets of parameters, and why there is not one.

- `section 3.2`: Oda's simulated stops. Dead time, brake and 1 % are the paper's; the pattern was inferred from two of
  its cells and the gain found by its recipe, so they can belong to no other experiment.
- `line`: what a line run has where its scenario says nothing (`[driving]` and `[unit]` of docs/files.md). Every
  experiment that is not bound to figures of a paper goes by it, whatever train it runs.
- `tenth scale`: Oda's car on 33 m of track. Its speeds and lengths are a tenth while its times are not, so a
  deceleration of the full size does not fit (0.6 m/s^2 would stop it within 1 m of its 4 m).
- `table 1`: the train of Yasunobu and others, whose paper names no pattern. Of decelerations in tenths it has the least
  with which its hop of 80 s on +10 permille leaves a follower of patterns 3 s: 0.8 m/s^2, a usual ATO pattern.

Experiments in which no train stops at a mark by itself have none, and say why.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from onboard.driving_settings import Driving
from onboard.unit_records import UnitParameters
from papers.reproduction import Parameter

CUMULATIVE_ERROR: Final = 0.01  # Oda, 3.2.1: of the distance run


@dataclass(frozen=True, slots=True)
class ParameterSet:
    """One set: how trains are driven to the mark, and what their units believe of their sensors."""

    name: str
    driving: Driving
    unit: UnitParameters
    why: str

    def parameters(self) -> tuple[Parameter, ...]:
        """The set as a reproduction prints it."""
        return (
            Parameter("parameter set", self.name, "", f"one of {len(SETS)}: {self.why}"),
            Parameter("pattern deceleration", self.driving.stop_deceleration_mps2, "m/s^2", self.name),
            Parameter("proportional gain", self.driving.stop_gain_per_s, "1/s", self.name),
            Parameter("bound of a fix at a beacon", self.unit.tag_accuracy_m, "m", self.name),
            Parameter("growth of the bounds", round(self.unit.wheel_error_share, 5), "m per m", self.name),
        )


@dataclass(frozen=True, slots=True)
class NotDriven:
    """No set: why nothing is driven to a mark."""

    why: str

    def parameters(self) -> tuple[Parameter, ...]:
        """That there is none, as a reproduction prints it."""
        return (Parameter("parameter set", "none", "", self.why),)


SECTION_3_2: Final = ParameterSet(
    "section 3.2",
    Driving(law="follow_plan", stop_deceleration_mps2=0.78, stop_gain_per_s=0.6),
    # table 1: odometry and marker, about 0.1 m; 1 % of the distance run, as wheels that count too little count it
    UnitParameters(tag_accuracy_m=0.1, wheel_error_share=CUMULATIVE_ERROR / (1.0 - CUMULATIVE_ERROR)),
    "bound to the paper's figures",
)
LINE: Final = ParameterSet(
    "line",
    Driving(),
    UnitParameters(),
    "the defaults of every line run",
)
TENTH_SCALE: Final = ParameterSet(
    "tenth scale",
    Driving(stop_deceleration_mps2=0.25, stop_gain_per_s=1.0, cruise_gain_per_s=1.0),
    UnitParameters(tag_accuracy_m=0.05, wheel_error_share=CUMULATIVE_ERROR / (1.0 - CUMULATIVE_ERROR)),
    "speed and length are a tenth, time is not",
)
TABLE_1: Final = ParameterSet(
    "table 1",
    Driving(stop_deceleration_mps2=0.8),
    UnitParameters(),
    "the least pattern that leaves 3 s of the paper's shortest running time",
)
SETS: Final = (SECTION_3_2, LINE, TENTH_SCALE, TABLE_1)


def coasting(driving: Driving) -> Driving:
    """The same driving for a bench whose train coasts, by plan, until the stop at the mark takes over."""
    return driving.model_copy(update={"law": "follow_plan"})
