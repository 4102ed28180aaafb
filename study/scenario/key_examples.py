"""What each key of a file looks like where it stands: one file of each kind with every key, read for schema and page.

`examples/*.toml` beside this module are of the form of their kind, each entry by itself; together they are no scenario.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from importlib.resources import files
from typing import Any, Final

from network.files.raw import is_row, is_table
from network.files.schema_walk import resolved

FOLDER: Final = "scenario/examples"


def example_text(kind: str) -> str:
    """The file of a kind (line, timetable, train, scenario) as it is written."""
    return (files("study") / FOLDER / f"{kind}.toml").read_text("utf-8")


def example_of(kind: str) -> dict[str, Any]:
    """Its tables."""
    return tomllib.loads(example_text(kind))


def with_examples(schema: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """The JSON Schema of a kind with `examples` at every key, in the order of the file."""
    own = deepcopy(dict(schema))
    _put(own, resolved(own, own), (example_of(kind),))
    return own


def child_of(schema: Mapping[str, Any], node: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The table that a key holds, one or many or by name; None for a plain value."""
    field = resolved(schema, node)
    if "properties" in field:
        return field
    below = field.get("items", field.get("additionalProperties"))
    if not is_table(below):
        return None
    child = resolved(schema, below)
    return child if "properties" in child else None


def below(entries: tuple[Mapping[str, Any], ...], key: str) -> Iterator[Mapping[str, Any]]:
    """The tables that some entries have under a key: one, a list of them, or several by name."""
    for entry in entries:
        value = entry.get(key)
        if is_row(value):
            yield from (item for item in value if is_table(item))
        elif is_table(value) and value and all(is_table(item) for item in value.values()):
            yield value
            yield from (item for item in value.values() if is_table(item))
        elif is_table(value):
            yield value


def _put(schema: Mapping[str, Any], node: Mapping[str, Any], entries: tuple[Mapping[str, Any], ...]) -> None:
    for key, own in node["properties"].items():
        child = child_of(schema, own)
        if child is not None:
            _put(schema, child, tuple(below(entries, key)))
        for entry in entries:
            if key in entry and entry[key] not in own.setdefault("examples", []) and child is None:
                own["examples"].append(entry[key])
        if not own.get("examples", True):
            del own["examples"]
