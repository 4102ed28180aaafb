"""What reads each sensor on board, in the compiled tick. A new one is a file of its own and one entry in READERS.

A reader is a compiled function of its own row, what its sensor shows, the unit, what units know of their ways and the
length of the step: it gives its fix to `onboard.localisation.fix.fix_by_rule` and returns what came of it. The
sensor fills `sensed.readings.<name>`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol, cast

from onboard.localisation.beacons import BeaconReading, BeaconsRow, beacons
from onboard.localisation.curvature import curvature
from onboard.localisation.curvature_row import CurvatureReading, CurvatureRow
from onboard.localisation.fix import NOTHING, TAKEN, virtual_tag_bits
from onboard.localisation.gnss import GnssReading, GnssRow, gnss
from onboard.localisation.lidar import LidarReading, LidarRow, lidar
from onboard.localisation.sighting import SignReading, SignRow, sign
from onboard.records import EVENT_FIX, Chart, UnitRow
from vehicle.compiled import compiled, compiled_lines
from vehicle.record import dtype_of


@dataclass(frozen=True, slots=True)
class Reader:
    """One reader: its compiled function, the class of what its sensor shows, and that of its own row.

    `absolute`: its fixes rest on what lies beside or above the track, and on the tachometer for no more than the
    stretch that it compares. Only these prove what lies behind (decision 037).
    """

    function: Callable[..., int]
    reading: type
    row: type
    absolute: bool = False

    @property
    def name(self) -> str:
        """Name of its rows."""
        return self.function.__name__


READERS: Final = (
    Reader(sign, SignReading, SignRow),
    Reader(gnss, GnssReading, GnssRow, absolute=True),
    Reader(beacons, BeaconReading, BeaconsRow, absolute=True),
    Reader(curvature, CurvatureReading, CurvatureRow, absolute=True),
    Reader(lidar, LidarReading, LidarRow, absolute=True),
)
READER_NAMES: Final = tuple(reader.name for reader in READERS)


class ReadingsRow(Protocol):
    """What the sensors of the table show, each under the name of its reader."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...  # noqa: ANN401 - a reading


class ReadersRow(Protocol):
    """What came of the readings, in the order of the table, and a row for each reader under its name."""

    outcome: Annotated[list[int], len(READERS), "the last that was not nothing"]
    moved_m: Annotated[list[float], len(READERS), "by which the last fix taken moved the position"]
    taken: Annotated[list[int], len(READERS), "how many fixes were taken"]

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...  # noqa: ANN401 - a reader's own row


ReadingsRow.__annotations__.update({reader.name: reader.reading for reader in READERS})
ReadersRow.__annotations__.update({reader.name: reader.row for reader in READERS})
READINGS: Final = dtype_of(ReadingsRow)
READERS_ROW: Final = dtype_of(ReadersRow)

ReadAll = Callable[[ReadersRow, ReadingsRow, UnitRow, Chart, float], int]


@compiled
def note_reading(readers: ReadersRow, number: int, outcome: int, moved_m: float) -> int:
    """Keep what came of a reading; an event where it is another than before."""
    if outcome == NOTHING:
        return 0
    readers.taken[number] += 1 if outcome == TAKEN else 0
    before = readers.outcome[number]
    readers.outcome[number], readers.moved_m[number] = outcome, moved_m
    return 0 if outcome == before else EVENT_FIX


def _read_all() -> ReadAll:
    lines = ["def read_all(readers, readings, unit, chart, step_s):", "    events = 0"]
    for number, (name, reader) in enumerate(zip(READER_NAMES, READERS, strict=True)):
        lines += [
            "    before_m, unit.fix_came = unit.position_m, 0",
            f"    outcome = {name}(readers.{name}, readings.{name}, unit, chart, step_s)",
            f"    events |= noted(readers, {number}, outcome, unit.position_m - before_m)",
        ]
        if reader.absolute:
            lines += [f"    events |= told(unit, {number})"]
    lines += ["    return events"]
    names = {reader.name: reader.function for reader in READERS}
    return cast(
        "ReadAll", compiled_lines(lines, {**names, "noted": note_reading, "told": virtual_tag_bits}, __name__)
    )


read_all: Final = _read_all()
