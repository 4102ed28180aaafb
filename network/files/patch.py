"""Patch a line (what-if): take out tracks, set values, add entries, on the data of a line file.

A patch is the table `[line_patch]` of a scenario, carried out in this order:

- `remove_tracks = ["OGN.2"]`: see `network.files.track_removal`;
- `remove_tags = { purpose = "position", near_marks_m = 200.0 }`: tags of that purpose on sections, as near as that
  to a stopping mark of the same alignment;
- `set = { "points.OGN.11.throw_time_s" = 12.0 }`: tables by id, platforms by name, other lists by index
  (`alignments.main.limits[3].speed_kmh`); the value is in the line file's own units;
- `add = { limits = [ { from_km = 3.0, to_km = 3.5, speed_kmh = 25 } ] }`: whole entries; limits, curves and
  coverage go to the first alignment unless the entry names its `alignment`.

The patched data is validated like a line file; what is wrong then is put down to the patch.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import Field

from network.errors import InputError
from network.files.line_file import line_of
from network.files.line_schema import LineFile
from network.files.toml_input import Record, key_path, one_of, parse_table, read_text, validate
from network.files.track_removal import without_track
from network.model import Line

KEY: Final = "line_patch"
EXAMPLE: Final = '"points.OGN.11.throw_time_s" = 12.0'
_TABLES: Final = ("sections", "points", "joints", "stations", "tags")
# Gradients are missing because they always cover the whole alignment: they are set, not added to.
_ON_ALIGNMENT: Final = ("limits", "curves", "coverage")

Data = dict[str, Any]


class _Tags(Record):
    purpose: Literal["arrival", "control_start", "departed", "approach", "position", "portal"]
    near_marks_m: float = Field(gt=0.0)


class _Patch(Record):
    remove_tracks: list[str] = Field(default_factory=list)
    remove_tags: _Tags | None = None
    values: dict[str, Any] = Field(default_factory=dict, alias="set")
    add: dict[str, list[dict[str, Any]]] = Field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Patched:
    """Data being patched; `origins` gives the patch's key for what it wrote, by table (its `id()`) and key.

    An entry added whole has an empty key. Tables are known by identity because sorting moves them.
    """

    file: str
    data: Data
    origins: dict[tuple[int, str], str] = field(default_factory=dict)

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
            expected = f"a patch that leaves the line valid; with this one {error}"
            return InputError(self.file, KEY, None, expected)
        return InputError(self.file, found, error.value, error.expected)


def load_patched_line(path: Path, patch: Mapping[str, Any], patch_file: str) -> Line:
    """The line of a line file with a patch; `patch_file` is the scenario that holds the patch.

    Raises InputError, which names the line file when it is wrong as it stands, else `patch_file`.
    """
    file = str(path)
    data = parse_table(read_text(path), file)
    line_of(validate(data, file, LineFile), file)
    patched, entry = _patched(data, patch, patch_file)
    try:
        return line_of(entry, file)
    except InputError as error:
        raise patched.blame(error) from error


def patch_line_data(data: Mapping[str, Any], patch: Mapping[str, Any], file: str) -> Data:
    """The parsed TOML of a line file with a patch; `data` is left as it is.

    `data` is that of a valid line file; `file` names the patch in errors. The result has a line file's shape;
    what needs the whole line is checked by `network.files.line_file.line_of`. Raises InputError for an unknown
    operation, track, id or key, and for a value of the wrong type.
    """
    return _patched(data, patch, file)[0].data


def _patched(data: Mapping[str, Any], patch: Mapping[str, Any], file: str) -> tuple[_Patched, LineFile]:
    try:
        wanted = validate(patch, file, _Patch)
    except InputError as error:
        raise InputError(file, f"{KEY}.{error.key}", error.value, error.expected) from error
    entry = validate(data, file, LineFile)
    for i, track_id in enumerate(wanted.remove_tracks):
        entry = without_track(entry, track_id, file, f"{KEY}.remove_tracks[{i}]")
    if wanted.remove_tags is not None:
        entry = _without_tags(entry, wanted.remove_tags, file)
    patched = _Patched(file, entry.model_dump(exclude_unset=True, exclude_none=True))
    for path, value in wanted.values.items():
        _set(patched, path, deepcopy(value))
    entry = _validated(patched)
    for table, rows in wanted.add.items():
        for i, row in enumerate(rows):
            _add(patched, table, deepcopy(row), f"{KEY}.add.{table}[{i}]")
    return patched, _validated(patched) if wanted.add else entry


def _without_tags(entry: LineFile, wanted: _Tags, file: str) -> LineFile:
    """The line without those tags; InputError where there is none to take out."""
    axis = {section.id: section.alignment for section in entry.sections}
    marks = [
        (axis.get(track.section), mark_km)
        for station in entry.stations
        for track in station.tracks
        for mark_km in (track.mark_down_km, track.mark_up_km)
        if mark_km is not None
    ]
    reach_km = wanted.near_marks_m / 1000.0
    kept = [
        tag
        for tag in entry.tags
        if tag.purpose != wanted.purpose
        or tag.section is None
        or not any(
            axis.get(tag.section) == alignment and abs(tag.km - mark_km) <= reach_km
            for alignment, mark_km in marks
        )
    ]
    if len(kept) == len(entry.tags):
        expected = f"tags of purpose {wanted.purpose} within {wanted.near_marks_m:g} m of a mark"
        raise InputError(file, f"{KEY}.remove_tags", None, expected)
    return entry.model_copy(update={"tags": kept})


def _validated(patched: _Patched) -> LineFile:
    try:
        return validate(patched.data, patched.file, LineFile)
    except InputError as error:
        raise patched.blame(error) from error


def _set(patched: _Patched, path: str, value: object) -> None:
    """Write one value; the schema, not this, knows which keys a table may have."""
    key = f'{KEY}.set."{path}"'
    if isinstance(value, dict):
        raise InputError(patched.file, key, "a table", f"one whole key in quotes, such as {EXAMPLE}")
    node: Any = patched.data
    rest = path.replace("[", ".").replace("]", "")
    while True:
        step, rest = _step(patched.file, key, node, rest)
        if not rest and isinstance(node, dict):
            node[step] = value
            patched.origins[id(node), str(step)] = key
            return
        node = node[step]


def _step(file: str, key: str, node: object, rest: str) -> tuple[str | int, str]:
    """The key or index of `node` that `rest` begins with, and what remains; a list's entry needs a key of it."""
    if isinstance(node, list):
        names = {_name(item, i): i for i, item in enumerate(node)}
        # Ids may hold dots and begin like one another: the longest that fits is meant.
        fitting = [name for name in names if f"{rest}.".startswith(f"{name}.")]
        if not fitting:
            raise InputError(file, key, rest, one_of(names, rest))
        name = max(fitting, key=len)
        entry = node[names[name]]
        if rest == name or not isinstance(entry, dict):
            expected = f"a key of {name}, {one_of(entry)}" if isinstance(entry, dict) else "the whole list"
            raise InputError(file, key, None, expected)
        return names[name], rest[len(name) + 1 :]
    assert isinstance(node, dict)
    name, _, remains = rest.partition(".")
    if remains and not isinstance(node.get(name), dict | list):
        known = one_of((k for k, v in node.items() if isinstance(v, dict | list)), name)
        raise InputError(file, key, name, f"a table that the line has, {known}, as in {EXAMPLE}")
    return name, remains


def _name(item: object, index: int) -> str:
    """What an entry of a list is called in a key path: its id, its name, or else its index."""
    if isinstance(item, dict):
        for key in ("id", "name"):
            if key in item:
                return str(item[key])
    return str(index)


def _add(patched: _Patched, table: str, row: Data, key: str) -> None:
    """Append one entry to its table; those of an alignment go to their place by kilometrage."""
    if table in _TABLES:
        rows = patched.data.setdefault(table, [])
        rows.append(row)
        patched.origins[id(row), ""] = key
        return
    if table not in _ON_ALIGNMENT:
        raise InputError(patched.file, f"{KEY}.add", table, one_of((*_TABLES, *_ON_ALIGNMENT), table))
    alignments = patched.data["alignments"]
    ids = [alignment["id"] for alignment in alignments]
    name = row.pop("alignment", ids[0])
    if name not in ids:
        raise InputError(patched.file, f"{key}.alignment", name, one_of(ids, str(name)))
    owner = ids.index(name)
    rows = alignments[owner].setdefault(table, [])
    rows.append(row)
    rows.sort(key=_from_km)
    patched.origins[id(row), ""] = key


def _from_km(row: Mapping[str, Any]) -> float:
    """Kilometrage to sort by; one that is missing or no number is for the schema to refuse."""
    from_km = row.get("from_km")
    return from_km if isinstance(from_km, float | int) else math.inf


def _child(node: object, step: str) -> object:
    """What a step of a key path leads to; None where there is nothing."""
    if isinstance(node, dict):
        return node.get(step)
    if isinstance(node, list) and step.isdecimal() and int(step) < len(node):
        return node[int(step)]
    return None


def _suffix(steps: list[str]) -> str:
    """The rest of a key path, to stand behind its beginning."""
    path = key_path(int(step) if step.isdecimal() else step for step in steps)
    return path if path.startswith("[") or not path else f".{path}"
