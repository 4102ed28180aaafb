"""The text of a timetable file: `network.timetable` reads the same tables back, in the order people write them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from exchange.planned import TrainOnLine, Workings
from network.files.line_schema import DIRECTIONS, DirectionName
from network.files.timetable_schema import CallTable, DiagramTable, HeadTable, TimetableFile, TrainTable
from network.files.toml_input import validate
from network.files.toml_text import text_toml
from network.model import Direction
from network.timetable import Call, CallKind, Timetable, begins_text, ends_text, time_text

_NAMES: dict[Direction, DirectionName] = {DIRECTIONS[name]: name for name in ("down", "up")}


def timetable_toml(file: TimetableFile) -> str:
    """The whole file as TOML."""
    rows = head_toml(file.timetable)
    for train in file.trains:
        rows += ["", *_train(train)]
    for diagram in file.diagrams:
        names = ", ".join(text_toml(number) for number in diagram.trains)
        rows += ["", "[[diagrams]]", f"stock = {text_toml(diagram.stock)}", f"trains = [{names}]"]
    return "\n".join(rows) + "\n"


def head_toml(head: HeadTable) -> list[str]:
    """Lines of `[timetable]`."""
    rows = ["[timetable]", f"id = {text_toml(head.id)}"]
    if head.name:
        rows.append(f"name = {text_toml(head.name)}")
    rows += [f"line = {text_toml(head.line)}", f"dwell_min_s = {_number(head.dwell_min_s)}"]
    if head.turn_min_s:
        rows.append(f"turn_min_s = {_number(head.turn_min_s)}")
    return [*rows, *_list("sources", head.sources), *_list("assumed", head.assumed)]


def file_of_trains(
    head: HeadTable, trains: Iterable[TrainOnLine], workings: Workings, assumed: Iterable[str]
) -> TimetableFile:
    """The tables of a day's trains and of the sets that run them; what was assumed for these comes last.

    Raises InputError, which names the timetable's id, for more trains than a file may have.
    """
    tables: list[TrainTable] = []
    for train in trains:
        number, tracks = train.number, workings.tracks
        calls = [
            call_table(replace(call, track=tracks.get((number, i), call.track)))
            for i, call in enumerate(train.calls)
        ]
        ways = workings.begins[number], workings.ends[number]
        tables.append(train_table(number, train.direction, calls, *ways, revenue=train.revenue))
    diagrams = [DiagramTable(stock=item.stock_id, trains=list(item.numbers)) for item in workings.diagrams]
    whole = head.model_copy(update={"assumed": [*assumed, *workings.assumed]})
    return validate({"timetable": whole, "trains": tables, "diagrams": diagrams}, head.id, TimetableFile)


def file_of_timetable(timetable: Timetable) -> TimetableFile:
    """The tables that a timetable was read from, or might have been."""
    trains: list[TrainTable] = []
    for train in timetable.trains.values():
        calls = [call_table(call) for call in train.calls]
        ways = begins_text(train.begins), ends_text(train.ends)
        trains.append(train_table(train.number, train.direction, calls, *ways, revenue=train.revenue))
    diagrams = [
        DiagramTable(stock=item.stock_id, trains=list(item.train_numbers)) for item in timetable.diagrams
    ]
    return TimetableFile(timetable=timetable.head, trains=trains, diagrams=diagrams)


def train_table(
    number: str, direction: Direction, calls: list[CallTable], begins: str, ends: str, *, revenue: bool
) -> TrainTable:
    """A table of `[[trains]]`."""
    named = _NAMES[direction]
    return TrainTable(number=number, direction=named, revenue=revenue, begins=begins, ends=ends, calls=calls)


def call_table(call: Call) -> CallTable:
    """A table of `trains.calls`."""
    times = {
        "arrival": None if call.arrival_s is None else time_text(call.arrival_s),
        "departure": None if call.departure_s is None else time_text(call.departure_s),
    }
    if call.kind is CallKind.PASS:
        times = {"pass": times["departure"]}
    marks = {"operational": call.kind is CallKind.OPERATIONAL, "inferred": call.inferred}
    return CallTable.model_validate({"station": call.station_id, "track": call.track, **times, **marks})


def _train(train: TrainTable) -> list[str]:
    rows = ["[[trains]]", f"number = {text_toml(train.number)}", f"direction = {text_toml(train.direction)}"]
    if not train.revenue:
        rows.append("revenue = false")
    rows += [f"begins = {text_toml(train.begins)}", f"ends = {text_toml(train.ends)}", "calls = ["]
    return [*rows, *(f"  {{ {', '.join(_call_items(call))} }}," for call in train.calls), "]"]


def _call_items(call: CallTable) -> Iterable[str]:
    yield f"station = {text_toml(call.station)}"
    texts = (
        ("track", call.track),
        ("arrival", call.arrival),
        ("departure", call.departure),
        ("pass", call.passes),
    )
    for key, value in texts:
        if value is not None:
            yield f"{key} = {text_toml(value)}"
    for key, mark in (("operational", call.operational), ("inferred", call.inferred)):
        if mark:
            yield f"{key} = true"


def _list(key: str, texts: Sequence[str]) -> list[str]:
    """Nothing for no text, a line for a short one, else a line for each."""
    if not texts:
        return []
    if len(texts) == 1 and key == "sources":
        return [f"{key} = [{text_toml(texts[0])}]"]
    return [f"{key} = [", *(f"  {text_toml(text)}," for text in texts), "]"]


def _number(value: float) -> str:
    return str(int(value)) if value.is_integer() else repr(value)
