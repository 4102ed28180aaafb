"""Every kind of file: its model, and its JSON Schema for `branchline schema`, for editors and for docs/files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel

from exchange.additions import AdditionsFile
from network.errors import InputError
from network.files.line_schema import LineFile
from network.files.schema_walk import json_schema_of
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import one_of
from network.making.station_list import StationListFile
from network.raw import is_row
from scenario.key_examples import filled_example, with_examples, written_example
from scenario.scenario_file import ScenarioFile
from scenario.sweep_file import SweepFile
from vehicle.train_file import UNITS, TrainFile

DRAFT: Final = "https://json-schema.org/draft/2020-12/schema"


@dataclass(frozen=True, slots=True)
class FileKind:
    """A kind of file: its word, its model, and what its page says of it. Its examples are `examples/NAME.toml`."""

    name: str
    model: type[BaseModel]
    title: str
    text: str

    def example(self) -> dict[str, Any]:
        """Every key with a value: as the file of examples writes it, else its default."""
        return filled_example(json_schema_of(self.model), written_example(self.name))

    def schema(self) -> dict[str, Any]:
        """The JSON Schema with examples."""
        return with_examples(json_schema_of(self.model), self.example())


LINE: Final = FileKind(
    "line",
    LineFile,
    "Line",
    "`network/lines/*.toml`: what the line is. A figure has a source or is named in `assumed`.",
)
TIMETABLE: Final = FileKind(
    "timetable",
    TimetableFile,
    "Timetable",
    "`network/timetables/*.toml`: which trains are planned, and which set runs them.",
)
TRAIN: Final = FileKind(
    "train",
    TrainFile,
    "Train",
    "`vehicle/trains/*.toml`: what a kind of train is. Every figure is named in `[provenance]`.",
)
SCENARIO: Final = FileKind(
    "scenario",
    ScenarioFile,
    "Scenario and drill",
    "`study/scenarios/*.toml`, `study/drills/*/*.toml`: one run.",
)
FILES: Final = (
    LINE,
    TIMETABLE,
    TRAIN,
    SCENARIO,
    FileKind(
        "sweep",
        SweepFile,
        "Sweep",
        "`study/sweeps/*.toml`: a scenario varied over a grid and over what is drawn, for many days (docs/sweeps.md).",
    ),
    FileKind(
        "station_list",
        StationListFile,
        "Station list",
        "What `branchline new line` makes a line from (docs/make-a.md). A CSV has the keys of `[[stations]]` as its"
        " columns and a row for each station, with commas between cells.",
    ),
    FileKind(
        "additions",
        AdditionsFile,
        "Additions",
        "`network/additions/*.toml`: trains and sets that a published timetable lacks; `branchline import` takes them"
        " with `--add`.",
    ),
)


def schema_of(kind: str) -> dict[str, Any]:
    """The JSON Schema of a kind of file. Raises InputError for a kind that there is not."""
    if kind not in KINDS:
        raise InputError("command line", "KIND", kind, one_of(KINDS, kind))
    return {"$schema": DRAFT, **KINDS[kind](), "title": f"branchline {kind} file"}


def _scenario() -> dict[str, Any]:
    """A scenario that extends another may leave out what that one says."""
    schema = SCENARIO.schema()
    needed = schema.pop("required")
    return schema | {"anyOf": [{"required": needed}, {"required": ["extends"]}]}


def _drill() -> dict[str, Any]:
    """A drill says what must happen."""
    schema = _scenario()
    schema["properties"]["expect"]["minItems"] = 1
    return schema | {"required": ["expect"]}


def _train() -> dict[str, Any]:
    """Each figure in any of its units: one of the keys that differ in their ending alone."""
    schema = TRAIN.schema()
    for table in schema["$defs"].values():
        if "properties" not in table:
            continue  # a word among some
        properties, needed = table["properties"], set(table.get("required", ()))
        for key in list(properties):
            others = other_keys(key)
            for other, factor in others.items():
                properties[other] = _scaled(properties[key], factor)
            if others and key in needed:
                needed.remove(key)
                table.setdefault("allOf", []).append({"oneOf": [{"required": [k]} for k in (key, *others)]})
        table["required"] = sorted(needed)
    return schema


def other_keys(key: str) -> dict[str, float]:
    """Keys of a train file that mean the same in another unit, with the factor to SI."""
    found: dict[str, float] = {}
    for ending, si_ending, up, down in UNITS:
        plain = "_per_" not in key and key.endswith(si_ending)
        # `_m` is also the end of `_mm`'s SI, and of nothing else: longer endings have a unit of their own.
        if plain:
            found[key.removesuffix(si_ending) + ending] = up / down
    return found


def _scaled(node: dict[str, Any], factor: float) -> dict[str, Any]:
    """A figure's node in another unit: what bounds it is scaled."""
    scaled = deepcopy(node)
    items = scaled.get("items", {})
    scaled["examples"] = [_divided(example, factor) for example in scaled.get("examples", ())]
    for holder in (scaled, items, *scaled.get("oneOf", ()), *items.get("oneOf", ())):
        for bound in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "default"):
            if isinstance(holder.get(bound), int | float):
                holder[bound] = holder[bound] / factor
    return scaled


def _divided(value: object, factor: float) -> object:
    """A figure, or each of several, in another unit, without the digits that only come from the division."""
    if is_row(value):
        return [_divided(item, factor) for item in value]
    return float(f"{value / factor:.12g}") if isinstance(value, int | float) else value


KINDS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    "line": LINE.schema,
    "timetable": TIMETABLE.schema,
    "train": _train,
    "scenario": _scenario,
    "drill": _drill,
} | {kind.name: kind.schema for kind in FILES[4:]}
