"""The tables of a scenario that are about stops: `[scatter]`, `[tuning]`, `[vision]`, and what trains have learned.

Refused with one message: a stock, station or file that does not exist, times that are no part of a day.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import Field

from network.errors import InputError
from network.files.toml_input import Record, one_of, read_text
from network.model import Line
from onboard.driving.tuning import Learned, learned_from
from simulation.setup import Tuning, Vision
from simulation.world.scatter import Individual, Scatter, Weather

DAYS_MAX: Final = 60
_CLOCK: Final = re.compile(r"(\d{1,2}):([0-5]\d)")


class WeatherTable(Record):
    """One entry of `scatter.weather`; times as HH:MM, going on after 24:00."""

    begin: str = Field(alias="from")
    end: str = Field(alias="to")
    adhesion_low: float = Field(gt=0.0, le=1.0)
    adhesion_high: float = Field(gt=0.0, le=1.0)


class IndividualTable(Record):
    """`[scatter.stock.<id>]`: what is known of one stock's brakes instead of being drawn."""

    brake_factor: float | None = Field(default=None, gt=0.0, le=2.0)
    dead_time_offset_s: float | None = Field(default=None, ge=-2.0, le=2.0)
    lag_offset_s: float | None = Field(default=None, ge=-2.0, le=2.0)


class ScatterTable(Record):
    """`[scatter]`."""

    brake_sigma: float = Field(default=0.0, ge=0.0, le=0.3)
    brake_leg_sigma: float = Field(default=0.0, ge=0.0, le=0.3)
    dead_time_spread_s: float = Field(default=0.0, ge=0.0, le=2.0)
    lag_spread_s: float = Field(default=0.0, ge=0.0, le=2.0)
    weather: list[WeatherTable] = Field(default_factory=list)
    stock: dict[str, IndividualTable] = Field(default_factory=dict)


class TuningTable(Record):
    """`[tuning]`; `learned` is a file that an earlier run has left, beside the scenario."""

    days: int = Field(default=1, ge=1, le=DAYS_MAX)
    learn: bool = True
    learned: str | None = None


class VisionTable(Record):
    """`[vision]`: which stations have stop signs."""

    stations: list[str] | Literal["all"] = "all"
    rate_hz: float = Field(default=5.0, gt=0.0, le=10.0)


def scatter_of(file: str, table: ScatterTable, stock_ids: Iterable[str]) -> Scatter:
    """The scatter of trains and days. InputError for an unknown stock or a time that is none."""
    known = sorted(stock_ids)
    for stock_id in table.stock:
        if stock_id not in known:
            raise InputError(
                file, f"scatter.stock.{stock_id}", None, f"a stock id, {one_of(known, stock_id)}"
            )
    weather = tuple(_weather(file, f"scatter.weather[{i}]", part) for i, part in enumerate(table.weather))
    values = table.model_dump(exclude={"weather", "stock"})
    stock = {stock_id: Individual(**own.model_dump()) for stock_id, own in table.stock.items()}
    return Scatter(**values, weather=weather, stock=stock)


def tuning_of(path: Path, table: TuningTable | None, stock_ids: Iterable[str]) -> Tuning:
    """Whether and how trains learn; without a table they do not."""
    if table is None:
        return Tuning()
    learned = {}
    if table.learned is not None:
        known = read_learned(path.parent / table.learned)
        learned = {stock_id: known[stock_id] for stock_id in stock_ids if stock_id in known}
    return Tuning(table.learn, table.days, learned)


def vision_of(file: str, table: VisionTable | None, line: Line) -> Vision:
    """The stations with signs. InputError for an unknown one, or where the camera's extra is not installed."""
    if table is None:
        return Vision()
    if find_spec("cv2") is None:
        raise InputError(file, "vision", None, "the extra [vision] to be installed")
    if table.stations == "all":
        return Vision(frozenset(line.stations), table.rate_hz)
    for index, station_id in enumerate(table.stations):
        if station_id not in line.stations:
            expected = f"a station id, {one_of(line.stations, station_id)}, or all"
            raise InputError(file, f"vision.stations[{index}]", station_id, expected)
    return Vision(frozenset(table.stations), table.rate_hz)


def read_learned(path: Path) -> dict[str, Learned]:
    """What the trains of an earlier run learned, by stock id. InputError for a file that is not of that kind."""
    try:
        data = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(str(path), "", None, f"valid JSON ({error})") from error
    if not isinstance(data, dict) or not all(isinstance(kept, dict) for kept in data.values()):
        raise InputError(str(path), "", None, "an object of trains, as a run with [tuning] leaves it")
    return {str(stock_id): learned_from(str(path), kept) for stock_id, kept in data.items()}


def learned_json(learned: Mapping[str, Learned]) -> str:
    """The file's text, by stock id."""
    kept: dict[str, Any] = {stock_id: learned[stock_id].as_dict() for stock_id in sorted(learned)}
    return json.dumps(kept, indent=1) + "\n"


def _weather(file: str, key: str, part: WeatherTable) -> Weather:
    begin_s, end_s = _time_s(file, f"{key}.from", part.begin), _time_s(file, f"{key}.to", part.end)
    if end_s <= begin_s:
        raise InputError(file, f"{key}.to", part.end, f"a time after {part.begin}")
    if part.adhesion_high < part.adhesion_low:
        expected = f"at least adhesion_low = {part.adhesion_low:g}"
        raise InputError(file, f"{key}.adhesion_high", part.adhesion_high, expected)
    return Weather(begin_s, end_s, part.adhesion_low, part.adhesion_high)


def _time_s(file: str, key: str, text: str) -> float:
    found = _CLOCK.fullmatch(text)
    if found is None:
        raise InputError(file, key, text, "a time as HH:MM")
    return 3600.0 * int(found[1]) + 60.0 * int(found[2])
