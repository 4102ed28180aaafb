"""Writes docs/sensors.md from sensors, readers, settings and faults: `python -m documents.sensors [FILE]`.

A reader that no sensor names ends it with an error, so that none is left out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import Final, cast, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from documents.faults import in_one_line
from documents.page import write_page
from network.files.kinds import origin_of
from onboard.localisation import curvature_map_file, fix
from onboard.localisation.table import READERS
from onboard.unit_records import UnitParameters
from simulation.faults.table import KINDS
from simulation.sensors.table import SENSORS, Sensor
from simulation.settings import Sensors, Tables

FILE: Final = Path("docs/sensors.md")


HEAD: Final = """\
# Sensors

Made by `make docs` from `simulation/sensors/`, `onboard/localisation/`, their settings and faults; do not edit.

A unit has one **estimate** of its train's front and two **bounds**, ahead and behind. Safety depends on the bounds
alone: the foremost possible front passes no limit, and nothing is given back before the rearmost possible rear is
clear. A checker compares bounds and truth in every step of every run. Wheels widen the bounds as the train runs. A
**fix** of a sensor may cut the bounds, that is, narrow them; a sensor that can be deceived may only move the estimate
inside them. `branchline reproduce position-compare --out DIR` runs all sensors on one line and shows both.
"""
CARRIED: Final = """
## What trains carry

`[sensors] carries = [...]` says what all trains carry besides wheels, slide protection and load sensor, which every
train has; `carries_of` says it for single stock. Cameras come with `[vision]`. The default is {default}.
"""
RULE: Final = """
## One rule for all fixes

"""
MAP: Final = """
## The map of curvature

Trains with a yaw gyro compare their run with this map. `[curvature] map = "design"` is the line's alignment, as units
believe it to be; otherwise it is a file beside the scenario:

    branchline new curvature-map karasuyama_weekday curves.json --train 322M    # from a first run of that train
    branchline new curvature-map karasuyama_weekday curves.json                 # the design, written to a file

On a first run the train finds its position by tags and wheels, and its gyro records the curvature. The gyro's bias
between two stands goes evenly from the one to the other. Track that the train has not passed on the first and the last
piece is as in the alignment; other pieces are not in the map, and nothing is compared there.
"""
SETTINGS_HEAD: Final = "| key | default | what it is | where the default comes from |\n|---|---|---|---|"


def document() -> str:
    """The whole text. ValueError for a reader that no sensor names."""
    unknown = {reader.function.__module__ for reader in READERS} - {_means(each) for each in SENSORS}
    if unknown:
        raise ValueError(f"no sensor of simulation/sensors/table.py is meant by {', '.join(sorted(unknown))}")
    parts = [HEAD, *_overview(), CARRIED.format(default=", ".join(f"`{word}`" for word in Sensors().carries))]
    parts += [RULE + _prose(fix.__doc__), ""]
    for sensor in SENSORS:
        parts += _section(sensor)
    parts += [MAP, _prose(curvature_map_file.__doc__), ""]
    return "\n".join(parts)


def _means(sensor: Sensor) -> str:
    """The module that says what a sensor means to the unit."""
    return f"onboard.localisation.{sensor.page.meant_by}"


def _file(what: type | Callable[..., object]) -> str:
    """The name of the file: faults of a sensor stand in one of its name."""
    return what.__module__.rpartition(".")[2]


def _overview() -> Iterator[str]:
    yield "| sensor | `carries` | what it may do to the estimate | to the bounds | settings |"
    yield "|---|---|---|---|---|"
    for sensor in SENSORS:
        word = f"`{sensor.carried}`" if sensor.carried else "–"
        page = sensor.page
        tables = ", ".join(f"[`[{table}]`](files/scenario.md)" for table in page.settings) or "–"
        yield f"| {page.title} | {word} | {page.estimate} | {page.bounds} | {tables} |"


def _section(sensor: Sensor) -> Iterator[str]:
    yield f"## {sensor.page.title}\n"
    yield f"**What it shows.** {_prose(sys.modules[sensor.function.__module__].__doc__)}\n"
    if sensor.page.meant_by:
        yield f"**What the unit makes of it.** {_prose(import_module(_means(sensor)).__doc__)}\n"
    for table, keys in sensor.page.settings.items():
        settings: type[BaseModel] = get_type_hints(Tables)[table]
        yield SETTINGS_HEAD
        for name in keys or settings.model_fields:
            yield _setting(f"{table}.{name}", settings.model_fields[name])
        yield ""
    if sensor.page.title.startswith("Wheels"):
        yield from _bounds_settings()
    kinds = [kind for kind in KINDS if _file(kind) == _file(sensor.function)]
    if kinds:
        yield (
            "Faults ([faults.md](faults.md)): "
            + "; ".join(
                f"`{kind.kind}`: {in_one_line(kind.__doc__)[0].lower()}{in_one_line(kind.__doc__)[1:].rstrip('.')}"
                for kind in kinds
            )
            + ".\n"
        )


def _bounds_settings() -> Iterator[str]:
    yield "What units count on:\n"
    yield SETTINGS_HEAD
    for name in (
        "wheel_error_share",
        "wheel_scale_limit",
        "doubt_error_share",
        "tag_accuracy_m",
        "tag_window_m",
    ):
        yield _setting(f"unit.{name}", UnitParameters.model_fields[name])
    yield ""


def _setting(key: str, info: FieldInfo) -> str:
    default = info.get_default(call_default_factory=True)
    return f"| `{key}` | {_value(default)} | {info.description or ''} | {origin_of(info)} |"


def _value(value: object) -> str:
    if isinstance(value, BaseModel):
        return ", ".join(f"{name} {_value(each)}" for name, each in value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, tuple):
        return ", ".join(_value(each) for each in cast("tuple[object, ...]", value)) or "none"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _prose(text: str | None) -> str:
    """A docstring as it stands: its lines are Markdown already."""
    return (text or "").strip()


if __name__ == "__main__":
    write_page(document, FILE)
