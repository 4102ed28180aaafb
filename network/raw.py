"""What TOML and JSON hold before a schema has read them: tables and lists of anything."""

from __future__ import annotations

from typing import Any

from typing_extensions import TypeIs


def is_table(value: object) -> TypeIs[dict[str, Any]]:
    """Whether a value of a file is a table; keys of TOML and JSON are text."""
    return isinstance(value, dict)


def is_list(value: object) -> TypeIs[list[Any]]:
    """Whether a value of a file is a list."""
    return isinstance(value, list)


def is_row(value: object) -> TypeIs[list[Any] | tuple[Any, ...]]:
    """Whether a value is a list, as a file has it or as a record keeps it."""
    return isinstance(value, list | tuple)
