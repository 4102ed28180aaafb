"""What a train carries on board for the compiled tick, as one record, and what its sensors show it.

The truth is in neither: a unit knows of the world what stands in its SENSED row.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.table import LawsRow
from onboard.driving.stopping import WaveRow
from onboard.driving.tasc import DesignRow, TascRow
from onboard.localisation.table import ReadersRow, ReadingsRow
from onboard.records import BehaviourRow, UnitRow
from vehicle.record import dtype_of
from vehicle.records import TrainRow


class SensedRow(Protocol):
    """What the sensors show in one step; the simulation fills it."""

    now_s: Annotated[float, "simulated time since midnight"]
    odometer_m: Annotated[float, "what the tachometer has counted"]
    speed_mps: Annotated[float, "what the tachometer shows"]
    wheel_slide: Annotated[int, "from the slide protection: -1 slides, 1 slips, 0 rolls"]
    last_axle_taken: Annotated[int, "1: the slide protection shows its last axle"]
    last_axle_mps: Annotated[float, "that axle's speed, by the circumference that the tachometer is set for"]
    load_share: Annotated[float, "from the load sensor: 0 empty, 1 full"]
    readings: Annotated[ReadingsRow, "of the sensors in the table of readers"]


class BoardRow(Protocol):
    """All that one train's tick reads and writes."""

    unit: Annotated[UnitRow, "what the unit believes and decides"]
    kind: Annotated[TrainRow, "the train as the unit believes it to be"]
    readers: Annotated[ReadersRow, "what it makes of its sensors' readings"]
    behaviour: Annotated[BehaviourRow, "how it drives and supervises"]
    cue: Annotated[CueRow, "what its driving law is told in this tick"]
    laws: Annotated[LawsRow, "which law drives, and what each of them keeps"]
    tasc: Annotated[TascRow, "the present stop at the mark"]
    design: Annotated[DesignRow, "how it stops at marks"]
    wave: Annotated[WaveRow, "how its last stop went"]


SENSED: Final = dtype_of(SensedRow)
BOARD: Final = dtype_of(BoardRow)
