"""Writes docs/files.md and docs/files/ from the schemas: a page for each kind of file, with every key."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from documents import ranges
from documents.interlocking import table
from documents.page import write_pages
from network.files.schema_walk import range_text, resolved_node
from network.files.toml_text import value_text
from scenario.schemas import FILES, SCENARIO, TRAIN, FileKind
from scenario.script_file import ACT_KEYS
from simulation.faults.script import ACT_MEANINGS, WORDS_HELP
from vehicle.train_file import UNITS

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = ROOT / "docs" / "files.md"
FOLDER: Final = ROOT / "docs" / "files"
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
_FORMATS: Final = {"HH:MM": "time", "identifier": "identifier"}
_INTRO: Final = """# Files

Made by `make docs` from the schemas that read the files; `branchline schema KIND` prints them as JSON Schema. All are
TOML. An unknown key is refused, and so is a value outside its range: one message says file, key, value and what was
expected. `needed` in place of a default means that the key is required. Shipped files are found by name, others by
their path beside the scenario that names them.

An `identifier` is at most 64 of `A-Z a-z 0-9 . _ -`, begins with a letter or a digit, does not end in a dot and is no
name that Windows reserves for a device (`con`, `nul.toml`), because it is used for directories, ids of SUMO and keys
of Zenoh. Japanese is for `name` and `name_ja`. Text has no characters that are not seen
(control characters, marks of direction such as U+202E); a name is one line of at most 200.
"""
_TOGETHER: Final = """## How the files go together

A **scenario** is one run: it names a **line** (what the track is), a **timetable** of that line (which trains run on
it, and which set runs which train) and, for its sets, **train** files (what a kind of train is). Its own tables set
radio, units, driving and sensors; everything else has a default.

```
scenario ── line ──────────── sections, points, stations, tags
   │    └── timetable ─────── trains with their calls, diagrams of the sets
   │    └── [trains] default ─ a train file; [trains.stock] others by set
   └── extends ─── another scenario: what this one leaves out; [patch.*] changes what is named, by id
drill = a scenario with [[fault]] (what fails), [[act]] (what people do), [[expect]] (what must be so)
```

A what-if is a scenario that `extends` another and patches it; nothing is copied. `branchline new scenario`, `new
timetable`, `new train`, `new drill` and `new line` write files to start from, which run as they stand; `branchline
check` reads everything and runs nothing; `branchline schema KIND` is for editors. The examples in the tables are valid
as they stand. Below is a whole small file of each kind, as the tests run them:
"""
WHOLE: Final[Mapping[str, str]] = {
    "A line of three stations": "tests/examples/line/valley.toml",
    "Its timetable": "tests/examples/line/valley_times.toml",
    "A scenario that runs it": "tests/examples/line/valley_day.toml",
    "A train": "vehicle/trains/br642.toml",
    "A drill": "study/drills/karasuyama/42_doors.toml",
}
_START: Final = (
    "The `start` of faults and acts may be a time (HH:MM:SS); that, and the events of expectations"
)
_UNITS_INTRO: Final = "Instead of a key in SI a file may have one of another ending, which is converted: "
_WORDS: Final = """## What a patch may say

`[patch.line]`, `[patch.timetable]` and `[patch.train.<name>]` change the file that the scenario names; the other
tables change the settings of the scenarios that it extends. `set` replaces a value or a whole list, `add` and `remove`
change a list, `times` multiplies. Entries of lists are named by id, name, number, station or stock, otherwise by
index, and `*` means all of them: `"points.*.throw_time_s"`, `"trains.323M.calls.OGN.departure"`,
`"alignments.main.limits[3].speed_kmh"`. `add` puts limits, curves and coverage into the first alignment, unless the
entry names its `alignment`. A speed restriction is an added entry:

```toml
[patch.line.add]
limits = [{ from_km = 7.5, to_km = 7.9, speed_kmh = 25, directions = ["down", "up"] }]
```

The report and `summary.json` list every difference.
"""


def pages() -> Iterator[tuple[Path, str]]:
    """The pages, each with its place."""
    kinds = [(f"files/{kind.name}.md", kind.title, kind.text) for kind in FILES]
    kinds.append(("files/ranges.md", "Ranges", "What a figure of any file may be, and what that rests on."))
    contents = (f"- [{title}]({place}): {text}" for place, title, text in kinds)
    yield FILE, "\n".join((_INTRO, *contents, "", _TOGETHER, *_wholes()))
    yield FOLDER / "ranges.md", ranges.document()
    for kind in FILES:
        yield FOLDER / f"{kind.name}.md", _page(kind)


def _page(kind: FileKind) -> str:
    """What a kind of file may say, table by table."""
    parts = [f"# {kind.title}\n\n{kind.text} [What all files have in common](../files.md).\n"]
    if kind is TRAIN:
        endings = ", ".join(f"`{ending}` for `{si}`" for ending, si, _, _ in UNITS)
        parts.append(f"{_UNITS_INTRO}{endings}.\n")
    for name, doc, rows in tables_of(kind.schema()):
        parts.append(f"## {name}\n")
        if doc:
            parts.append(f"{doc}\n")
        parts.append(table(HEAD, rows) + "\n")
    if kind is SCENARIO:
        parts += [_acts(), _WORDS]
    return "\n".join(parts)


def _acts() -> str:
    """What people can do, with the keys of each kind, and the words for an event."""
    rows = [
        (f"`{kind.value}`", ", ".join(f"`{key}`" for key in sorted(ACT_KEYS[kind])), meaning)
        for kind, meaning in ACT_MEANINGS.items()
    ]
    return (
        f"## Kinds of acts\n\n{table(('kind', 'keys', 'meaning'), rows)}\n\n{_START}, may be {WORDS_HELP}.\n"
    )


def _wholes() -> Iterator[str]:
    """A whole small file of each kind, folded, as the tests run them."""
    for title, path in WHOLE.items():
        text = (ROOT / path).read_text("utf-8").rstrip()
        yield f"<details><summary>{title}: {path}</summary>\n\n```toml\n{text}\n```\n\n</details>\n"


def tables_of(schema: Mapping[str, Any]) -> Iterator[tuple[str, str, list[tuple[str, ...]]]]:
    """Every table of a file: how it is written, what it is, and a row a key; those of one form are one."""
    found: dict[str, tuple[list[str], Mapping[str, Any]]] = {}
    _find_tables(schema, schema, "", found)
    for paths, node in found.values():
        rows = [
            row for key, own in node["properties"].items() for row in _rows(schema, paths[0], node, key, own)
        ]
        if rows:
            about = _about(node.get("description", "")) if paths != [""] else ""
            yield ", ".join(map(_heading, paths)), about, rows


def _find_tables(
    schema: Mapping[str, Any],
    node: Mapping[str, Any],
    path: str,
    found: dict[str, tuple[list[str], Mapping[str, Any]]],
) -> None:
    """By its title, each form of table with the places that have it."""
    found.setdefault(node["title"], ([], node))[0].append(path)
    for key, own in node["properties"].items():
        child, form = _child(schema, resolved_node(schema, own))
        if child is not None and "properties" in child:
            _find_tables(schema, child, _written(path, key, form), found)


def _rows(
    schema: Mapping[str, Any], path: str, node: Mapping[str, Any], key: str, own: Mapping[str, Any]
) -> Iterator[tuple[str, ...]]:
    """The row of a key; none for a table of which only itself has something to say."""
    field = resolved_node(schema, own)
    child, form = _child(schema, field)
    said = f"`{value_text(own['examples'][0])}`" if own.get("examples") else ""
    if child is not None and "properties" in child:
        if "description" not in own:
            return
        said = _heading(_written(path, key, form))
    yield _row(key, own, field, key in node.get("required", ()), said)


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
        return resolved_node(schema, field["items"]), "list"
    if isinstance(field.get("additionalProperties"), Mapping):
        return resolved_node(schema, field["additionalProperties"]), "named"
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


def _row(
    key: str, own: Mapping[str, Any], field: Mapping[str, Any], needed: bool, example: str
) -> tuple[str, ...]:
    numbers = field.get("items", field) if field.get("type") == "array" else field
    default = "needed" if needed else _default(own.get("default"))
    meaning = str(own.get("description", field.get("description", "")))
    return (
        f"`{key}`",
        _type(own, field),
        next((unit for ending, unit in UNIT_OF.items() if key.endswith(ending)), ""),
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


def _first_line(text: str) -> str:
    """The first paragraph in one line."""
    return " ".join(text.partition("\n\n")[0].split())


if __name__ == "__main__":
    write_pages(pages())
