"""Patch a line (what-if): the table `[patch.line]` of a scenario, on the data of a line file.

Besides the words of `network.files.edits` it knows, before them:

- `remove_tracks = ["OGN.2"]`, `remove_loops = ["OGN"]`: see `network.patching.track_removal`;
- `add_loops = ["NIT"]`: see `network.patching.loop_addition`;
- `remove_tags = { purpose = "position", near_marks_m = 200.0 }`: tags of that purpose on sections, as near as that
  to a stopping mark of the same alignment;

and `add` takes limits, curves and coverage to the first alignment unless the entry names its `alignment`.
The patched data is validated like a line file; what is wrong then is put down to the patch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from network.errors import InputError
from network.files.edits import (
    Change,
    Data,
    FilePatch,
    Patched,
    PatchInFile,
    differences,
    entry_name,
    words_of,
)
from network.files.kinds import about
from network.files.line_file import line_of_tables
from network.files.line_schema import LineFile
from network.files.quantities import PositionBound
from network.files.toml_input import Record, one_of, parse_table, read_text
from network.model import Line
from network.patching.loop_addition import with_loop
from network.patching.track_removal import without_loop, without_track
from network.raw import is_list, is_table

KEY: Final = "patch.line"
_TABLES: Final = tuple(name for name in LineFile.model_fields if name not in ("line", "alignments"))
# Gradients are missing because they always cover the whole alignment: they are set, not added to.
_ON_ALIGNMENT: Final = ("limits", "curves", "coverage", "second_coverage", "tunnels", "obstructed")


class TagsOut(Record):
    """`remove_tags`: which tags to take out."""

    purpose: Annotated[
        Literal["arrival", "control_start", "departed", "approach", "position", "portal"], about("purpose")
    ]
    near_marks_m: Annotated[PositionBound, about("only tags this near to a stopping mark")]


class LinePatch(FilePatch):
    """`[patch.line]`."""

    remove_tracks: Annotated[list[str], about("platform tracks taken out with their points")] = Field(
        default_factory=list
    )
    remove_loops: Annotated[list[str], about("stations that are left with one track")] = Field(
        default_factory=list
    )
    add_loops: Annotated[
        list[str],
        about(
            "halts that get a second track with points, where trains can meet; `A.B`: a signal station in the middle"
            " between two neighbours"
        ),
    ] = Field(default_factory=list)
    remove_tags: Annotated[TagsOut | None, about("tags taken out by purpose")] = None


def patched_line(path: Path, patches: Sequence[PatchInFile]) -> tuple[Line, Data, tuple[Change, ...]]:
    """The line of a line file with patches, one after the other, its tables then, and what the patches changed.

    Raises InputError, which names the line file when it is wrong as it stands, else the file of the patch.
    """
    file = str(path)
    before = data = parse_table(read_text(path), file)
    line = line_of_tables(data, file)
    for asked in patches:
        patched = _patched(data, asked)
        data = patched.data
        try:
            line = line_of_tables(data, file)
        except InputError as error:
            raise patched.blame(error) from error
    return line, data, tuple(differences(path.name, before, data))


def load_patched_line(path: Path, patch: Mapping[str, Any], patch_file: str) -> Line:
    """The line of a line file with one patch, which stands in `patch_file`. Raises InputError."""
    return patched_line(path, [PatchInFile(patch, patch_file, KEY)])[0]


def _patched(data: Mapping[str, Any], asked: PatchInFile) -> Patched:
    """The data with a patch. It may be no line any more, which is found when it is read as one."""
    wanted, file = words_of(asked, LinePatch), asked.file
    patched = Patched(file, asked.key, "line", _by_words(data, wanted, file, asked.key))
    patched.remove_all(wanted)
    patched.write_all(wanted)
    for table, rows in wanted.add.items():
        for i, row in enumerate(rows):
            _add(patched, table, deepcopy(row), f"{asked.key}.add.{table}[{i}]")
    return patched


def _by_words(data: Mapping[str, Any], wanted: LinePatch, file: str, key: str) -> Data:
    """The data of a sound line without the tracks, loops and tags to take out, and with the loops to add."""
    if not (wanted.remove_tracks or wanted.remove_loops or wanted.add_loops or wanted.remove_tags):
        return deepcopy(dict(data))
    entry = LineFile.model_validate(data)
    for i, track_id in enumerate(wanted.remove_tracks):
        entry = without_track(entry, track_id, file, f"{key}.remove_tracks[{i}]")
    for i, station_id in enumerate(wanted.remove_loops):
        entry = without_loop(entry, station_id, file, f"{key}.remove_loops[{i}]")
    for i, station_id in enumerate(wanted.add_loops):
        entry = with_loop(entry, station_id, file, f"{key}.add_loops[{i}]")
    if wanted.remove_tags is not None:
        entry = _without_tags(entry, wanted.remove_tags, file, f"{key}.remove_tags")
    return entry.model_dump(exclude_unset=True, exclude_none=True)


def _without_tags(entry: LineFile, wanted: TagsOut, file: str, key: str) -> LineFile:
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
        raise InputError(file, key, None, expected)
    return entry.model_copy(update={"tags": kept})


def _add(patched: Patched, table: str, row: Data, key: str) -> None:
    """Append one entry to its table; those of an alignment go to their place by kilometrage.

    Where what it goes to has been overwritten by something else, it goes nowhere: the line is refused for that.
    """
    if table in _TABLES:
        rows = patched.data.setdefault(table, [])
        if is_list(rows):
            patched.append(rows, row, key)
        return
    if table not in _ON_ALIGNMENT:
        raise InputError(patched.file, f"{patched.key}.add", table, one_of((*_TABLES, *_ON_ALIGNMENT), table))
    alignments = patched.data.get("alignments")
    owners = {
        entry_name(a, i): a for i, a in enumerate(alignments if is_list(alignments) else ()) if is_table(a)
    }
    name = row.pop("alignment", next(iter(owners), None))
    if owners and not (isinstance(name, str) and name in owners):
        raise InputError(patched.file, f"{key}.alignment", name, one_of(owners, str(name)))
    rows = owners[name].setdefault(table, []) if owners else None
    if is_list(rows):
        patched.append(rows, row, key)
        if all(is_table(one) and isinstance(one.get("from_km"), float | int) for one in rows):
            rows.sort(key=itemgetter("from_km"))
