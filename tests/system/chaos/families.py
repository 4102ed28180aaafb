"""The families of cases: the test line, the Karasuyama line's busiest hour, lines that are drawn, those with level
crossings, and all of these but the hour with what `wide` adds.
"""

from enum import Enum
from functools import cache
from typing import Any, Final

from network.clock import clock
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Direction
from network.timetable import AtPortal, BecomesTrain, Timetable, TimetableTrain, load_timetable
from tests.system.chaos.draw import Draw
from tests.system.chaos.ground import Ground, timetable_table
from tests.system.chaos.timetables import TEST_LINE_STOPS, trains_on
from tests.system.chaos.toml_text import toml_of
from tests.system.chaos.wide import SECOND_AIR, SWEPT_S, WIDE, line_that_can_be, wide_ground


class Family(Enum):
    """Where a case happens."""

    TEST_LINE = "test"
    HOUR = "hour"
    LINES = "lines"
    CROSSINGS = "crossings"
    WIDE = "wide"


SHIPPED: Final = ("rtri_two_trains", "rtri_crossing", "rtri_turn_back")
TIMETABLES: Final = 24  # of the test line, those shipped included
LINES: Final = 20
DAYS: Final = 2  # timetables of each drawn line
HOUR_S: Final = 3600.0


def ground_of(family: Family, seed: int) -> Ground:
    """The ground of a case. Cases share grounds, so that each is run undisturbed but once."""
    match family:
        case Family.TEST_LINE:
            return _test_line(seed % TIMETABLES)
        case Family.HOUR:
            return _busiest_hour()
        case Family.LINES:
            return _drawn_line(seed % LINES, seed // LINES % DAYS)
        case Family.CROSSINGS:
            return _drawn_line(seed % LINES, seed // LINES % DAYS, crossed=True)
        case Family.WIDE:
            return wide_ground(seed % WIDE)


@cache
def _test_line(number: int) -> Ground:
    head: dict[str, Any] = {"extends": "rtri_test_line"}
    if number < len(SHIPPED):
        return Ground(SHIPPED[number], head | {"timetable": SHIPPED[number]})
    name = f"test_line_{number}"
    trains = trains_on(TEST_LINE_STOPS, Draw(number, ("test line",)))
    file = f"{name}_times.toml"
    text = toml_of(timetable_table(f"{name}_times", "rtri_test_line", trains))
    return Ground(name, head | {"timetable": file}, {file: text})


@cache
def _drawn_line(number: int, day: int, *, crossed: bool = False) -> Ground:
    name = f"crossed_{number}" if crossed else f"drawn_{number}"
    line = line_that_can_be(name, Draw(number, ("line",)), crossed=crossed)
    times = f"{name}_{day}_times"
    trains = trains_on(line.stops, Draw(number, ("times", str(day))))
    head = {
        "line": f"{name}.toml",
        "timetable": f"{times}.toml",
        "assumed": ["everything: drawn by chance"],
        "trains": {"default": "ev_e301"},
        "limits": {"time_limit_s": SWEPT_S},
        **({"second_air": SECOND_AIR} if line.second_network else {}),
    }
    timetable = toml_of(timetable_table(times, name, trains))
    return Ground(f"{name}_{day}", head, {f"{name}.toml": line.text, f"{times}.toml": timetable})


@cache
def _busiest_hour() -> Ground:
    """The weekday cut to the trains that run wholly within the hour in which trains run most."""
    line = load_line(shipped_line("karasuyama"))
    day = load_timetable(shipped_timetable("karasuyama_weekday"), line)
    begins_s = max((t.calls[0].first_s for t in day.trains.values()), key=lambda s: (_running_s(day, s), -s))
    kept = _within(day, begins_s)
    name = "karasuyama_hour_times"
    table = {
        "timetable": {"id": name, "name": name, "line": "karasuyama", "dwell_min_s": day.head.dwell_min_s},
        "trains": [_train_table(train, kept) for train in kept.values()],
        "diagrams": [
            {"stock": diagram.stock_id, "trains": mine}
            for diagram in day.diagrams
            if (mine := [number for number in diagram.train_numbers if number in kept])
        ],
    }
    limits = {"time_limit_s": SWEPT_S}
    head = {"extends": "karasuyama_weekday", "timetable": f"{name}.toml", "limits": limits}
    return Ground("karasuyama_hour", head, {f"{name}.toml": toml_of(table)})


def _within(day: Timetable, begins_s: float) -> dict[str, TimetableTrain]:
    return {
        number: train
        for number, train in day.trains.items()
        if begins_s <= train.calls[0].first_s and train.calls[-1].last_s <= begins_s + HOUR_S
    }


def _running_s(day: Timetable, begins_s: float) -> float:
    return sum(t.calls[-1].last_s - t.calls[0].first_s for t in _within(day, begins_s).values())


def _train_table(train: TimetableTrain, kept: dict[str, TimetableTrain]) -> dict[str, Any]:
    """A train as a file has it; where the one before or after it is cut away, it stands on the line."""
    begins = f"portal:{train.begins.section_id}" if isinstance(train.begins, AtPortal) else "stabled"
    ends = f"portal:{train.ends.section_id}" if isinstance(train.ends, AtPortal) else "stabled"
    if isinstance(train.ends, BecomesTrain) and train.ends.number in kept:
        ends = f"becomes:{train.ends.number}"
    before = [t.number for t in kept.values() if t.ends == BecomesTrain(train.number)]
    calls: list[dict[str, str]] = []
    for call in train.calls:
        times = {"arrival": call.arrival_s, "departure": call.departure_s}
        track = {"track": call.track} if call.track else {}
        calls.append(
            {"station": call.station_id, **track}
            | {name: clock(time_s) for name, time_s in times.items() if time_s is not None}
        )
    return {
        "number": train.number,
        "direction": "down" if train.direction is Direction.DOWN else "up",
        "revenue": train.revenue,
        "begins": f"from:{before[0]}" if before else begins,
        "ends": ends,
        "calls": calls,
    }
