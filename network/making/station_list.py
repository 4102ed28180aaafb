"""The list of stations that a line is made from: TOML tables or a CSV with the same names as columns.

A row needs a name, in either script, and what its place needs: a kilometrage, unless geometry gives it. What is left
out is filled in by rules that the line file then states.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from network.errors import InputError
from network.files.kinds import TEXTS_MAX, about
from network.files.names import IDENTIFIER_HELP, Identifier, Prose, Title, is_identifier
from network.files.quantities import Kilometrage, Offset, SpeedKmh, TrainLength
from network.files.text_input import read_text
from network.files.toml_input import Record, one_of, parse_table, validate
from network.making.crossing_list import Crossings, ListedCrossings
from network.making.station_names import is_japanese

STATIONS_MIN: Final = 2
STATIONS_MAX: Final = 400  # ids of tags are 100 times a station's number, in 16 bits
TRACKS_MAX: Final = 6  # assumed: with more, the ways between two fans are too many to be written down
ID_LENGTH_MAX: Final = 24  # two of them and what stands between make an id
_TAKEN: Final = ("P", "W", "E")  # names of sections beside a station's tracks
_OTHER_MARKS: Final = ";\t|"  # what spreadsheets put between columns where it is no comma
ONE_WAY: Final = (
    "a line has no branches: one is a line of its own, from a list that begins where it leaves this one"
)
_NUMBERS: Final = ("km", "tracks", "offset_m", "spacing_m")


class StationRow(Record):
    """`[[stations]]` of a station list, or a row of the CSV."""

    name: Annotated[Title, about("what people call it, in either script")] = ""
    name_ja: Annotated[Title, about("the same in Japanese")] = ""
    id: Annotated[Identifier | None, about("name of the station; left out: made from the name")] = None
    km: Annotated[Kilometrage | None, about("kilometrage; may be left out where geometry gives it")] = None
    tracks: Annotated[int, Field(ge=1, le=TRACKS_MAX), about("how many tracks")] = 1
    track_names: Annotated[
        str, about("their names, with spaces between, from left to right; left out: 1 2 3")
    ] = ""
    kind: Annotated[
        Literal["station", "halt", "signal station"] | None,
        about("left out: a halt where one track lies between the ends of the line, else a station"),
    ] = None
    points: Annotated[
        Literal["both", "low", "high"] | None,
        about("at which ends its tracks come together; left out: wherever the line goes on"),
    ] = None
    normal: Annotated[
        str,
        about(
            "track that normal points lead to from both sides; left out: the left one, as trains keep left"
        ),
    ] = ""
    side: Annotated[
        Literal["right", "left"] | None,
        about("to which side of the first track the others lie, going down; left out: right"),
    ] = None
    spacing_m: Annotated[
        Offset | None, about("distance from track to track; left out: 8, an island platform")
    ] = None
    offset_m: Annotated[
        Offset | None,
        about("offset of the first track, to the right going down; left out: the tracks lie about the axis"),
    ] = None
    end: Annotated[
        Literal["stub", "portal"] | None,
        about("at an end of the line: nothing beyond, or a portal; left out: stub"),
    ] = None


class LineHead(Record):
    """`[line]` of a station list; options of the command count before it."""

    id: Annotated[Identifier | None, about("name of the line; left out: that of the file")] = None
    name: Annotated[Title, about("display name")] = ""
    name_ja: Annotated[Title, about("the same in Japanese")] = ""
    max_speed_kmh: Annotated[SpeedKmh | None, about("maximum speed of the line; left out: 85, assumed")] = (
        None
    )
    train_length_m: Annotated[
        TrainLength | None, about("longest train, for platforms, marks and tags; left out: 40, assumed")
    ] = None
    sources: Annotated[
        list[Prose], Field(max_length=TEXTS_MAX), about("where the list's figures come from")
    ] = Field(default_factory=list)
    assumed: Annotated[list[Prose], Field(max_length=TEXTS_MAX), about("what has no published source")] = (
        Field(default_factory=list)
    )


class StationListFile(Record):
    """A station list as TOML."""

    line: Annotated[LineHead, about("the line; options of the command count before it")] = Field(
        default_factory=LineHead
    )
    stations: Annotated[
        list[StationRow],
        Field(min_length=STATIONS_MIN, max_length=STATIONS_MAX),
        about("in order of kilometrage"),
    ]
    crossings: Crossings = Field(default_factory=list)


@dataclass(frozen=True, slots=True)
class ListedStation:
    """A station of the list with everything but its place decided. `tracks` are names from left to right going down.

    `points_low`, `points_high`: its tracks come together at that end. `normal` is empty where points lie normal for
    left-hand running. `portal`: at an end of the line, trains come from beyond.
    """

    key: str
    id: str
    name: str
    name_ja: str
    km: float | None
    tracks: tuple[str, ...]
    offsets_m: tuple[float, ...]
    is_halt: bool
    has_platforms: bool
    points_low: bool
    points_high: bool
    normal: str
    portal: bool


@dataclass(frozen=True, slots=True)
class StationList:
    """A read list; `file` names it in errors."""

    file: str
    head: LineHead
    stations: tuple[ListedStation, ...]
    crossings: ListedCrossings


def read_station_list(path: Path) -> StationList:
    """Read a list, CSV or TOML by its ending. Raises InputError for the first thing that is wrong with it."""
    file = str(path)
    text = read_text(path)
    if path.suffix.lower() == ".csv":
        table: Mapping[str, Any] = {"stations": _csv_rows(text, file)}
    else:
        table = parse_table(text, file)
    entry = validate(table, file, StationListFile)
    crossings = ListedCrossings(file, tuple(entry.crossings))
    return StationList(file, entry.line, tuple(listed_stations(file, entry.stations)), crossings)


def csv_tables(text: str, file: str, columns: Sequence[str], needed: Sequence[str]) -> list[dict[str, str]]:
    """Rows of a CSV by its column names; cells that are empty are left out. Raises InputError."""
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        names = [name.strip() for name in next(rows, ())]
        if len(names) == 1 and any(mark in names[0] for mark in _OTHER_MARKS):
            raise InputError(file, "line 1", names[0], "commas between columns")
        for name in names:
            if name not in columns:
                raise InputError(file, "line 1", name, f"columns, each {one_of(columns, name)}")
        if len(set(names)) < len(names):
            raise InputError(file, "line 1", ", ".join(names), "each column once")
        for name in needed:
            if name not in names:
                raise InputError(file, "line 1", None, f"a column {name}")
        tables: list[dict[str, str]] = []
        for cells in rows:
            if not any(cell.strip() for cell in cells):
                continue
            if len(cells) != len(names):
                raise InputError(file, f"line {rows.line_num}", len(cells), _cells_expected(len(names)))
            tables.append(
                {name: cell.strip() for name, cell in zip(names, cells, strict=True) if cell.strip()}
            )
    except csv.Error as error:
        raise InputError(file, f"line {rows.line_num}", None, f"valid CSV: {error}") from error
    return tables


def _cells_expected(count: int) -> str:
    """A row is as long as the first one: in a shorter one nobody knows which cell is missing."""
    return f"{count} cell{'s' if count > 1 else ''}, one for each column, empty ones too, with commas between"


def number_of(file: str, key: str, text: str) -> float:
    """A number in a cell. Raises InputError."""
    try:
        return float(text)
    except ValueError as error:
        raise InputError(file, key, text, "a number") from error


def _csv_rows(text: str, file: str) -> list[dict[str, Any]]:
    tables = csv_tables(text, file, tuple(StationRow.model_fields), ())
    rows: list[dict[str, Any]] = []
    for i, table in enumerate(tables):
        row: dict[str, Any] = dict(table)
        for name in _NUMBERS:
            if name in row:
                value = number_of(file, f"stations[{i}].{name}", row[name])
                row[name] = int(value) if name == "tracks" and value.is_integer() else value
        rows.append(row)
    return rows


def listed_stations(file: str, rows: Sequence[StationRow]) -> Iterator[ListedStation]:
    """The stations that rows describe; `file` names them in errors. Raises InputError."""
    _check_names(file, rows)
    ids = _ids(file, rows)
    last_km: tuple[float, str] | None = None
    for i, row in enumerate(rows):
        key = f"stations[{i}]"
        if row.km is not None:
            if last_km is not None and row.km <= last_km[0]:
                beyond = f"more than {last_km[0]:g}, where {last_km[1]} is"
                expected = f"{beyond}: stations in order of kilometrage; {ONE_WAY}"
                raise InputError(file, f"{key}.km", row.km, expected)
            last_km = (row.km, row.name or row.name_ja)
        yield _station(file, key, row, ids[i], first=i == 0, last=i == len(rows) - 1)


def _check_names(file: str, rows: Sequence[StationRow]) -> None:
    seen: dict[str, int] = {}
    for i, row in enumerate(rows):
        name = row.name or row.name_ja
        if not name.strip():
            raise InputError(file, f"stations[{i}].name", None, "a name, here or in name_ja")
        if name in seen:
            raise InputError(
                file,
                f"stations[{i}].name",
                name,
                f"a name of its own; stations[{seen[name]}] has this one; {ONE_WAY}",
            )
        seen[name] = i


def _station(file: str, key: str, row: StationRow, name: str, *, first: bool, last: bool) -> ListedStation:
    at_end = first or last
    if row.end is not None and not at_end:
        raise InputError(file, f"{key}.end", row.end, "nothing: the line goes on at both sides")
    kind = row.kind or ("halt" if row.tracks == 1 and not at_end else "station")
    if kind == "halt":
        if at_end:
            raise InputError(
                file, f"{key}.kind", "halt", "station: an end of the line has a track of its own"
            )
        if row.tracks != 1:
            raise InputError(file, f"{key}.tracks", row.tracks, "1: a halt has no track of its own")
    tracks = _tracks(file, key, row)
    low, high = _points_ends(file, key, row, first=first, last=last)
    if row.normal and row.normal not in tracks:
        raise InputError(file, f"{key}.normal", row.normal, one_of(tracks, row.normal))
    return ListedStation(
        key,
        name,
        row.name or row.name_ja,
        row.name_ja or (row.name if is_japanese(row.name) else ""),
        row.km,
        tracks,
        _offsets_m(row, tracks),
        kind == "halt",
        has_platforms=kind != "signal station",
        points_low=low,
        points_high=high,
        normal=row.normal or ("" if (low and high) or at_end else tracks[0]),
        portal=row.end == "portal",
    )


def _tracks(file: str, key: str, row: StationRow) -> tuple[str, ...]:
    """Names of the tracks from left to right."""
    names = row.track_names.split() or [str(number) for number in range(1, row.tracks + 1)]
    if len(names) != row.tracks:
        raise InputError(
            file, f"{key}.track_names", row.track_names, f"{row.tracks} names, as many as tracks"
        )
    for name in names:
        if not is_identifier(name) or name in _TAKEN:
            expected = f"{IDENTIFIER_HELP}; and none of {', '.join(_TAKEN)}"
            raise InputError(file, f"{key}.track_names", name, expected)
    if len(set(names)) < len(names):
        raise InputError(file, f"{key}.track_names", row.track_names, "each track's name once")
    return tuple(reversed(names)) if row.side == "left" else tuple(names)


def _offsets_m(row: StationRow, tracks: Sequence[str]) -> tuple[float, ...]:
    """Lateral places of the tracks from left to right."""
    spacing_m = 8.0 if row.spacing_m is None else abs(row.spacing_m)
    if row.offset_m is not None:
        first_m = row.offset_m - (spacing_m * (len(tracks) - 1) if row.side == "left" else 0.0)
    elif row.normal in tracks:
        first_m = -spacing_m * tracks.index(row.normal)
    else:
        first_m = -spacing_m * (len(tracks) - 1) / 2.0
    return tuple(round(first_m + spacing_m * i, 3) + 0.0 for i in range(len(tracks)))


def _points_ends(file: str, key: str, row: StationRow, *, first: bool, last: bool) -> tuple[bool, bool]:
    """Whether the tracks come together at the low and at the high end."""
    if row.tracks == 1:
        if row.points is not None:
            raise InputError(file, f"{key}.points", row.points, "nothing: one track has no points")
        return False, False
    beyond = row.end == "portal"
    goes_on = (not first or beyond, not last or beyond)
    wanted = {None: goes_on, "both": (True, True), "low": (True, False), "high": (False, True)}[row.points]
    for has, on, end in zip(wanted, goes_on, ("low", "high"), strict=True):
        if has and not on:
            raise InputError(
                file, f"{key}.points", row.points, f"no points at the {end} end, where the line ends"
            )
    if not any(wanted):
        raise InputError(file, f"{key}.points", row.points, "points where the line goes on")
    return wanted


def _ids(file: str, rows: Sequence[StationRow]) -> list[str]:
    """Ids as given, else three letters of the name; each its own."""
    taken: dict[str, int] = {}
    for i, row in enumerate(rows):
        if row.id is None:
            continue
        if len(row.id) > ID_LENGTH_MAX:
            raise InputError(file, f"stations[{i}].id", row.id, f"at most {ID_LENGTH_MAX} characters")
        if row.id in taken:
            expected = f"an id of its own; stations[{taken[row.id]}] has this one"
            raise InputError(file, f"stations[{i}].id", row.id, expected)
        taken[row.id] = i
    ids: list[str] = []
    for i, row in enumerate(rows):
        name = row.id
        if name is None:
            name = next(word for word in _candidates(row.name, i) if word not in taken)
            taken[name] = i
        ids.append(name)
    return ids


def _candidates(name: str, index: int) -> Iterator[str]:
    """Ids that a name suggests, the plainest first: HSK of Hoshakuji, KKM of Kazusa-Kameyama."""
    words = [
        w
        for w in (
            "".join(c for c in part if c.isascii() and c.isalpha()) for part in name.replace("-", " ").split()
        )
        if w
    ]
    letters = "".join(words).upper()
    if len(letters) >= 2:
        head = "".join(word[0] for word in words[:-1]).upper()[:2]
        last = words[-1].upper()
        hard = last[0] + "".join(c for c in last[1:] if c not in "AEIOU")
        plain = (head + hard)[:3] if len(head + hard) >= 3 else letters[:3]
        yield plain
        yield from (plain[:2] + letter for letter in letters[2:])
        yield from (f"{plain}{number}" for number in range(2, 10))
    elif letters:
        yield letters
    yield f"S{index + 1:02d}"
    yield from (f"S{index + 1:02d}.{number}" for number in range(2, STATIONS_MAX + 2))
