"""Values and tables as the text of a TOML file, as a person could have written it."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any, Final

from network.errors import InputError
from network.raw import is_row, is_table

_BARE: Final = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")


def steps_of(key: str, file: str, where: str) -> tuple[str, ...]:
    """The keys of a key path as TOML writes it: `patch.line.set."points.*.throw_time_s"`. InputError."""
    expected = 'a key path as TOML writes it, such as patch.line.set."points.*.throw_time_s"'
    try:
        node: object = tomllib.loads(f"{key} = 0")
    except ValueError as error:
        raise InputError(file, where, key, expected) from error
    steps: list[str] = []
    while is_table(node) and len(node) == 1:
        (step,) = node
        steps.append(step)
        node = node[step]
    if node != 0 or not steps:
        raise InputError(file, where, key, expected)
    return tuple(steps)


def put_value(tables: dict[str, Any], steps: Sequence[str], value: object) -> None:
    """Lay a value over what the tables have at a key path; tables key by key, all else in place of what is there."""
    node = tables
    for step in steps[:-1]:
        below = node.get(step)
        node[step] = node = dict(below) if is_table(below) else {}
    last = steps[-1]
    old = node.get(last)
    if is_table(value) and is_table(old):
        merged = dict(old)
        node[last] = merged
        for key, item in value.items():
            put_value(merged, (key,), item)
    else:
        node[last] = deepcopy(value)


def text_toml(text: str) -> str:
    """A basic string of TOML: that of JSON, with the one control character escaped that JSON lets stand."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_of(tables: Mapping[str, Any]) -> str:
    """The text of a file: plain values first, then tables under their headings."""
    return "\n".join(_lines(tables, ())) + "\n"


def value_text(value: object) -> str:
    """A value as TOML writes it in a line."""
    if is_table(value):
        items = ", ".join(f"{_key(key)} = {value_text(item)}" for key, item in value.items())
        return f"{{ {items} }}" if items else "{}"
    if is_row(value):
        return f"[{', '.join(map(value_text, value))}]"
    if isinstance(value, str):
        return text_toml(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _lines(tables: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    lines = [f"{_key(key)} = {value_text(item)}" for key, item in tables.items() if not is_table(item)]
    if path and (lines or not tables):
        lines = ["", f"[{'.'.join(map(_key, path))}]", *lines]
    for key, item in tables.items():
        if is_table(item):
            lines += _lines(item, (*path, key))
    return lines


def _key(key: str) -> str:
    return key if key and set(key) <= _BARE else text_toml(key)
