"""A timetable, and a day as it was run, as an OuDiaSecond file (.oud2).

The keys and their order are those of FileType OuDiaSecond.1.10, which ver. 2.05 and all later ones read; keys that they
leave out at their default are left out here too. Sets are OuDia's operations: where a train begins, its set comes out
(出区), from beyond the line (路線外始発) or was another train (前列車接続), and always bears the number of the set.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from exchange.oudia.carried import CommentTable, RemarkFacts, WrittenTable, comment, remark
from exchange.oudia.cells import (
    DAY_BEGINS_S,
    AfterTrain,
    BeforeTrain,
    CallHandling,
    OudiaCell,
    cell_text,
    operation_text,
    time_text,
)
from exchange.oudia.nodes import OudiaEntry, OudiaNode, OudiaText, entry
from exchange.oudia.route import DOWN, UP
from exchange.timetable_writer import file_of_timetable
from network.files.json_input import write_bytes_aside
from network.model import Direction, Line, Station
from network.timetable import (
    DAY_S,
    AtPortal,
    BecomesTrain,
    Call,
    CallKind,
    FromTrain,
    Timetable,
    TimetableTrain,
    platform_of,
)

FILE_TYPE: Final = "OuDiaSecond.1.10"
AS_RUN: Final = "as run"
_SCALE_MPS: Final = 50 / 3.6  # OuDia spaces stations by a time; assumed: that of 50 km/h
_FONT: Final = "PointTextHeight=9;Facename=Meiryo UI"
_KINDS: Final = (  # name, short name, colour (00BBGGRR), style of its line
    ("普通", "普", "00000000", "SenStyle_Jissen"),
    ("回送", "回", "00808080", "SenStyle_Hasen"),
)
_KINDS_AS_RUN: Final = (
    ("普通（実績）", "普実", "000000C0", "SenStyle_Jissen"),
    ("回送（実績）", "回実", "006060C0", "SenStyle_Hasen"),
)


@dataclass(frozen=True, slots=True)
class _WrittenStation:
    """A station in the file: names of its tracks, and the portals that trains which begin or end here use."""

    station: Station
    name: str
    tracks: tuple[str, ...]
    main: Mapping[Direction, int]  # index of the usual track of each direction
    outer: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Dia:
    name: str
    trains: Sequence[TimetableTrain]
    first_kind: int  # index of its kinds of train in the file


def write_oudia(path: Path, line: Line, timetable: Timetable, as_run: Sequence[TimetableTrain] = ()) -> None:
    """Write a file whole or not at all. Raises InputError where it cannot be written."""
    data = oudia_of(line, timetable, as_run).encoded()
    write_bytes_aside(path, data, data.partition(b"=")[0])


def oudia_of(line: Line, timetable: Timetable, as_run: Sequence[TimetableTrain] = ()) -> OudiaText:
    """The file of a timetable; trains as they were run, in whole seconds, are a second Dia, `AS_RUN`."""
    plan = _Dia(plan_name(timetable), tuple(timetable.trains.values()), 0)
    dias = [plan, _Dia(AS_RUN, as_run, len(_KINDS))] if as_run else [plan]
    places = _places(line, [train for dia in dias for train in dia.trains])
    stock = {number: item.stock_id for item in timetable.diagrams for number in item.train_numbers}
    carried = CommentTable(
        timetable=file_of_timetable(timetable).timetable,
        oudia=WrittenTable(
            dia=plan.name,
            stations=[place.station.id for place in places],
            stock=[item.stock_id for item in timetable.diagrams],
        ),
    )
    title = f"{_route_name(line)}: {plan.name}"
    rosen: list[OudiaEntry | OudiaNode] = [
        entry("Rosenmei", _route_name(line)),
        entry("KudariDiaAlias", ""),
        entry("NoboriDiaAlias", ""),
        *_stations(places),
        *(_kind(*kind) for kind in (*_KINDS, *(_KINDS_AS_RUN if as_run else ()))),
        *(_dia(dia, places, stock) for dia in dias),
        entry("KitenJikoku", time_text(DAY_BEGINS_S)),
        entry("DiagramDgrYZahyouKyoriDefault", 60),
        entry("EnableOperation", 2),
        entry("Comment", comment(title, carried)),
    ]
    root = (
        entry("FileType", FILE_TYPE),
        OudiaNode("Rosen", tuple(rosen)),
        OudiaNode("DispProp", tuple(_display())),
        entry("FileTypeAppComment", "branchline"),
    )
    return OudiaText(OudiaNode("", root), utf8=True)


def plan_name(timetable: Timetable) -> str:
    """Name of the Dia that is the plan; not that of the day as run."""
    name = timetable.head.name or timetable.head.id
    return name if name != AS_RUN else timetable.head.id + " (plan)"


def station_name(station: Station) -> str:
    """What a station is called in the file."""
    return station.name_ja or station.name or station.id


def _route_name(line: Line) -> str:
    return line.name_ja or line.name or line.id


def _places(line: Line, trains: Iterable[TimetableTrain]) -> tuple[_WrittenStation, ...]:
    outer: dict[str, set[str]] = {}
    for train in trains:
        for end, call in ((train.begins, train.calls[0]), (train.ends, train.calls[-1])):
            if isinstance(end, AtPortal):
                outer.setdefault(call.station_id, set()).add(end.section_id)
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    return tuple(
        _WrittenStation(
            station,
            station_name(station),
            tuple(track.name for track in station.tracks),
            {direction: _main(station, line, direction) for direction in Direction},
            tuple(sorted(outer.get(station.id, ()))),
        )
        for station in stations
    )


def _stations(places: Sequence[_WrittenStation]) -> Iterator[OudiaNode]:
    for i, place in enumerate(places):
        form = "Hatsuchaku"
        if i in (0, len(places) - 1):
            form = "NoboriChaku" if i == 0 else "KudariChaku"
        next_m = places[i + 1].station.position_m - place.station.position_m if i + 1 < len(places) else 0.0
        yield OudiaNode("Eki", tuple(_station(place, form, next_m)))


def _station(place: _WrittenStation, form: str, next_m: float) -> Iterator[OudiaEntry | OudiaNode]:
    main = place.station.tracks and not place.station.is_halt
    yield entry("Ekimei", place.name)
    yield entry("Ekijikokukeisiki", f"Jikokukeisiki_{form}")
    yield entry("Ekikibo", "Ekikibo_Syuyou" if main else "Ekikibo_Ippan")
    yield entry("DownMain", place.main[Direction.DOWN])
    yield entry("UpMain", place.main[Direction.UP])
    if len(place.tracks) > 1:
        yield entry("JikokuhyouTrackDisplayKudari", 1)
        yield entry("JikokuhyouTrackDisplayNobori", 1)
        yield entry("DiagramTrackDisplay", 1)
    yield entry("DiagramTrackOmit", ",".join("0" for _ in place.tracks))
    tracks = (
        OudiaNode("EkiTrack2", (entry("TrackName", track), entry("TrackRyakusyou", track)))
        for track in place.tracks
    )
    yield OudiaNode("EkiTrack2Cont", tuple(tracks))
    for name in place.outer:
        yield OudiaNode("OuterTerminal", (entry("OuterTerminalEkimei", name),))
    if next_m > 0:
        yield entry("NextEkiDistance", max(1, round(next_m / _SCALE_MPS)))
    for direction in (DOWN, UP):
        yield entry(f"JikokuhyouJikokuDisplay{direction}", "1,1")
    for direction in (DOWN, UP):
        yield entry(f"JikokuhyouSyubetsuChangeDisplay{direction}", "0,0,0,0,1")
    yield entry("DiagramColorNextEki", 0)
    for direction in (DOWN, UP):
        yield entry(f"JikokuhyouOuterDisplay{direction}", "1,1" if place.outer else "0,0")


def _main(station: Station, line: Line, direction: Direction) -> int:
    try:
        return station.tracks.index(platform_of(line, Call(station.id, None, None, None), direction))
    except KeyError:
        return 0  # trains of the direction have no place to stand


def _kind(name: str, short: str, colour: str, style: str) -> OudiaNode:
    return OudiaNode(
        "Ressyasyubetsu",
        (
            entry("Syubetsumei", name),
            entry("Ryakusyou", short),
            entry("JikokuhyouMojiColor", colour),
            entry("JikokuhyouFontIndex", 0),
            entry("JikokuhyouBackColor", "00FFFFFF"),
            entry("DiagramSenColor", colour),
            entry("DiagramSenStyle", style),
            entry("StopMarkDrawType", "EStopMarkDrawType_DrawOnStop"),
        ),
    )


def _dia(dia: _Dia, places: Sequence[_WrittenStation], stock: Mapping[str, str]) -> OudiaNode:
    both = ((Direction.DOWN, DOWN), (Direction.UP, UP))
    trains = sorted(dia.trains, key=lambda train: (train.calls[0].first_s, train.number))
    return OudiaNode(
        "Dia",
        (
            entry("DiaName", dia.name),
            entry("MainBackColorIndex", 0),
            entry("SubBackColorIndex", 0),
            entry("BackPatternIndex", 0),
            *(
                OudiaNode(
                    name,
                    tuple(
                        _train(train, name, dia, places, stock.get(train.number, ""))
                        for train in trains
                        if train.direction is direction
                    ),
                )
                for direction, name in both
            ),
        ),
    )


def _train(
    train: TimetableTrain, direction: str, dia: _Dia, places: Sequence[_WrittenStation], stock: str
) -> OudiaNode:
    along = places if direction == DOWN else places[::-1]
    index = {place.station.id: i for i, place in enumerate(along)}
    first, last = index[train.calls[0].station_id], index[train.calls[-1].station_id]
    cells = [*("" for _ in range(first)), *_cells(train, along[first : last + 1])]
    main = {place.station.id: place.tracks[place.main[train.direction]] for place in along if place.tracks}
    named = (call.station_id for call in train.calls if call.track == main.get(call.station_id, ""))
    words = RemarkFacts(
        frozenset(call.station_id for call in train.calls if _is_said(train, call)),
        frozenset(named if dia.first_kind == 0 else ()),  # as it was run all tracks are named
        frozenset(call.station_id for call in train.calls if call.inferred),
        _days(train),
    )
    note = remark(words)
    return OudiaNode(
        "Ressya",
        (
            entry("Houkou", direction),
            entry("Syubetsu", dia.first_kind + (0 if train.revenue else 1)),
            entry("Ressyabangou", train.number),
            entry("EkiJikoku", ",".join(cells)),
            entry(f"Operation{first}B", _before(train, along[first], stock)),
            entry(f"Operation{last}A", _after(train, along[last])),
            *([entry("Bikou", note)] if note else []),
        ),
    )


def _cells(train: TimetableTrain, along: Iterable[_WrittenStation]) -> Iterator[str]:
    """Stations from the first to the last; at one without a call it runs through, and nobody says when."""
    calls = {call.station_id: call for call in train.calls}
    for place in along:
        call = calls.get(place.station.id)
        usual = place.main[train.direction]
        if call is None:
            yield cell_text(OudiaCell(CallHandling.PASS, track=usual))
            continue
        track = usual if call.track is None else place.tracks.index(call.track)
        yield cell_text(OudiaCell(_how(train, call), call.arrival_s, call.departure_s, track))


def _how(train: TimetableTrain, call: Call) -> CallHandling:
    """OuDia has no stop without passengers: on the way it is a passing with two times."""
    if call.kind is CallKind.PASS:
        return CallHandling.PASS
    on_the_way = call is not train.calls[0] and call is not train.calls[-1]
    apart = call.arrival_s is not None and call.departure_s is not None and call.arrival_s < call.departure_s
    return (
        CallHandling.PASS if call.kind is CallKind.OPERATIONAL and on_the_way and apart else CallHandling.STOP
    )


def _is_said(train: TimetableTrain, call: Call) -> bool:
    """Whether a call is without passengers and OuDia's own way of writing does not show it."""
    return call.kind is CallKind.OPERATIONAL and _how(train, call) is CallHandling.STOP


def _days(train: TimetableTrain) -> int:
    """Days between when the train begins and when OuDia's time, which has no day, says so."""
    first_s = train.calls[0].first_s
    shown_s = first_s % DAY_S
    shown_s += DAY_S if shown_s < DAY_BEGINS_S else 0
    return (first_s - shown_s) // DAY_S


def _before(train: TimetableTrain, place: _WrittenStation, stock: str) -> str:
    call = train.calls[0]
    time = time_text(call.first_s)
    match train.begins:
        case AtPortal(section_id):
            outer = str(place.outer.index(section_id))
            return operation_text(BeforeTrain.OUTER.value, outer, time, time_text(call.arrival_s), "", stock)
        case FromTrain():
            return operation_text(BeforeTrain.JUNCTION.value, "", stock)
        case _:
            return operation_text(BeforeTrain.OUT.value, time, "", stock)


def _after(train: TimetableTrain, place: _WrittenStation) -> str:
    call = train.calls[-1]
    time = time_text(call.last_s)
    match train.ends:
        case AtPortal(section_id):
            outer = str(place.outer.index(section_id))
            return operation_text(AfterTrain.OUTER.value, outer, time_text(call.departure_s), time, "")
        case BecomesTrain():
            return operation_text(AfterTrain.JUNCTION.value, "", "0")
        case _:
            return operation_text(AfterTrain.IN.value, time, "")


def _display() -> Iterator[OudiaEntry]:
    """How OuDiaSecond shows a file: its own defaults."""
    styles = ("", ";Bold=1", ";Itaric=1", ";Bold=1;Itaric=1", "", "", "", "")
    yield from (entry("JikokuhyouFont", _FONT + style) for style in styles)
    yield entry("JikokuhyouVFont", "PointTextHeight=9;Facename=@メイリオ")
    for key in ("DiaEkimeiFont", "DiaJikokuFont", "DiaRessyaFont", "OperationTableFont"):
        yield entry(key, _FONT)
    yield entry("AllOperationTableJikokuFont", "PointTextHeight=8;Facename=Meiryo UI")
    yield entry("CommentFont", _FONT)
    colours = (
        ("DiaMojiColor", "00000000"),
        *(("DiaBackColor", "00FFFFFF"),) * 5,
        ("DiaRessyaColor", "00000000"),
        ("DiaJikuColor", "00C0C0C0"),
        ("JikokuhyouBackColor", "00FFFFFF"),
        ("JikokuhyouBackColor", "00F0F0F0"),
        ("JikokuhyouBackColor", "00FFFFFF"),
        ("JikokuhyouBackColor", "00FFFFFF"),
        ("StdOpeTimeLowerColor", "00E0E0FF"),
        ("StdOpeTimeHigherColor", "00FFFFE0"),
        ("StdOpeTimeUndefColor", "0080FFFF"),
        ("StdOpeTimeIllegalColor", "00A0A0A0"),
        ("OperationStringColor", "00000000"),
        ("OperationGridColor", "00000000"),
    )
    yield from (entry(key, colour) for key, colour in colours)
    figures = (
        ("EkimeiLength", 6),
        ("JikokuhyouRessyaWidth", 5),
        ("AnySecondIncDec1", 5),
        ("AnySecondIncDec2", 15),
        ("DisplayRessyamei", 1),
        ("DisplayOuterTerminalEkimeiOriginSide", 0),
        ("DisplayOuterTerminalEkimeiTerminalSide", 0),
        ("DiagramDisplayOuterTerminal", 0),
        ("SecondRoundChaku", 0),
        ("SecondRoundHatsu", 0),
        ("Display2400", 0),
        ("OperationNumberRows", 1),
        ("DisplayInOutLinkCode", 0),
    )
    yield from (entry(key, figure) for key, figure in figures)
