"""Plans as tests make them: trains on a line, and the setup that runs them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

from network.files.line_file import load_line, parse_line
from network.files.shipped import shipped_line
from network.model import Line
from network.timetable import parse_timetable
from onboard.unit_records import UnitParameters
from simulation.settings import Operation
from simulation.setup import Setup
from tests.system.chaos.ground import Call, Planned, timetable_table
from tests.system.chaos.toml_text import toml_of
from vehicle.train_file import TrainType, shipped_train
from vehicle.train_patch import patched_train

DWELL_MIN_S = 20


@dataclass(frozen=True)
class Plan:
    """A plan: what runs on a line, and how it is operated."""

    line: Line
    trains: tuple[Planned, ...]
    dwell_min_s: int = DWELL_MIN_S
    operation: Operation = field(default_factory=Operation)

    def train(self, number: str) -> Planned:
        return next(train for train in self.trains if train.number == number)

    def with_train(self, changed: Planned) -> Plan:
        """The same with a train in place of that of its number, or one more."""
        numbers = [train.number for train in self.trains]
        if changed.number not in numbers:
            return replace(self, trains=(*self.trains, changed))
        return replace(self, trains=tuple(changed if t.number == changed.number else t for t in self.trains))

    def setup(self) -> Setup:
        table: dict[str, Any] = timetable_table("plan", self.line.id, list(self.trains))
        table["timetable"]["dwell_min_s"] = self.dwell_min_s
        for train in table["trains"]:  # a call may name no track
            train["calls"] = [{k: v for k, v in call.items() if v} for call in train["calls"]]
        timetable = parse_timetable(toml_of(table), "plan.toml", self.line)
        kind = train_type()
        return Setup(
            name="plan",
            line=self.line,
            timetable=timetable,
            trains={diagram.stock_id: kind for diagram in timetable.diagrams},
            unit=UnitParameters(dwell_min_s=self.dwell_min_s),
            operation=self.operation,
        )


@cache
def train_type() -> TrainType:
    return patched_train(shipped_train("ev_e301"), ())[0]


@cache
def busy_line() -> Line:
    return load_line(shipped_line("busy_line"))


def line_of(text: str, name: str) -> Line:
    return parse_line(text, name)


def call_at(train: Planned, station: str) -> Call:
    return next(call for call in train.calls if call.station == station)


def with_call(train: Planned, station: str, **changes: object) -> Planned:
    """The train with its call at a station changed."""
    calls = tuple(replace(c, **changes) if c.station == station else c for c in train.calls)
    return replace(train, calls=calls)


def later(train: Planned, by_s: int, only_from: str | None = None) -> Planned:
    """The train that much later, from a station on or altogether."""
    begun = only_from is None
    calls: list[Call] = []
    for call in train.calls:
        begun = begun or call.station == only_from
        arrival_s = call.arrival_s if call.arrival_s is None or not begun else call.arrival_s + by_s
        departure_s = call.departure_s if call.departure_s is None or not begun else call.departure_s + by_s
        calls.append(replace(call, arrival_s=arrival_s, departure_s=departure_s))
    return replace(train, calls=tuple(calls))
