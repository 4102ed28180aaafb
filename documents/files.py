"""Writes docs/files.md from the schemas: every kind of file, every key.

Run as `python -m documents.files [file]`; a test compares what is committed with what the schemas say.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, TypeAlias

from pydantic import BaseModel

from documents import ranges
from documents.interlocking import table
from documents.page import write_page
from network.files.line_schema import LineFile
from network.files.schema_walk import range_text, resolved
from network.files.timetable_schema import TimetableFile
from network.files.toml_text import value_text
from network.making.station_list import StationListFile
from study.scenario.key_examples import below as entries_below
from study.scenario.key_examples import example_of
from study.scenario.scenario_file import ScenarioFile
from study.sweep.sweep_file import SweepFile
from vehicle.train_file import UNITS, TrainFile

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = ROOT / "docs" / "files.md"
HEAD: Final = (
    "key",
    "type",
    "unit",
    "range",
    "default",
    "example",
    "meaning",
    "where the default comes from",
)
# The last part of a key's name, longest first.
UNIT_OF: Final = {
    "_n_per_kn_kmh": "N/kN per km/h",
    "_n_per_kn": "N/kN",
    "_n_per_kmh2": "N per (km/h)²",
    "_s_per_m": "s/m",
    "_per_s": "1/s",
    "_mps3": "m/s³",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_kmh": "km/h",
    "_km": "km",
    "_mm": "mm",
    "_deg": "°",
    "_kg": "kg",
    "_hz": "Hz",
    "_m": "m",
    "_s": "s",
    "_n": "N",
    "_w": "W",
    "_p": "probability",
    "_share": "share",
    "permille": "‰",
}
KINDS: Final[tuple[tuple[str, type[BaseModel], str], ...]] = (
    (
        "Line",
        LineFile,
        "`network/lines/*.toml`: what the line is. A figure has a source or is named in `assumed`.",
    ),
    (
        "Timetable",
        TimetableFile,
        "`network/timetables/*.toml`: which trains are planned, and which set runs them.",
    ),
    (
        "Train",
        TrainFile,
        "`vehicle/trains/*.toml`: what a kind of train is. Every figure is named in `[provenance]`.",
    ),
    ("Scenario and drill", ScenarioFile, "`study/scenarios/*.toml`, `study/drills/*/*.toml`: one run."),
    (
        "Sweep",
        SweepFile,
        "`study/sweeps/*.toml`: a scenario varied over a grid and over what is drawn, for many days (docs/sweeps.md).",
    ),
    (
        "Station list",
        StationListFile,
        "What `branchline new line` makes a line from (docs/make-a.md). A CSV has the keys of `[[stations]]` as its"
        " columns and a row for each station, with commas between cells.",
    ),
)
EXAMPLES: Final[Mapping[type[BaseModel], str]] = {
    LineFile: "line",
    TimetableFile: "timetable",
    TrainFile: "train",
    ScenarioFile: "scenario",
    SweepFile: "sweep",
    StationListFile: "station_list",
}
Entries: TypeAlias = tuple[Mapping[str, Any], ...]
_FORMATS: Final = {"HH:MM": "time", "identifier": "identifier"}
_INTRO: Final = """# Files

Made by `make docs` from the schemas that read the files; `branchline schema KIND` prints them as JSON Schema. All are
TOML. A key that is not listed is refused, and so is a value outside its range: one message says file, key, value and
what was expected. `needed` in place of a default: the key must be there. Shipped files are found by name, others by
their path beside the scenario that names them.

An `identifier` is at most 64 of `A-Z a-z 0-9 . _ -`, begins with a letter or a digit, does not end in a dot and is
no name that Windows keeps for a device (`con`, `nul.toml`): it becomes a directory, an id of SUMO, a key of Zenoh.
Japanese stands in the `name` and `name_ja` beside it. Text has no control characters; a name is one line of at most
200 characters.
"""
_TOGETHER: Final = """## How the files go together

A **scenario** is one run: it names a **line** (what the track is), a **timetable** of that line (which trains run on
it, and which set runs which train) and, for its sets, **train** files (what a kind of train is); its own tables say how
radio, units, driving and sensors are. All that it does not say has a default.

```
scenario ── line ──────────── sections, points, stations, tags
   │    └── timetable ─────── trains with their calls, diagrams of the sets
   │    └── [trains] default ─ a train file; [trains.stock] others by set
   └── extends ─── another scenario: what this one leaves out; [patch.*] changes what is named, by id
drill = a scenario with [[fault]] (what fails), [[act]] (what people do), [[expect]] (what must be so)
```

A what-if is a scenario that `extends` another and patches it; nothing is copied. `branchline new scenario`, `new
timetable`, `new train`, `new drill` and `new line` write files to begin with, which run as they stand; `branchline
check` reads everything and runs nothing; `branchline schema KIND` is for editors. The examples in the tables below are
accepted where they stand (`study/scenario/examples`). A whole small file of each kind, with which the tests run:
"""
WHOLE: Final[Mapping[str, str]] = {
    "A line of three stations": "tests/examples/line/valley.toml",
    "Its timetable": "tests/examples/line/valley_times.toml",
    "A scenario that runs it": "tests/examples/line/valley_day.toml",
    "A train": "vehicle/trains/br642.toml",
    "A drill": "study/drills/karasuyama/42_doors.toml",
}
_UNITS_INTRO: Final = "Instead of a key in SI a file may have one of another ending, which is converted: "
_WORDS: Final = """### What a patch may say

`[patch.line]`, `[patch.timetable]` and `[patch.train.<name>]` change the file that the scenario names; the other tables
change what extended scenarios have said. `set` writes a value, or a whole list in place of what was there; `add` and
`remove` change a list; `times` multiplies. Entries of lists are called by their id, name, number, station or stock,
else by their index, and `*` is all of them: `"points.*.throw_time_s"`, `"trains.323M.calls.OGN.departure"`,
`"alignments.main.limits[3].speed_kmh"`. `add` takes limits, curves and coverage to the first alignment, unless the
entry names its `alignment`: a restriction is an entry of its own.

```toml
[patch.line.add]
limits = [{ from_km = 7.5, to_km = 7.9, speed_kmh = 25, directions = ["down", "up"] }]
```

The report and `summary.json` list every difference.
"""


def document() -> str:
    """The whole page."""
    parts = [_INTRO, _TOGETHER, *_wholes(), ranges.section()]
    for title, model, text in KINDS:
        parts.append(f"## {title}\n\n{text}\n")
        if model is TrainFile:
            endings = ", ".join(f"`{ending}` for `{si}`" for ending, si, _, _ in UNITS)
            parts.append(f"{_UNITS_INTRO}{endings}.\n")
        for name, doc, rows in tables_of(model, example_of(EXAMPLES[model])):
            parts.append(f"### {name}\n")
            if doc:
                parts.append(f"{doc}\n")
            parts.append(table(HEAD, rows) + "\n")
        if model is ScenarioFile:
            parts.append(_WORDS)
    return "\n".join(parts)


def _wholes() -> Iterator[str]:
    """A whole small file of each kind, folded, as the tests run them."""
    for title, path in WHOLE.items():
        text = (ROOT / path).read_text("utf-8").rstrip()
        yield f"<details><summary>{title}: {path}</summary>\n\n```toml\n{text}\n```\n\n</details>\n"


def tables_of(
    model: type[BaseModel], example: Mapping[str, Any] | None = None
) -> Iterator[tuple[str, str, list[tuple[str, ...]]]]:
    """Every table of a file: how it is written, what it is, and a row a key, with what `example` has there."""
    schema = model.model_json_schema()
    waiting: list[tuple[str, Mapping[str, Any], Entries]] = [("", schema, (example or {},))]
    while waiting:
        path, node, entries = waiting.pop(0)
        rows: list[tuple[str, ...]] = []
        below: list[tuple[str, Mapping[str, Any], Entries]] = []
        for key, own in node["properties"].items():
            field = resolved(schema, own)
            child, form = _child(schema, field)
            said = _example(entries, key)
            if child is not None and "properties" in child:
                where = _written(path, key, form)
                below.append((where, child, tuple(entries_below(entries, key))))
                if "description" not in own:
                    continue
                said = _heading(where)
            rows.append(_row(key, own, field, key in node.get("required", ()), said))
        if rows:
            yield _heading(path), _about(node.get("description", "")) if path else "", rows
        waiting = below + waiting


def _about(docstring: str) -> str:
    """A table's docstring without the name of the table, which the heading says."""
    text = _first_line(docstring)
    if text.startswith("`"):
        text = text.partition("`")[2].partition("`")[2].removeprefix(":").removeprefix(".").strip()
    return text[:1].upper() + text[1:]


def _child(schema: Mapping[str, Any], field: Mapping[str, Any]) -> tuple[Mapping[str, Any] | None, str]:
    """The table that a key holds, one or many or by name; None for a plain value."""
    if "properties" in field:
        return field, "table"
    if "items" in field:
        return resolved(schema, field["items"]), "list"
    if isinstance(field.get("additionalProperties"), Mapping):
        return resolved(schema, field["additionalProperties"]), "named"
    return None, ""


def _written(path: str, key: str, form: str) -> str:
    full = f"{path}.{key}" if path else key
    return {"list": f"{full}[]", "named": f"{full}.<id>", "table": full}[form]


def _heading(path: str) -> str:
    """How a table is written: a list of tables in double brackets."""
    if not path:
        return "At the top"
    plain = path.replace("[]", "")
    return f"`[[{plain}]]`" if path.endswith("[]") else f"`[{plain}]`"


def _example(entries: Entries, key: str) -> str:
    """What the first entry that has the key says there, as a file writes it."""
    value = next((entry[key] for entry in entries if key in entry), None)
    return "" if value is None else f"`{value_text(value)}`"


def _row(
    key: str, own: Mapping[str, Any], field: Mapping[str, Any], needed: bool, example: str
) -> tuple[str, ...]:
    numbers = field.get("items", field) if field.get("type") == "array" else field
    default = "needed" if needed else _default(own.get("default"))
    meaning = str(own.get("description", field.get("description", "")))
    return (
        f"`{key}`",
        _type(own, field),
        _unit(key),
        _choice(numbers) or range_text(numbers),
        default,
        example,
        _first_line(meaning),
        str(own.get("origin", "")),
    )


def _default(value: object) -> str:
    """A default as the file writes it; a dash where a key that is left out means nothing."""
    return (
        "–"
        if value in (None, [], {}, "") or isinstance(value, dict)
        else f"`{json.dumps(value, ensure_ascii=False)}`"
    )


def _type(own: Mapping[str, Any], field: Mapping[str, Any]) -> str:
    if "enum" in field or "const" in field:
        return "word"
    if field.get("type") == "array":
        items = field.get("items", {})
        return "list of tables" if "$ref" in items or items.get("type") == "object" else "list"
    if field.get("format") in _FORMATS:
        return _FORMATS[str(field["format"])]
    names = {
        "number": "number",
        "integer": "whole number",
        "string": "text",
        "boolean": "true or false",
        "object": "table",
    }
    return names.get(str(field.get("type")), "any" if "type" not in own else str(own["type"]))


def _choice(field: Mapping[str, Any]) -> str:
    if "const" in field:
        return f"`{field['const']}`"
    return ", ".join(f"`{value}`" for value in field.get("enum", ()))


def _unit(key: str) -> str:
    return next((unit for ending, unit in UNIT_OF.items() if key.endswith(ending)), "")


def _first_line(text: str) -> str:
    """The first paragraph in one line."""
    return " ".join(text.partition("\n\n")[0].split())


if __name__ == "__main__":
    write_page(document, FILE)
