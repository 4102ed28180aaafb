"""The words of a patch (what-if) on the data of any input file, and what it changed.

Carried out in this order:

- `remove = { tags = [504, 505] }`: entries of a list, by what they are called;
- `set = { "points.OGN.11.throw_time_s" = 12.0 }`: one value, or a whole list in place of what is there;
- `times = { "trains.323M.calls.*.…" = 1.1 }`: a number, or every number of a list, by a share of itself;
- `add = { tags = [{ … }] }`: whole entries behind those that are there.

Entries of a list are called by their id, name, number, station or stock, else by their index (`limits[3]`), and
`*` is all of them. Values are in the file's own units. What is wrong afterwards is put down to the patch.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, TypeVar

from pydantic import Field

from network.errors import InputError
from network.files.kinds import about
from network.files.toml_input import Record, key_path, one_of, validate
from network.raw import is_list, is_table

EXAMPLE: Final = '"points.OGN.11.throw_time_s" = 12.0'
_CALLED_BY: Final = ("id", "name", "number", "station", "stock")

Data = dict[str, Any]


class FilePatch(Record):
    """What a patch may say of any file; see `network.files.edits`."""

    remove: Annotated[dict[str, list[str | int]], about("entries taken out, by list")] = Field(
        default_factory=dict
    )
    values: Annotated[dict[str, Any], about("values set, or whole lists replaced, by key path")] = Field(
        default_factory=dict, alias="set"
    )
    times: Annotated[dict[str, float], about("numbers multiplied by a factor, by key path")] = Field(
        default_factory=dict
    )
    add: Annotated[dict[str, list[dict[str, Any]]], about("entries added, by list")] = Field(
        default_factory=dict
    )


WordsT = TypeVar("WordsT", bound=FilePatch)


@dataclass(frozen=True, slots=True)
class PatchInFile:
    """A patch and where it stands: the file that holds it and its key there (`patch.line`)."""

    words: Mapping[str, Any]
    file: str
    key: str


class Change(Record):
    """One figure of `file` that is not what the file says; None where it is not there."""

    file: str
    key: str
    old: Any
    new: Any


@dataclass(frozen=True, slots=True)
class Patched:
    """Data being patched; `origins` gives the patch's key for what it wrote, by table (its `id()`) and key.

    An entry added whole has an empty key. Tables are known by identity because sorting moves them.
    """

    file: str
    key: str
    what: str
    data: Data
    origins: dict[tuple[int, str], str] = field(default_factory=dict)

    def remove_all(self, words: FilePatch) -> None:
        """Take out what the words remove."""
        for table, names in words.remove.items():
            for i, name in enumerate(names):
                self.remove(table, str(name), f"{self.key}.remove.{table}[{i}]")

    def write_all(self, words: FilePatch) -> None:
        """Set and multiply; where an entry that is added goes is the file's own business."""
        for path, value in words.values.items():
            self.set_value(path, deepcopy(value))
        for path, factor in words.times.items():
            self.multiply(path, factor)

    def set_value(self, path: str, value: object, key: str = "") -> None:
        """Write one value; the schema, not this, knows which keys a table may have. `key` is the patch's own."""
        key = key or f'{self.key}.set."{path}"'
        if is_table(value):
            raise InputError(self.file, key, "a table", f"one whole key in quotes, such as {EXAMPLE}")
        for node, step in self._places(key, path):
            node[step] = deepcopy(value)
            self.origins[id(node), step] = key

    def multiply(self, path: str, factor: float, key: str = "") -> None:
        """Multiply a number, or every number of a list."""
        key = key or f'{self.key}.times."{path}"'
        for node, step in self._places(key, path):
            old = node.get(step)
            numbers: list[Any] = old if is_list(old) else [old]
            if not numbers or any(isinstance(n, bool) or not isinstance(n, int | float) for n in numbers):
                raise InputError(self.file, key, old, "a number that the file has, to multiply")
            scaled = [_scaled(number, factor) for number in numbers]
            node[step] = scaled if is_list(old) else scaled[0]
            self.origins[id(node), step] = key

    def remove(self, table: str, name: str, key: str) -> None:
        """Take one entry out of a list."""
        for node, step in self._places(key, table):
            rows = node.get(step)
            if not is_list(rows):
                raise InputError(self.file, key, table, f"a list, one of {', '.join(_lists(node))}")
            names = [entry_name(row, i) for i, row in enumerate(rows)]
            if name not in names:
                raise InputError(self.file, key, name, one_of(names, name))
            del rows[names.index(name)]

    def append(self, rows: list[Any], row: Data, key: str) -> None:
        """Put an entry into a list."""
        rows.append(row)
        self.origins[id(row), ""] = key

    def blame(self, error: InputError) -> InputError:
        """An error of the patched data as one of the patch."""
        steps = re.findall(r"[^.\[\]]+", error.key)
        node: Any = self.data
        found = None
        for i, step in enumerate(steps):
            if (id(node), "") in self.origins:
                found = self.origins[id(node), ""] + _suffix(steps[i:])
            if (id(node), step) in self.origins:
                found = self.origins[id(node), step] + _suffix(steps[i + 1 :])
                break
            node = _child(node, step)
        if found is None:
            expected = f"a patch that leaves the {self.what} valid; with this one {error}"
            return InputError(self.file, self.key, None, expected)
        return InputError(self.file, found, error.value, error.expected)

    def _places(self, key: str, path: str) -> list[tuple[Data, str]]:
        """The tables and keys that a path means; several where it has a `*`."""
        ways: list[tuple[Any, str]] = [(self.data, path.replace("[", ".").replace("]", ""))]
        found: list[tuple[Data, str]] = []
        while ways:
            node, rest = ways.pop(0)
            if is_list(node) and rest.startswith("*."):
                ways += [(entry, rest[2:]) for entry in node]
                continue
            step, remains = self._step(key, node, rest)
            if not remains and is_table(node):
                found.append((node, str(step)))
            else:
                ways.append((_child(node, str(step)), remains))
        return found

    def _step(self, key: str, node: object, rest: str) -> tuple[str | int, str]:
        """The key or index of `node` that `rest` begins with, and what remains; an entry needs a key of it."""
        if is_list(node):
            names = {entry_name(item, i): i for i, item in enumerate(node)}
            # Ids may hold dots and begin like one another: the longest that fits is meant.
            fitting = [name for name in names if f"{rest}.".startswith(f"{name}.")]
            if not fitting:
                raise InputError(self.file, key, rest, one_of(names, rest))
            name = max(fitting, key=len)
            entry = node[names[name]]
            if rest == name or not is_table(entry):
                expected = f"a key of {name}, {one_of(entry)}" if is_table(entry) else "the whole list"
                raise InputError(self.file, key, None, expected)
            return names[name], rest[len(name) + 1 :]
        if not is_table(node):
            raise InputError(self.file, key, rest, "the key of a table")
        name, _, remains = rest.partition(".")
        if remains and not isinstance(node.get(name), dict | list):
            known = one_of((k for k, v in node.items() if isinstance(v, dict | list)), name)
            raise InputError(
                self.file, key, name, f"a table that the {self.what} has, {known}, as in {EXAMPLE}"
            )
        return name, remains


def words_of(asked: PatchInFile, model: type[WordsT]) -> WordsT:
    """The words of a patch, checked. Raises InputError that names the patch's key."""
    try:
        return validate(asked.words, asked.file, model)
    except InputError as error:
        raise InputError(asked.file, f"{asked.key}.{error.key}", error.value, error.expected) from error


def entry_name(item: object, index: int) -> str:
    """What an entry of a list is called in a key path: by its id, name, …, or else its index."""
    if is_table(item):
        for key in _CALLED_BY:
            if key in item:
                return str(item[key])
    return str(index)


def differences(file: str, old: object, new: object, path: str = "") -> Iterator[Change]:
    """What differs between two states of a file's data, value by value; entries of lists by what they are called."""
    if old == new:
        return
    if is_table(old) and is_table(new):
        for key in dict.fromkeys((*old, *new)):
            yield from differences(file, old.get(key), new.get(key), f"{path}.{key}" if path else str(key))
    elif is_list(old) and is_list(new) and all(is_table(i) for i in (*old, *new)):
        befores = {entry_name(item, i): item for i, item in enumerate(old)}
        afters = {entry_name(item, i): item for i, item in enumerate(new)}
        named = all(any(key in item for key in _CALLED_BY) for item in (*old, *new))
        if named or len(old) == len(new):
            yield from differences(file, befores, afters, path)
        else:
            yield from (Change(file=file, key=path, old=item, new=None) for item in old if item not in new)
            yield from (Change(file=file, key=path, old=None, new=item) for item in new if item not in old)
    else:
        yield Change(file=file, key=path, old=old, new=new)


def _scaled(number: float, factor: float) -> float:
    """A number times a factor; a whole one stays whole, where it can."""
    found = number * factor
    return int(found) if isinstance(number, int) and found.is_integer() else found


def _lists(node: Data) -> list[str]:
    return [key for key, value in node.items() if is_list(value)] or ["none"]


def _child(node: object, step: str) -> object:
    """What a step of a key path leads to; None where there is nothing."""
    if is_table(node):
        return node.get(step)
    if is_list(node) and step.isdecimal() and int(step) < len(node):
        return node[int(step)]
    return None


def _suffix(steps: list[str]) -> str:
    """The rest of a key path, to stand behind its beginning."""
    path = key_path(int(step) if step.isdecimal() else step for step in steps)
    return path if path.startswith("[") or not path else f".{path}"
