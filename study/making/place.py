"""Where a new file goes: a new path, whose name is the id of what is in it."""

from __future__ import annotations

import os
from pathlib import Path

from network.errors import COMMAND_LINE, InputError
from network.files.json_input import check_free, write_aside
from network.files.names import IDENTIFIER_HELP, is_identifier
from network.files.text_input import existing_file


def checked_new(out: Path, option: str = "OUT") -> str:
    """The id of a file to be made. InputError for a name that gives none, and where something stands already."""
    if out.suffix != ".toml" or not is_identifier(out.stem):
        raise InputError(COMMAND_LINE, option, str(out), f"NAME.toml; NAME: {IDENTIFIER_HELP}")
    if not out.parent.is_dir():
        raise InputError(COMMAND_LINE, option, str(out), "a path in an existing folder")
    check_free(out, option)
    return out.stem


def named_from(out: Path, name: str) -> str:
    """How a file at `out` names another: a shipped one as it is, a path relative to its own folder."""
    if name.endswith(".toml") and existing_file(Path(name)):
        return Path(os.path.relpath(Path(name).resolve(), out.parent.resolve())).as_posix()
    return name


def extended_by(out: Path, scenario: str, option: str = "OUT") -> str:
    """How a new scenario at `out` names the one that it extends. InputError where it would be that one itself."""
    base = named_from(out, scenario)
    if base in {out.stem, out.name}:
        raise InputError(COMMAND_LINE, option, str(out), "another name than that of the scenario")
    checked_new(out, option)
    return base


def write_new(out: Path, text: str) -> None:
    """Write it whole or not at all; InputError."""
    write_aside(out, text)
