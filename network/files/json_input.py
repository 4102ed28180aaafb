"""Read foreign JSON and YAML into typed structs, and write files whole or not at all; faults become `InputError`."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TypeVar

import msgspec

from network.errors import COMMAND_LINE, InputError
from network.files.text_input import JSON_BYTES_MAX, check_nesting, existing_file, read_text, too_deep

_T = TypeVar("_T")


def read_json(file: Path, kind: type[_T]) -> _T:
    """Decode a JSON file into `kind` (keys it does not name are left out). Raises InputError."""
    return _decoded(file, "JSON", lambda text: msgspec.json.decode(text, type=kind))


def read_yaml(file: Path, kind: type[_T]) -> _T:
    """Decode a YAML file likewise. Raises InputError."""
    return _decoded(file, "YAML", lambda text: msgspec.yaml.decode(text, type=kind))


def _decoded(file: Path, form: str, decode: Callable[[str], _T]) -> _T:
    text = read_text(file, JSON_BYTES_MAX)
    try:
        data = decode(text)
    except RecursionError as error:
        raise too_deep(str(file), "", form) from error
    except msgspec.ValidationError as error:
        reason, _, place = str(error).partition(" - at `")
        raise InputError(
            str(file), place.rstrip("`").removeprefix("$."), None, f"other data: {reason}"
        ) from error
    except msgspec.DecodeError as error:
        raise InputError(str(file), "", None, f"valid {form}: {error}") from error
    check_nesting(str(file), data, form)
    return data


def check_free(out_file: Path, option: str = "OUT") -> None:
    """Of a file that is made to be edited: InputError where something stands already."""
    if os.path.lexists(out_file):
        raise InputError(COMMAND_LINE, option, str(out_file), "a new file: this one exists already")


def check_place(out_file: Path, option: str = "OUT") -> None:
    """Of a file that is written once all is computed: InputError, before that, where it could not be."""
    folder = out_file.parent
    if out_file.is_dir() or not (folder.is_dir() and os.access(folder, os.W_OK)):
        raise InputError(COMMAND_LINE, option, str(out_file), "a file in a folder that can be written")


def write_aside(out_file: Path, text: str) -> None:
    """Write a file under another name, then rename it. Raises InputError where it cannot be written."""
    write_bytes_aside(out_file, text.encode("utf-8"))


def write_bytes_aside(out_file: Path, data: bytes, begins: bytes = b"") -> None:
    """The same for what is no text in UTF-8; of a file that is there, only one that begins so is replaced."""
    with writing_aside(out_file, begins) as stream:
        stream.write(data)


@contextmanager
def writing_aside(out_file: Path, begins: bytes = b"") -> Generator[IO[bytes]]:
    """The same for what is written bit by bit."""
    try:
        aside = out_file.with_name(out_file.name + ".part")
    except ValueError as error:
        raise InputError(str(out_file), "", None, "the name of a file") from error
    try:
        if existing_file(out_file):
            with out_file.open("rb") as there:
                own = there.read(len(begins))
            if own and own != begins:
                raise InputError(str(out_file), "", None, "a new file, or one of the same kind to replace")
        try:
            with aside.open("wb") as stream:
                yield stream
            aside.replace(out_file)
        except BaseException:
            with suppress(OSError):
                aside.unlink()
            raise
    except OSError as error:
        raise InputError(str(out_file), "", None, f"a writable path ({error.strerror})") from error
