"""Patch a timetable (what-if): the table `[patch.timetable]` of a scenario, on the data of a timetable file.

Besides the words of `network.files.edits`, behind `remove` and before `set`:

- a train that is removed leaves its diagram too, and a diagram without trains is gone;
- `scale = [{ from = "07:00", to = "09:00", times = 1.1 }]`: running times (departure to the next arrival) that
  begin in those hours, of all trains or of those in `trains`; what follows in the train moves along, dwells stay.

The patched data is validated like a timetable file; what is wrong then is put down to the patch.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from network.clock import clock
from network.errors import InputError
from network.files.edits import Change, Data, FilePatch, Patched, PatchInFile, called, differences, words_of
from network.files.kinds import TimeOfDay, about
from network.files.quantities import Stretch
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import Record, one_of, parse_table, read_text, validate
from network.model import Line
from network.timetable import Timetable, seconds_of, timetable_of

_LISTS = ("trains", "diagrams")


class ScaleTable(Record):
    """`scale`: running times between two hours, by a factor."""

    from_s: Annotated[TimeOfDay, Field(alias="from"), about("runs that begin at this time or later")]
    to_s: Annotated[TimeOfDay, Field(alias="to"), about("and before this time")]
    times: Annotated[Stretch, about("factor of the running time, to whole seconds")]
    trains: Annotated[list[str] | None, about("only these; left out: all")] = None


class TimetablePatch(FilePatch):
    """`[patch.timetable]`."""

    scale: Annotated[list[ScaleTable], about("running times by a factor, between hours")] = Field(
        default_factory=list
    )


def patched_timetable(
    path: Path, line: Line, patches: Sequence[PatchInFile]
) -> tuple[Timetable, Data, tuple[Change, ...]]:
    """The timetable of a file with patches, one after the other, its tables then, and what the patches changed.

    Raises InputError, which names the timetable file when it is wrong as it stands, else the file of the patch.
    """
    file = str(path)
    before = data = parse_table(read_text(path), file)
    timetable = timetable_of(validate(data, file, TimetableFile), file, line)
    for asked in patches:
        patched = _patched(data, asked)
        data = patched.data
        try:
            timetable = timetable_of(validate(data, file, TimetableFile), file, line)
        except InputError as error:
            raise patched.blame(error) from error
    return timetable, data, tuple(differences(path.name, before, data))


def _patched(data: Data, asked: PatchInFile) -> Patched:
    wanted = words_of(asked, TimetablePatch)
    patched = Patched(asked.file, asked.key, "timetable", deepcopy(data))
    patched.remove_all(wanted)
    _leave_diagrams(patched.data, {str(name) for name in wanted.remove.get("trains", ())})
    for i, scale in enumerate(wanted.scale):
        _scale(patched, scale, f"{asked.key}.scale[{i}]")
    patched.write_all(wanted)
    for table, rows in wanted.add.items():
        if table not in _LISTS:
            raise InputError(asked.file, f"{asked.key}.add", table, one_of(_LISTS, table))
        for i, row in enumerate(rows):
            patched.append(patched.data.setdefault(table, []), deepcopy(row), f"{asked.key}.add.{table}[{i}]")
    return patched


def _leave_diagrams(data: Data, gone: set[str]) -> None:
    for diagram in data.get("diagrams", ()):
        diagram["trains"] = [number for number in diagram["trains"] if number not in gone]
    data["diagrams"] = [diagram for diagram in data.get("diagrams", ()) if diagram["trains"]]


def _scale(patched: Patched, scale: ScaleTable, key: str) -> None:
    """Stretch the runs of all trains that are meant; InputError for a train that is not there."""
    trains = {called(train, i): train for i, train in enumerate(patched.data["trains"])}
    for i, number in enumerate(scale.trains or ()):
        if number not in trains:
            raise InputError(patched.file, f"{key}.trains[{i}]", number, one_of(trains, number))
    changed = False
    for number in trains if scale.trains is None else scale.trains:
        changed |= _scale_train(patched, trains[number], scale, key)
    if not changed:
        expected = f"runs that begin from {clock(scale.from_s)} to {clock(scale.to_s)}"
        raise InputError(patched.file, key, None, expected)


def _scale_train(patched: Patched, train: Data, scale: ScaleTable, key: str) -> bool:
    """Whether any run of the train was stretched."""
    moved_s, before_s, changed = 0, None, False
    for call in train["calls"]:
        planned_s = _times_s(patched.file, key, call, before_s)
        first_s = min(planned_s.values())
        if before_s is not None and scale.from_s <= before_s < scale.to_s:
            moved_s += round((first_s - before_s) * (scale.times - 1.0))
            changed = True
        before_s = max(planned_s.values())
        if moved_s:
            for name, time_s in planned_s.items():
                call[name] = clock(time_s + moved_s)
            patched.origins[id(call), ""] = key
    return changed


def _times_s(file: str, key: str, call: dict[str, Any], after_s: int | None) -> dict[str, int]:
    """Times of a call, those that it has, s."""
    found: dict[str, int] = {}
    for name in ("arrival", "departure", "pass"):
        if call.get(name) is not None:
            after_s = found[name] = seconds_of(file, key, call[name], after_s)
    return found
