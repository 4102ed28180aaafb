"""What a planner adds to a published day: workings that nobody publishes (回送), and the sets there are."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Final

from pydantic import Field

from exchange.planned import TrainOnLine
from network.errors import InputError
from network.files.kinds import TABLES_MAX, TEXTS_MAX, about
from network.files.line_schema import DIRECTIONS, DirectionName
from network.files.names import Identifier, Prose
from network.files.shipped import find_file
from network.files.timetable_schema import CallTable
from network.files.toml_input import Record, one_of, parse_toml, read_text
from network.model import Line
from network.timetable import Call, call_of

_SETS_MAX: Final = 500


class AddedTrain(Record):
    """`[[trains]]`: a train beside the published ones; how its set comes and goes is found like theirs."""

    number: Annotated[Identifier, about("train number")]
    direction: Annotated[DirectionName, about("down or up the kilometrage")]
    revenue: Annotated[bool, about("false: an empty working")] = True
    from_beyond: Annotated[bool, about("it comes in over a portal")] = False
    to_beyond: Annotated[bool, about("it goes out over a portal")] = False
    calls: Annotated[
        list[CallTable], Field(min_length=2, max_length=TEXTS_MAX), about("where it calls, in order")
    ]


class AdditionsFile(Record):
    """A whole file of additions."""

    stock: Annotated[
        list[Identifier],
        Field(max_length=_SETS_MAX),
        about("the sets there are; left out: as few as can run it"),
    ] = Field(default_factory=list)
    assumed: Annotated[
        list[Prose], Field(max_length=TEXTS_MAX), about("why, in sentences for the timetable file")
    ] = Field(default_factory=list)
    trains: Annotated[
        list[AddedTrain], Field(max_length=TABLES_MAX), about("trains beside the published")
    ] = Field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Additions:
    """Trains, sets and sentences to be added to a day; empty unless somebody gives them."""

    trains: tuple[TrainOnLine, ...] = ()
    stock: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()


def shipped_additions(name: str) -> Path:
    """File of shipped additions, or `name` itself when it is an existing .toml file. Raises InputError."""
    return find_file(Path(str(files("network"))) / "additions", "file of additions", name)


def read_additions(path: Path, line: Line) -> Additions:
    """Additions to days of a line. Raises InputError; what needs the whole timetable is checked with it."""
    file = str(path)
    entry = parse_toml(read_text(path), file, AdditionsFile)
    trains = tuple(_train(file, f"trains[{i}]", train, line) for i, train in enumerate(entry.trains))
    return Additions(trains, tuple(entry.stock), tuple(entry.assumed))


def _train(file: str, key: str, entry: AddedTrain, line: Line) -> TrainOnLine:
    calls: list[Call] = []
    for i, item in enumerate(entry.calls):
        where = f"{key}.calls[{i}]"
        if item.station not in line.stations:
            raise InputError(file, f"{where}.station", item.station, one_of(line.stations, item.station))
        calls.append(_call(file, where, item, calls[-1].last_s if calls else None))
    return TrainOnLine(
        entry.number,
        DIRECTIONS[entry.direction],
        tuple(calls),
        entry.revenue,
        from_beyond=entry.from_beyond,
        to_beyond=entry.to_beyond,
    )


def _call(file: str, key: str, entry: CallTable, after_s: int | None) -> Call:
    """A call with at least one time; which times belong together is checked with the whole timetable."""
    call = call_of(file, key, entry, after_s)
    if call.arrival_s is None and call.departure_s is None:
        raise InputError(file, f"{key}.departure", None, "a time: the call has none")
    return call
