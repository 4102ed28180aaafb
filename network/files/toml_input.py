"""Read a TOML file into a pydantic model; whatever is wrong becomes one `InputError` with its key path."""

from __future__ import annotations

import pickle
import tomllib
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any, Final, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from network.errors import InputError
from network.files.schema_walk import json_schema_of, keys_text, nearest_first, node_at, range_text
from network.files.text_input import check_nesting, read_text, too_deep

__all__ = ["Record", "key_path", "one_of", "parse_table", "parse_toml", "read_text", "validate"]

_OUT_OF_RANGE: Final = frozenset(
    {"greater_than", "greater_than_equal", "less_than", "less_than_equal", "finite_number"}
)
# What is counted, in words.
_TOO_SHORT: Final[Mapping[str, tuple[str, str]]] = {
    "too_short": ("entry", "entries"),
    "string_too_short": ("character", "characters"),
}
CHOICES_CHARACTERS_MAX: Final = 16_000  # a day of more than 2000 trains, by number

ModelT = TypeVar("ModelT", bound=BaseModel)


class Record(BaseModel):
    """Base of every table in an input file: no unknown keys, no silent conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)


def parse_toml(text: str, file: str, model: type[ModelT]) -> ModelT:
    """Parse `text` as TOML into `model`; `file` names the source in errors. Raises the first InputError."""
    return validate(parse_table(text, file), file, model)


def parse_table(text: str, file: str) -> dict[str, Any]:
    """Parse `text` as TOML; `file` names the source in the InputError."""
    table: dict[str, Any] = pickle.loads(_parsed(text, file))
    return table


@lru_cache(maxsize=32)
def _parsed(text: str, file: str) -> bytes:
    """What is read again and again, as for each day of a sweep, is parsed once; every reader has tables of its own."""
    try:
        data = tomllib.loads(text)
    except RecursionError as error:
        raise too_deep(file, "", "TOML") from error
    except ValueError as error:  # of tomllib, or of a whole number with more digits than Python reads
        raise InputError(file, "", None, f"valid TOML: {error}") from error
    check_nesting(file, data, "TOML")
    return pickle.dumps(data)


def validate(table: Mapping[str, Any], file: str, model: type[ModelT]) -> ModelT:
    """Check a parsed table against `model`. Raises the first InputError."""
    try:
        return model.model_validate(table)
    except ValidationError as error:
        raise _input_error(file, error.errors(include_url=False)[0], model) from error


def key_path(location: Iterable[int | str]) -> str:
    """Key path as people write it: ("alignments", 0, "curves") is `alignments[0].curves`."""
    path = ""
    for part in location:
        if isinstance(part, int):
            path += f"[{part}]"
        else:
            path += f".{part}" if path else part
    return path


def one_of(known: Iterable[str], wanted: str = "") -> str:
    """`one of a, b, c` for messages: all of them, of many those most like `wanted` first.

    Only what no message can hold is cut: then it says how many more the file has.
    """
    names = nearest_first(list(dict.fromkeys(known)), wanted)
    if not names:
        return "one that is defined, and none is"
    text, count = "", 0
    for name in names:
        if len(text) + len(name) > CHOICES_CHARACTERS_MAX:
            return f"one of {text} and {len(names) - count} more"
        text, count = f"{text}, {name}" if text else name, count + 1
    return f"one of {text}"


def _input_error(file: str, detail: ErrorDetails, model: type[BaseModel]) -> InputError:
    schema = json_schema_of(model)
    node, location = node_at(schema, detail["loc"])
    key, value = key_path(location), detail["input"]
    if detail["type"] == "missing":
        return InputError(file, key, None, "this key, which is missing")
    if detail["type"] == "extra_forbidden":
        known = keys_text(node_at(schema, location[:-1])[0], str(location[-1]))
        return InputError(file, key, value, f"no such key, but {known}")
    if detail["type"] == "too_long":
        ends = detail.get("ctx", {})
        return InputError(
            file, key, None, f"at most {ends.get('max_length')} entries, not {ends.get('actual_length')}"
        )
    if detail["type"] in _TOO_SHORT:
        ends = detail.get("ctx", {})
        one, many = _TOO_SHORT[detail["type"]]
        least, has = ends.get("min_length"), ends.get("actual_length", 0)
        return InputError(file, key, None, f"at least {least} {one if least == 1 else many}, not {has}")
    if detail["type"] in _OUT_OF_RANGE:
        what = "an integer" if node.get("type") == "integer" else "a number"
        what = "a finite number" if detail["type"] == "finite_number" else what
        return InputError(file, key, value, f"{what} {range_text(node)}".rstrip())
    expected = detail["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
    if detail["type"] == "string_type" and hasattr(value, "isoformat"):  # a date or a time
        value, expected = str(value), f'"{value}", in quotes'
    return InputError(file, key, "a table" if isinstance(value, dict) else value, expected)
