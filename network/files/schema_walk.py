"""Find one's way in the JSON Schema of a settings model: the node of a key, its range and keys in words."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, Final

from pydantic import BaseModel

from network.raw import is_table

Schema = Mapping[str, Any]

_AS_THEY_STAND_MAX: Final = 12


@cache
def json_schema_of(model: type[BaseModel]) -> Schema:
    """JSON Schema of a model, made once a process, as that of a scenario takes 50 ms; who changes it takes a copy."""
    return model.model_json_schema()


def resolved_node(schema: Schema, node: Schema) -> Schema:
    """A node with its reference followed, and the choice that is a table or list where there are several."""
    while True:
        if "$ref" in node:
            own = {key: value for key, value in node.items() if key != "$ref"}
            node = {**schema["$defs"][node["$ref"].rpartition("/")[2]], **own}
        elif "anyOf" in node:
            own = {key: value for key, value in node.items() if key != "anyOf"}
            choices = [choice for choice in node["anyOf"] if choice.get("type") != "null"]
            rich = [choice for choice in choices if "$ref" in choice or "items" in choice]
            node = {**(rich or choices)[0], **own}
        else:
            return node


def node_at(schema: Schema, location: Iterable[int | str]) -> tuple[Schema, tuple[int | str, ...]]:
    """The node that a path of keys and indices leads to, and the path without what is no key or index."""
    node: Schema = resolved_node(schema, schema)
    path: list[int | str] = []
    for part in location:
        if isinstance(part, int):
            node = resolved_node(schema, node.get("items", {}))
        elif part in node.get("properties", {}):
            node = resolved_node(schema, node["properties"][part])
        elif is_table(node.get("additionalProperties")):
            node = resolved_node(schema, node["additionalProperties"])
        elif "properties" in node:
            node = {}
        else:
            continue  # the name of a choice of a union, which no file writes
        path.append(part)
    return node, tuple(path)


def range_text(node: Schema) -> str:
    """Bounds of a number in words, such as `above 0 and at most 1`; empty where there are none."""
    if "oneOf" in node:
        return " or ".join(range_text(choice) for choice in node["oneOf"])
    if {"minimum", "maximum"} <= node.keys():
        low, high = node["minimum"], node["maximum"]
        return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
    words: list[str] = []
    for key, word in (
        ("exclusiveMinimum", "above"),
        ("minimum", "at least"),
        ("exclusiveMaximum", "below"),
        ("maximum", "at most"),
    ):
        if key in node:
            words.append(f"{word} {node[key]:g}")
    return " and ".join(words)


def keys_text(node: Schema, wanted: str) -> str:
    """The keys that a table has, all of them; of many those most like `wanted` first."""
    names = nearest_first(list(node.get("properties", {})), wanted)
    return f"one of {', '.join(names)}" if names else "none at all"


def nearest_first(names: list[str], wanted: str) -> list[str]:
    """Names as they stand; of more than a reader takes in, first those that begin as `wanted` or are most like it."""
    if len(names) <= _AS_THEY_STAND_MAX:
        return names
    begun = [name for name in names if wanted and name.startswith(wanted)]
    near = difflib.get_close_matches(wanted, names, n=5, cutoff=0.3)
    return list(dict.fromkeys([*begun, *near, *names]))
