"""Writes docs/journal.md from the types of events: `python -m documents.journal [FILE]`.

Keys and types of the data are those of the JSON Schema that msgspec makes of the types, units are the ends of names.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from documents.interlocking import table
from documents.page import write_page
from simulation.events import EVENTS, EventType, authors_of

FILE: Final = Path("docs/journal.md")
HEAD: Final = ("event", "written by", "data", "meaning")
TYPES: Final[Mapping[str, str]] = {
    "string": "text",
    "integer": "integer",
    "number": "number",
    "boolean": "yes or no",
}
UNITS: Final[Mapping[str, str]] = {"m": "m", "s": "s", "mps": "m/s", "mps2": "m/s²", "bytes": "bytes"}
_REF: Final = "#/{name}"


def document() -> str:
    """The whole document."""
    rows = [(f"`{word}`", _authors(kind), _data(kind), _meaning(kind)) for word, kind in EVENTS.items()]
    return f"{_INTRO.strip()}\n\n{table(HEAD, rows)}\n"


def _authors(kind: EventType) -> str:
    return ", ".join(author.value for author in authors_of(kind))


def _meaning(kind: EventType) -> str:
    return " ".join((kind.__doc__ or "").split())


def _data(kind: EventType) -> str:
    """Each key with its type and unit; an optional one has a default and may be left out."""
    (schema,), components = msgspec.json.schema_components([kind], ref_template=_REF)
    own = _resolved(schema, components)
    required = set(own["required"])
    keys = {key: value for key, value in own["properties"].items() if key != "what"}
    said = (
        _key(key, value, components) + ("" if key in required else ", optional")
        for key, value in keys.items()
    )
    return "; ".join(said)


def _key(key: str, value: Mapping[str, Any], components: Mapping[str, Any]) -> str:
    """A key with its type and unit."""
    unit = UNITS.get(key.rpartition("_")[2]) if "_" in key else None
    return f"`{key}`: " + " ".join(filter(None, (_type(value, components), unit and f"in {unit}")))


def _resolved(schema: Mapping[str, Any], components: Mapping[str, Any]) -> Mapping[str, Any]:
    ref = schema.get("$ref")
    return schema if ref is None else components[ref.removeprefix("#/")]


def _type(schema: Mapping[str, Any], components: Mapping[str, Any]) -> str:
    """A type of JSON in words."""
    schema = _resolved(schema, components)
    if "anyOf" in schema:
        return " or ".join(_type(option, components) for option in schema["anyOf"])
    if "enum" in schema:
        return "one of " + ", ".join(f'"{value}"' for value in schema["enum"])
    if schema["type"] == "array":
        items = _resolved(schema["items"], components)
        return f"list of {_type(items, components)}" + ("" if "properties" in items else "s")
    if "properties" in schema:
        keys = (_key(key, value, components) for key, value in schema["properties"].items())
        return "(" + ", ".join(keys) + ")"
    if schema["type"] == "object":
        return f"{_type(schema['additionalProperties'], components)} by name"
    return "null" if schema["type"] == "null" else TYPES[schema["type"]]


_INTRO: Final = """
# The journal

Made by `make docs` from `simulation/events.py`; not written by hand.

`journal.jsonl` of a run directory has one JSON object a line, in order. Each begins with `t` (simulated time, s since
midnight), `who` (the author: a unit, a device, `world`, or a person) and `what` (the event); the keys of the table
follow. Sections, points, routes and tags go by their ids. An optional key is left out where it says nothing.
`simulation.journal.read_journal` gives the lines back as the types of `onboard.notes`, `wayside.said`, `radio.noted`
and `simulation.events`.

Every telegram is `sent` once. It is `lost` if no copy is on its way or its receiver is off; what arrives is dropped by
the receiver's checks (`telegram_dropped`, with why) or takes effect (`took_effect`): the same for block manager,
terminals and units. Source, `epoch` (boot of the source) and `sequence` name a telegram; `telegram-once` holds every
receiver to letting it in once.
"""


if __name__ == "__main__":
    write_page(document, FILE)
