"""Which station of a line each station of a foreign timetable is: by id, by name, or as somebody has said by hand.

Never a guess in silence. Names are compared as `network.making.station_names` spells them, Japanese with Japanese and
romanised with romanised; what came of each station is a row to be shown. A name that fits two stations, two stations
that fit one, an order of stations that the kilometrage contradicts, and too few that fit at all are errors.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Final

from exchange.published import PublishedStation
from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of, parse_table, read_text
from network.making.station_names import is_japanese, spellings
from network.model import Line, Station

LEFT_OUT: Final = "-"  # in place of an id: a station that is to be joined with none
_NEAR_SHOWN: Final = 2
_UNJOINED_SHOWN: Final = 5


class JoinedBy(Enum):
    """What a station was joined by; the value is said in reports."""

    HAND = "by hand"
    ID = "id"
    JAPANESE = "Japanese name"
    ROMANISED = "romanised name"
    NONE = "not joined"


@dataclass(frozen=True, slots=True)
class JoinRow:
    """A station of the source and the id of the line's station that it is; None where it is none of them.

    `near` are ids of stations with a like name, for a station that was not joined.
    """

    key: str
    name: str
    station_id: str | None
    by: JoinedBy
    near: tuple[str, ...] = ()

    def __str__(self) -> str:
        """For reports: name in the source, id on the line, what joined them."""
        if self.station_id is not None:
            return f"{self.name} = {self.station_id} ({self.by.value})"
        like = f"; like {', '.join(self.near)}" if self.near else ""
        return f"{self.name}: {self.by.value}{like}"


@dataclass(frozen=True, slots=True)
class StationJoin:
    """The stations of a source, in its order, and what they are on the line.

    `missing` are ids of the line's stations that the source has not; `reversed_order`: it lists them against the
    kilometrage, so that its down trains run up the line.
    """

    rows: tuple[JoinRow, ...]
    missing: tuple[str, ...]
    reversed_order: bool

    @property
    def ids(self) -> Mapping[str, str]:
        """Ids on the line by the source's keys, of stations that are joined."""
        return {row.key: row.station_id for row in self.rows if row.station_id is not None}


def join_stations(
    file: str,
    stations: Sequence[PublishedStation],
    line: Line,
    by_hand: Mapping[str, str] | None = None,
    *,
    hand_file: str = COMMAND_LINE,
    in_order: bool = True,
) -> StationJoin:
    """Join stations of a source with those of a line; `file` names the source, `hand_file` where `by_hand` stands.

    `by_hand` has ids (or LEFT_OUT) by the source's keys or names. `in_order`: the source lists its stations along the
    line, so their kilometrage must rise or fall. Raises InputError.
    """
    hands = _hands(stations, line, by_hand or {}, hand_file)
    rows = tuple(_row(file, station, line, hands) for station in stations)
    _check_one_each(file, rows)
    joined = [line.stations[row.station_id] for row in rows if row.station_id is not None]
    _check_enough(file, rows, line, by_hand=bool(hands))
    steps = [after.position_m - before.position_m for before, after in pairwise(joined)]
    backwards = sum(steps) < 0
    if in_order:
        _check_order(file, rows, line, backwards=backwards)
    names = {row.station_id for row in rows}
    missing = tuple(station_id for station_id in line.stations if station_id not in names)
    return StationJoin(rows, missing, backwards)


def names_by_hand(options: Iterable[str], file: Path | None = None) -> dict[str, str]:
    """Ids by names of the source: from a TOML file of `"name" = "id"`, and from options `NAME=ID`, which count more.

    Raises InputError for what is neither.
    """
    found: dict[str, str] = {}
    if file is not None:
        for name, value in parse_table(read_text(file), str(file)).items():
            if not isinstance(value, str):
                raise InputError(str(file), name, value, f"the id of a station, or {LEFT_OUT!r}")
            found[name] = value
    for option in options:
        name, equals, station_id = option.rpartition("=")
        if not (name and equals and station_id):
            raise InputError(
                COMMAND_LINE, "--name", option, f"SOURCE=ID, or SOURCE={LEFT_OUT} to leave it out"
            )
        found[name.strip()] = station_id.strip()
    return found


def _hands(
    stations: Sequence[PublishedStation], line: Line, by_hand: Mapping[str, str], file: str
) -> dict[str, str]:
    """Ids (or LEFT_OUT) by the source's keys."""
    found: dict[str, str] = {}
    for name, station_id in by_hand.items():
        keys = [station.key for station in stations if name in (station.key, station.name, station.name_ja)]
        if not keys:
            known = [station.name or station.key for station in stations]
            raise InputError(file, name, None, f"a station of the source: {one_of(known, name)}")
        if station_id != LEFT_OUT and station_id not in line.stations:
            expected = f"{one_of(line.stations, station_id)}, or {LEFT_OUT!r} to leave it out"
            raise InputError(file, name, station_id, expected)
        for key in keys:
            if found.setdefault(key, station_id) != station_id:
                raise InputError(file, name, station_id, f"{found[key]}, as said of the same station before")
    return found


def _row(file: str, station: PublishedStation, line: Line, hands: Mapping[str, str]) -> JoinRow:
    shown = station.name_ja if station.name_ja and not station.name else station.name or station.key
    if station.key in hands:
        station_id = hands[station.key]
        return JoinRow(station.key, shown, None if station_id == LEFT_OUT else station_id, JoinedBy.HAND)
    fits = _fits(station, line)
    ids = list(dict.fromkeys(station_id for station_id, _ in fits))
    if len(ids) > 1:
        expected = f"a name that fits one station of the line, not {' and '.join(ids)}: say which by hand"
        raise InputError(file, "station", shown, expected)
    if ids:
        return JoinRow(station.key, shown, *fits[0])
    return JoinRow(station.key, shown, None, JoinedBy.NONE, _near(station, line))


def _fits(station: PublishedStation, line: Line) -> list[tuple[str, JoinedBy]]:
    """Stations of the line that this one may be, by id first, then by the most faithful spelling that fits any."""
    found: list[tuple[str, JoinedBy]] = []
    same = line.stations.get(station.key)
    if same is not None and not _contradict(station, same):
        found.append((same.id, JoinedBy.ID))
    for name in dict.fromkeys((station.name_ja, station.name)):
        by = JoinedBy.JAPANESE if is_japanese(name) else JoinedBy.ROMANISED
        found += [(station_id, by) for station_id in _named(name, line)]
    return found


def _named(name: str, line: Line) -> list[str]:
    """Stations of a name: those that share its most faithful spelling, or a less faithful one where none does."""
    for spelling in spellings(name):
        for depth in (1, None):  # on the line too, what stands in brackets counts first
            ids = [
                other.id
                for other in line.stations.values()
                if any(spelling in spellings(text)[:depth] for text in (other.name_ja, other.name))
            ]
            if ids:
                return ids
    return []


def _contradict(station: PublishedStation, other: Station) -> bool:
    """Whether both have a name in the same writing, and none that they share."""
    ours = [text for text in (other.name_ja, other.name) if text]
    theirs = [text for text in (station.name_ja, station.name) if text and text != station.key]
    pairs = [(a, b) for a in ours for b in theirs if is_japanese(a) == is_japanese(b)]
    return bool(pairs) and not any(set(spellings(a)) & set(spellings(b)) for a, b in pairs)


def _near(station: PublishedStation, line: Line) -> tuple[str, ...]:
    """Ids of stations with names that are most like this one's."""
    ids: dict[str, str] = {}
    for other in line.stations.values():
        for text in (other.name, other.name_ja, other.id):
            ids |= dict.fromkeys(spellings(text), other.id)
    wanted = [spelling for name in (station.name_ja, station.name) for spelling in spellings(name)]
    near = [
        like for text in wanted for like in difflib.get_close_matches(text, ids, n=_NEAR_SHOWN, cutoff=0.6)
    ]
    return tuple(dict.fromkeys(ids[like] for like in near))[:_NEAR_SHOWN]


def _check_one_each(file: str, rows: Iterable[JoinRow]) -> None:
    """No two stations of the source are one of the line; a source may list a station twice, as at a junction."""
    owner: dict[str, JoinRow] = {}
    for row in rows:
        if row.station_id is None:
            continue
        first = owner.setdefault(row.station_id, row)
        by_hand = JoinedBy.HAND in (row.by, first.by)
        if first is not row and not by_hand and not set(spellings(first.name)) & set(spellings(row.name)):
            expected = f"a station other than {row.station_id}, which {first.name} is: say which by hand"
            raise InputError(file, "station", row.name, expected)


def _check_enough(file: str, rows: Sequence[JoinRow], line: Line, *, by_hand: bool) -> None:
    """Two stations at least; and where nobody has said so, half of the line's or half of the source's."""
    joined = {row.station_id for row in rows if row.station_id is not None}
    on_line = sum(not station.is_signal_station for station in line.stations.values())
    few = 2 * len(joined) < min(on_line, len(rows)) and not by_hand
    if len(joined) >= 2 and not few:
        return
    lost = [row for row in rows if row.by is JoinedBy.NONE]
    lost.sort(key=lambda row: not row.near)  # stable: those with a like name first
    texts = [
        f"{row.name} (like {', '.join(row.near)})" if row.near else row.name for row in lost[:_UNJOINED_SHOWN]
    ]
    more = f" and {len(lost) - len(texts)} more" if len(lost) > len(texts) else ""
    expected = f"more stations of {line.id}; not joined: {', '.join(texts)}{more}; say which they are by hand"
    raise InputError(file, "stations", f"{len(joined)} of {len(rows)} joined", expected)


def _check_order(file: str, rows: Iterable[JoinRow], line: Line, *, backwards: bool) -> None:
    """The order of the source's list is that of the kilometrage, or its reverse."""
    joined = [(row, line.stations[row.station_id]) for row in rows if row.station_id is not None]
    for (_, before), (row, after) in pairwise(joined):
        step_m = after.position_m - before.position_m
        if (step_m > 0) if backwards else (step_m < 0):
            expected = (
                f"a station on the other side of {before.id} (km {before.position_m / 1000:.3f}), as the order of the"
                f" source has it; {after.id} lies at km {after.position_m / 1000:.3f}: say which by hand"
            )
            raise InputError(file, "station", row.name, expected)
