"""The timetable that was written into a feed, read back as it was: the same trains, sets, tracks and ends.

That goes as long as the feed still has our columns and its trips still make a timetable; else it is read as any other.
"""

from __future__ import annotations

import msgspec

from exchange.gtfs.reader import OwnFeed, WrittenTrain
from exchange.timetable_writer import call_table
from network.errors import InputError
from network.files.line_schema import DirectionName
from network.files.timetable_schema import DiagramTable, HeadTable, TimetableFile
from network.files.toml_input import validate
from network.model import Line
from network.timetable import timetable_of


class HeadWritten(msgspec.Struct):
    """Head and diagrams of a timetable file as a feed carries them."""

    id: str
    line: str
    name: str = ""
    dwell_min_s: float = 0.0
    sources: list[str] = []
    assumed: list[str] = []
    diagrams: list[tuple[str, list[str]]] = []
    turn_min_s: float = 0.0


def head_written(file: TimetableFile) -> str:
    """The text that a feed carries."""
    head = file.timetable
    diagrams = [(item.stock, list(item.trains)) for item in file.diagrams]
    written = HeadWritten(
        head.id,
        head.line,
        head.name,
        head.dwell_min_s,
        list(head.sources),
        list(head.assumed),
        diagrams,
        head.turn_min_s,
    )
    return msgspec.json.encode(written).decode()


def read_back(written: OwnFeed, line: Line, file: str) -> tuple[TimetableFile | None, str]:
    """The timetable file, or None and why the feed is read as any other."""
    try:
        head = msgspec.json.decode(written.head, type=HeadWritten)
    except (msgspec.MsgspecError, RecursionError) as error:
        return None, f"its branchline_timetable is damaged ({error})"
    if head.line != line.id:
        return None, f"it was written of {head.line}, not {line.id}"
    try:
        table = {
            "timetable": {
                name: getattr(head, name) for name in HeadTable.model_fields if hasattr(head, name)
            },
            "trains": [_train(train, line) for train in written.trains],
            "diagrams": [
                DiagramTable(stock=stock, trains=numbers).model_dump() for stock, numbers in head.diagrams
            ],
        }
        entry = validate(table, file, TimetableFile)
        timetable_of(entry, file, line)
    except (InputError, ValueError) as error:
        return None, f"it was changed since it was written: {error}"
    return entry, ""


def _train(written: WrittenTrain, line: Line) -> dict[str, object]:
    """A table of `[[trains]]`; a station that the line has not is found by the checks of timetable files."""
    train = written.train
    ends_m = [line.stations[c.station_id].position_m for c in train.calls if c.station_id in line.stations]
    direction: DirectionName = "down" if train.direction == "down" else "up"
    if len(ends_m) > 1:
        direction = "down" if ends_m[-1] > ends_m[0] else "up"
    return {
        "number": train.number,
        "direction": direction,
        "revenue": train.revenue,
        "begins": written.begins,
        "ends": written.ends,
        "calls": [call_table(call).model_dump(by_alias=True) for call in train.calls],
    }
