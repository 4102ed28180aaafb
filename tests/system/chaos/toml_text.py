"""Tables as the text of a TOML file: what the cases of this folder are written in, and read again from."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

Table = Mapping[str, Any]


def toml_of(table: Table) -> str:
    """The text of a file: plain values first, then tables, then lists of tables."""
    plain = {k: v for k, v in table.items() if not isinstance(v, Mapping) and not _rows(v)}
    text = _lines(plain)
    for key, value in table.items():
        if isinstance(value, Mapping):
            text += f"\n[{key}]\n{_lines(value)}"
        elif _rows(value):
            text += "".join(f"\n[[{key}]]\n{_lines(row)}" for row in value)
    return text


def _rows(value: object) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(v, Mapping) for v in value)


def _lines(table: Table) -> str:
    return "".join(f"{key} = {_value(value)}\n" for key, value in table.items())


def _key(key: str) -> str:
    return json.dumps(key) if "." in key else key


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(v)}" for key, v in value.items()) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        if _rows(value):
            return "[\n" + "".join(f"  {_value(v)},\n" for v in value) + "]"
        return "[" + ", ".join(map(_value, value)) + "]"
    return json.dumps(value, ensure_ascii=False)
