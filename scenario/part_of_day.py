"""A part of a day: the same timetable from a time on, with every set where the plan has it then, and until another.

Nothing stands between stations when a run begins. A set that is under way then begins at the last station before where
the plan has it standing on a track of its own, and so some minutes earlier; one that has come by a portal and has not
stood since comes by it again. Where another set uses that track before its own arrival there, a set begins one station
earlier still, until all can stand where they begin: at the worst the day begins as planned.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, Final

from network.clock import clock
from network.errors import COMMAND_LINE, InputError
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import validate
from network.model import Line, SectionKind
from network.timetable import (
    AtPortal,
    Stabled,
    Timetable,
    TimetableTrain,
    platform_of,
    seconds_of,
    timetable_of,
)
from scenario.scenario import Scenario

FROM: Final = "--from"
UNTIL: Final = "--until"


@dataclass(frozen=True, slots=True)
class Beginning:
    """Where a set can begin: with call `call` of its train number `train`, on `track`; None: by a portal."""

    train: int
    call: int
    since_s: float
    section_id: str | None = None
    track: str | None = None


def part_of_day(scenario: Scenario, begins: str | None, until: str | None) -> Scenario:
    """The scenario of that part of its day; times as HH:MM, None: from its beginning, or to its end.

    Its assumptions say where each set begins. What is charged in a battery, and how late trains are, is as at the
    beginning of a day. InputError for times between which nothing runs, and for faults and acts in what is left out.
    """
    trains = scenario.setup.timetable.trains.values()
    first_s = min(train.calls[0].first_s for train in trains)
    last_s = max(train.calls[-1].last_s for train in trains)
    from_s = first_s if begins is None else seconds_of(COMMAND_LINE, FROM, begins, None)
    until_s = math.inf if until is None else seconds_of(COMMAND_LINE, UNTIL, until, None)
    if from_s >= last_s:
        raise InputError(
            COMMAND_LINE, FROM, begins, f"a time before {clock(last_s)}, when the last train ends"
        )
    if until_s <= max(from_s, first_s):
        raise InputError(COMMAND_LINE, UNTIL, until, f"a time after {clock(max(from_s, first_s))}")
    setup = scenario.setup
    if begins is not None:
        at_signals = () if setup.line_signals is None else setup.line_signals.act
        if setup.script.faults or setup.script.acts or at_signals:
            raise InputError(
                COMMAND_LINE, FROM, begins, "a scenario without faults and acts: they need the whole day"
            )
        scenario = _begun_later(scenario, from_s)
    return replace(scenario, setup=replace(scenario.setup, until_s=until_s))


def _begun_later(scenario: Scenario, from_s: float) -> Scenario:
    setup, inputs = scenario.setup, scenario.inputs
    chosen = beginnings(setup.line, setup.timetable, from_s)
    data, told = _cut(inputs.timetable, setup.timetable, chosen)
    timetable = timetable_of(validate(data, scenario.file, TimetableFile), scenario.file, setup.line)
    stock = {stock_id: name for stock_id, name in inputs.stock.items() if stock_id in chosen}
    left = {stock_id: kind for stock_id, kind in setup.trains.items() if stock_id in chosen}
    laws = {stock_id: law for stock_id, law in setup.laws.items() if stock_id in chosen}
    assumed = [*inputs.assumed, f"Part of the day from {clock(from_s)}: {told}."]
    changed = inputs.model_copy(update={"timetable": data, "stock": stock, "assumed": assumed})
    return replace(
        scenario, setup=replace(setup, timetable=timetable, trains=left, laws=laws), inputs=changed
    )


def beginnings(line: Line, timetable: Timetable, from_s: float) -> dict[str, Beginning]:
    """Where each set begins that has still to run at a time (s), by its id."""
    possible: dict[str, list[Beginning]] = {}
    at: dict[str, int] = {}
    plans: dict[str, list[TimetableTrain]] = {}
    for diagram in timetable.diagrams:
        trains = [timetable.trains[number] for number in diagram.train_numbers]
        if trains and trains[-1].calls[-1].first_s > from_s:
            plans[diagram.stock_id] = trains
            possible[diagram.stock_id] = ways = list(_possible(line, trains))
            at[diagram.stock_id] = _last_by(ways, trains, from_s)
    while (early := _in_the_way(line, plans, possible, at)) is not None:
        at[early] -= 1
    return {stock_id: possible[stock_id][index] for stock_id, index in at.items()}


def _possible(line: Line, trains: Sequence[TimetableTrain]) -> Iterator[Beginning]:
    stands_in: str | None = None
    for index, train in enumerate(trains):
        for at, call in enumerate(train.calls):
            portal = at == 0 and isinstance(train.begins, AtPortal)
            if portal:
                yield Beginning(index, 0, float(call.first_s))
            if not call.stops or at == len(train.calls) - 1 or portal:
                continue
            turned = at == 0 and stands_in is not None
            section_id = stands_in if turned else platform_of(line, call, train.direction).section_id
            tracks = [
                track.name
                for track in line.stations[call.station_id].tracks
                if track.section_id == section_id and train.direction in track.marks_m
            ]
            if section_id is None or line.sections[section_id].kind is not SectionKind.TRACK or not tracks:
                continue
            since_s = float(call.first_s)
            if at == 0:
                since_s = -math.inf if index == 0 else float(trains[index - 1].calls[-1].first_s)
            yield Beginning(index, at, since_s, section_id, tracks[0])
        ends = train.calls[-1]
        away = isinstance(train.ends, AtPortal)
        stands_in = None if away else platform_of(line, ends, train.direction).section_id


def _last_by(ways: Sequence[Beginning], trains: Sequence[TimetableTrain], from_s: float) -> int:
    """The last beginning by a time; the next one where its train has left the line by then."""
    by = [index for index, way in enumerate(ways) if way.since_s <= from_s]
    at = by[-1] if by else 0
    ended = trains[ways[at].train].calls[-1].last_s <= from_s
    return at + 1 if ended and at + 1 < len(ways) else at


def _in_the_way(
    line: Line,
    plans: Mapping[str, Sequence[TimetableTrain]],
    possible: Mapping[str, Sequence[Beginning]],
    at: Mapping[str, int],
) -> str | None:
    """A set that would stand where another one has been before it came; None where all can begin."""
    used: list[tuple[str, str, float]] = []
    for stock_id, trains in plans.items():
        way = possible[stock_id][at[stock_id]]
        if way.section_id is not None:
            used.append((way.section_id, stock_id, way.since_s))
        for index, train in enumerate(trains[way.train :]):
            for call in train.calls[way.call + 1 if index == 0 and way.section_id else 0 :]:
                section_id = platform_of(line, call, train.direction).section_id
                used.append((section_id, stock_id, float(call.first_s)))
    for stock_id, index in at.items():
        way = possible[stock_id][index]
        if any(way.section_id == s and other != stock_id and t < way.since_s for s, other, t in used):
            return stock_id
    return None


def _cut(
    tables: Mapping[str, Any], timetable: Timetable, chosen: Mapping[str, Beginning]
) -> tuple[dict[str, Any], str]:
    """The tables of the timetable from there on, and where each set begins, in words."""
    data: dict[str, Any] = deepcopy(dict(tables))
    rows: dict[str, dict[str, Any]] = {row["number"]: row for row in data["trains"]}
    told: list[str] = []
    diagrams: list[dict[str, Any]] = []
    for diagram in data["diagrams"]:
        way = chosen.get(diagram["stock"])
        for number in diagram["trains"][: None if way is None else way.train]:
            del rows[number]
        if way is None:
            continue
        diagrams.append(diagram | {"trains": diagram["trains"][way.train :]})
        first = diagram["trains"][way.train]
        call = timetable.trains[first].calls[way.call]
        where = "by its portal" if way.track is None else f"on track {way.track}"
        told.append(f"{diagram['stock']} as {first} at {call.station_id} {where}, {clock(call.last_s)}")
        if way.track is not None and not (
            way.call == 0 and isinstance(timetable.trains[first].begins, Stabled)
        ):
            calls = [dict(each) for each in rows[first]["calls"][way.call :]]
            calls[0]["track"] = way.track
            calls[0].pop("arrival", None)
            rows[first] |= {"calls": calls, "begins": "stabled"}
    data["trains"] = list(rows.values())
    data["diagrams"] = diagrams
    return data, "; ".join(told)
