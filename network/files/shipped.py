"""Lines and timetables that come with the program, found by name."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from network.errors import InputError
from network.files.text_input import existing_file
from network.files.toml_input import one_of


def shipped_line(name: str) -> Path:
    """Line file of a shipped line, or `name` itself when it is an existing .toml file. Raises InputError."""
    return find_file(_folder("lines"), "line", name)


def shipped_timetable(name: str) -> Path:
    """Timetable file of that name, or `name` itself when it is an existing .toml file. Raises InputError."""
    return find_file(_folder("timetables"), "timetable", name)


def shipped_names(folder: str) -> tuple[str, ...]:
    """Names in `lines` or `timetables`, sorted."""
    return tuple(sorted(path.stem for path in _folder(folder).glob("*.toml")))


def _folder(folder: str) -> Path:
    return Path(str(files("network"))) / folder


def find_file(folder: Path, what: str, name: str) -> Path:
    """The file `name`.toml of a folder of shipped ones, or `name` itself when it is an existing .toml file.

    `what` says in the InputError what was looked for.
    """
    given, shipped_file = Path(name), folder / f"{name}.toml"
    if given.suffix != ".toml" and given.name == name and shipped_file.is_file():
        return shipped_file
    shipped = tuple(sorted(path.stem for path in folder.glob("*.toml")))
    if given.suffix == ".toml":
        if existing_file(given):
            return given
        raise InputError(name, "", None, f"an existing file, or a shipped {what}: {one_of(shipped)}")
    raise InputError(name, "", None, f"a .toml file or a shipped {what}: {one_of(shipped, name)}")
