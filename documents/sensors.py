"""Writes docs/sensors.md from sensors, readers, settings and faults: `python -m documents.sensors [FILE]`.

A sensor or a reader that this page does not know ends it with an error, so that none is left out.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, Final, cast

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from documents.page import write_page
from network.files.kinds import origin_of
from onboard.localisation import axles, curvature_map_file, fix, tachometer, tags
from onboard.localisation.table import READERS
from onboard.unit_records import UnitParameters
from simulation.faults.table import KINDS
from simulation.gnss_settings import Gnss
from simulation.sensor_settings import Beacons, Curvature, Lidar
from simulation.sensors.table import SENSORS
from simulation.settings import Carried, Sensors, Vision

FILE: Final = Path("docs/sensors.md")


@dataclass(frozen=True, slots=True)
class Page:
    """What this page says of a sensor beside what its modules say of themselves.

    `carried` is its word in `sensors.carries` (None: it is no matter of that); `settings` are the keys of its errors:
    table, class, and names of fields, all where there are none.
    """

    title: str
    reader: str
    carried: Carried | None
    estimate: str
    bounds: str
    table: str = ""
    settings: type[BaseModel] | None = None
    keys: tuple[str, ...] = ()


PAGES: Final[dict[str, Page]] = {
    "tachometer": Page(
        "Wheels (速度発電機)",
        "",
        None,
        "moves with every pulse",
        "only widen them: with the way, with slides and slips, with what another axle contradicts",
        "sensors",
        Sensors,
        ("wheel_factor_sigma", "creep_share", "tread_conicity", "flangeway_m", "tachometer_axle"),
    ),
    "slide_protection": Page(
        "Slide protection (滑走防止装置)",
        "",
        None,
        "none of itself: tells the wheels' reader what not to believe, and shows it another axle",
        "widen them while wheels slide or slip, and by what the two axles differ",
    ),
    "load_sensor": Page("Load sensor (応荷重)", "", None, "none: it tells the load", "none"),
    "tag_reader": Page(
        "Tags (地上子)",
        "",
        Carried.TAGS,
        "moved to the tag",
        "anew from the tags read last; a tag that disagrees widens them",
        "sensors",
        Sensors,
        ("tag_read_sigma_m", "tag_read_max_m", "tags", "tag_bit_error_factor"),
    ),
    "beacon_receiver": Page(
        "Beacons of the train stop (ATS 地上子)",
        "beacons",
        Carried.BEACONS,
        "leaned on one in its window",
        'cut by one that tells its number; others never (`trust = "paper"` is for the reproduction)',
        "beacons",
        Beacons,
    ),
    "sign_camera": Page(
        "Camera (停止位置目標)", "sign", None, "leaned on each sighting", "never cut", "vision", Vision
    ),
    "yaw_gyro": Page(
        "Curvature (線路曲率照合): a yaw gyro and a map",
        "curvature",
        Carried.CURVATURE,
        "moved to the best match",
        "cut to the shifts that noise and one jump of the bias can explain",
        "curvature",
        Curvature,
    ),
    "gnss_receiver": Page(
        "Satellites (GNSS)",
        "gnss",
        Carried.GNSS,
        "moved, or leaned where part of the sky is hidden",
        "cut to the protection level under an open sky, wider by what the receiver was seen to lie",
        "gnss",
        Gnss,
    ),
    "lidar": Page(
        "LiDAR and markers (ターゲットマーカ)",
        "lidar",
        Carried.LIDAR,
        "moved to a marker that was read",
        "cut by what a marker that was read may be wrong by",
        "lidar",
        Lidar,
    ),
}

HEAD: Final = """\
# Sensors

Made by `make docs` from `simulation/sensors/`, `onboard/localisation/`, their settings and faults; do not edit. For who
judges what a train may be believed to know of its place.

A train's unit has one **estimate** of its front and two **bounds**, ahead and behind; whatever is safe rests on the
bounds, never on the estimate: no limit is passed by the front that may be furthest ahead, nothing is given back before
the rear that may be furthest behind is clear. A checker compares truth and bounds in every step of every run. Wheels
widen the bounds as the train runs; a fix may cut them, or only move the estimate inside them, by what its sensor can be
deceived by. `branchline reproduce position-compare --out DIR` runs all of them on one line and shows both.
"""
CARRIED: Final = """
## What trains carry

`[sensors] carries = [...]` says what all trains carry beside wheels and slide protection, `carries_of` what single
stock does instead; cameras come with `[vision]`. A default train carries: {default}. Every train has wheels, slide
protection and a load sensor.
"""
RULE: Final = """
## The one rule of fixes

"""
SETTINGS_HEAD: Final = "| key | default | what it is | where the default comes from |\n|---|---|---|---|"


def document() -> str:
    """The whole text. ValueError for a sensor or a reader of the tables that has no page here."""
    sensors = {sensor.name: sensor for sensor in SENSORS}
    readers = {reader.name: reader for reader in READERS}
    unknown = set(sensors) ^ set(PAGES) | set(readers) ^ {
        page.reader for page in PAGES.values() if page.reader
    }
    if unknown:
        raise ValueError(
            f"documents/sensors.py has no page for, or a page too many: {', '.join(sorted(unknown))}"
        )
    parts = [HEAD, *_overview(), CARRIED.format(default=", ".join(f"`{word}`" for word in Sensors().carries))]
    parts += [RULE + _prose(fix.__doc__), ""]
    for name, page in PAGES.items():
        reader = sys.modules[readers[page.reader].function.__module__].__doc__ if page.reader else None
        if name == "tachometer":
            reader = tachometer.__doc__
        elif name == "slide_protection":
            reader = axles.__doc__
        elif name == "tag_reader":
            reader = tags.__doc__
        parts += _section(
            page, sys.modules[sensors[name].function.__module__].__doc__, reader, _module(name, sensors)
        )
    parts += ["## The map of curvature: format and version", "", _prose(curvature_map_file.__doc__), ""]
    return "\n".join(parts)


def _module(name: str, sensors: dict[str, Any]) -> str:
    return str(sensors[name].function.__module__)


def _overview() -> Iterator[str]:
    yield "| sensor | `carries` | what it may do to the estimate | to the bounds | settings |"
    yield "|---|---|---|---|---|"
    for page in PAGES.values():
        word = f"`{page.carried}`" if page.carried else "–"
        table = f"[`[{page.table}]`](files.md)" if page.table else "–"
        yield f"| {page.title} | {word} | {page.estimate} | {page.bounds} | {table} |"


def _section(page: Page, shows: str | None, means: str | None, module: str) -> Iterator[str]:
    yield f"## {page.title}\n"
    yield f"**What it shows.** {_prose(shows)}\n"
    if means:
        yield f"**What the unit makes of it.** {_prose(means)}\n"
    if page.settings is not None:
        names = page.keys or tuple(page.settings.model_fields)
        yield SETTINGS_HEAD
        for name in names:
            yield _setting(f"{page.table}.{name}", page.settings.model_fields[name])
        yield ""
    if page.title.startswith("Wheels"):
        yield from _bounds_settings()
    kinds = [kind for kind in KINDS if kind.__module__ == module]
    if kinds:
        yield (
            "Faults ([faults.md](faults.md)): "
            + "; ".join(
                f"`{kind.kind}`: {_line(kind.__doc__)[0].lower()}{_line(kind.__doc__)[1:].rstrip('.')}"
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


def _line(text: str | None) -> str:
    return " ".join((text or "").split())


if __name__ == "__main__":
    write_page(document, FILE)
