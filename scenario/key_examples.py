"""What each key of a file looks like where it stands, for schema and page: its default, or what a file of examples has.

`examples/*.toml` beside this module are of the form of their kind, each entry by itself; together they are no scenario.
They have the keys whose default, if there is one, does not show what the key may say.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from importlib.resources import files
from typing import Any, Final

from network.files.schema_walk import resolved_node
from network.raw import is_row, is_table

FOLDER: Final = "examples"


def written_example(kind: str) -> dict[str, Any]:
    """The tables of the file of examples of a kind."""
    return tomllib.loads((files("scenario") / FOLDER / f"{kind}.toml").read_text("utf-8"))


def filled_example(schema: Mapping[str, Any], example: Mapping[str, Any]) -> dict[str, Any]:
    """An example in which each plain key of a single table that it leaves out has its default, where it has one."""
    own = deepcopy(dict(example))
    _fill(schema, resolved_node(schema, schema), own)
    return own


def _fill(schema: Mapping[str, Any], node: Mapping[str, Any], own: dict[str, Any]) -> None:
    for key, field in node["properties"].items():
        table = resolved_node(schema, field)
        if "properties" in table:
            if key in own or not table.get("required"):
                _fill(schema, table, own.setdefault(key, {}))
            elif field.get("default"):
                own[key] = field["default"]
        elif field.get("default") not in (None, [], {}):
            own.setdefault(key, field["default"])


def with_examples(schema: Mapping[str, Any], example: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON Schema with `examples` at every key that an example of the file has, in the order of the file."""
    own = deepcopy(dict(schema))
    _put(own, resolved_node(own, own), (example,))
    return own


def child_of(schema: Mapping[str, Any], node: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The table that a key holds, one or many or by name; None for a plain value."""
    field = resolved_node(schema, node)
    if "properties" in field:
        return field
    below = field.get("items", field.get("additionalProperties"))
    if not is_table(below):
        return None
    child = resolved_node(schema, below)
    return child if "properties" in child else None


def tables_below(entries: tuple[Mapping[str, Any], ...], key: str) -> Iterator[Mapping[str, Any]]:
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
            _put(schema, child, tuple(tables_below(entries, key)))
        for entry in entries:
            if key in entry and entry[key] not in own.setdefault("examples", []) and child is None:
                own["examples"].append(entry[key])
        if not own.get("examples", True):
            del own["examples"]
