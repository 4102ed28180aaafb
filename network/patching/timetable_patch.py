"""Patch a timetable (what-if): the table `[patch.timetable]` of a scenario, on the data of a timetable file.

Besides the words of `network.files.edits`, behind `remove` and before `set`:

- a train that is removed leaves its diagram too, and a diagram without trains is gone;
- `like = [{ number = "335M", train = "331M", later_s = 7200, stock = "V9" }]`: a train like one that there is,
  with all its times so much later, run by a set of its own; `begins` and `ends` where that train's name another train;
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
from network.files.kinds import TimeOfDay, about
from network.files.names import Identifier
from network.files.quantities import Later, Stretch
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import Record, one_of, parse_table, read_text, validate
from network.model import Line
from network.timetable import Timetable, put_days, seconds_of, time_text, timetable_of

_LISTS = ("trains", "diagrams")


class ScaleTable(Record):
    """`scale`: running times between two hours, by a factor."""

    from_s: Annotated[TimeOfDay, Field(alias="from"), about("runs that begin at this time or later")]
    to_s: Annotated[TimeOfDay, Field(alias="to"), about("and before this time")]
    times: Annotated[Stretch, about("factor of the running time, to whole seconds")]
    trains: Annotated[list[str] | None, about("only these; left out: all")] = None


class LikeTable(Record):
    """`like`: a train like another one, at another time, with a set of its own."""

    number: Annotated[Identifier, about("number of the new train")]
    train: Annotated[str, about("number of the train that it is like")]
    later_s: Annotated[Later, about("how much later, s; below 0: earlier")]
    stock: Annotated[Identifier, about("the set that runs it")]
    begins: Annotated[str | None, about("how it begins; left out: as the other train")] = None
    ends: Annotated[str | None, about("how it ends; left out: as the other train")] = None


class TimetablePatch(FilePatch):
    """`[patch.timetable]`."""

    like: Annotated[list[LikeTable], about("trains like others, at other times")] = Field(
        default_factory=list
    )

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
    put_days(data["trains"], timetable)
    for asked in patches:
        patched = _patched(data, asked)
        data = patched.data
        try:
            timetable = timetable_of(validate(data, file, TimetableFile), file, line)
        except InputError as error:
            raise patched.blame(error) from error
        put_days(data["trains"], timetable)
    return timetable, data, tuple(differences(path.name, before, data))


def _patched(data: Data, asked: PatchInFile) -> Patched:
    wanted = words_of(asked, TimetablePatch)
    patched = Patched(asked.file, asked.key, "timetable", deepcopy(data))
    patched.remove_all(wanted)
    _leave_diagrams(patched.data, {str(name) for name in wanted.remove.get("trains", ())})
    for i, like in enumerate(wanted.like):
        _add_like(patched, like, f"{asked.key}.like[{i}]")
    for i, scale in enumerate(wanted.scale):
        _scale(patched, scale, f"{asked.key}.scale[{i}]")
    patched.write_all(wanted)
    for table, rows in wanted.add.items():
        if table not in _LISTS:
            raise InputError(asked.file, f"{asked.key}.add", table, one_of(_LISTS, table))
        for i, row in enumerate(rows):
            patched.append(patched.data.setdefault(table, []), deepcopy(row), f"{asked.key}.add.{table}[{i}]")
    return patched


def _add_like(patched: Patched, like: LikeTable, key: str) -> None:
    """Append the train and its set; InputError for one that is not there or begins (ends) as another train."""
    trains = {entry_name(train, i): train for i, train in enumerate(patched.data["trains"])}
    if like.train not in trains:
        raise InputError(patched.file, f"{key}.train", like.train, one_of(trains, like.train))
    train = deepcopy(trains[like.train])
    before_s: int | None = None
    written_s = 0
    for call in train["calls"]:
        planned_s = _times_s(patched.file, key, call, before_s)
        before_s = max(planned_s.values())
        for name, time_s in planned_s.items():
            if time_s + like.later_s < 0:
                expected = f"times after midnight; {like.train} would be at {call['station']} before it"
                raise InputError(patched.file, f"{key}.later_s", like.later_s, expected)
            call[name] = time_text(time_s + like.later_s, written_s)
            written_s = time_s + like.later_s
    train["number"] = like.number
    for what, given in (("begins", like.begins), ("ends", like.ends)):
        train[what] = train[what] if given is None else given
        if train[what].startswith(("from:", "becomes:")):
            expected = (
                f"stabled or a portal: {like.train} has {train[what]}, and the new train a set of its own"
            )
            raise InputError(patched.file, f"{key}.{what}", given, expected)
    patched.append(patched.data["trains"], train, key)
    row = {"stock": like.stock, "trains": [like.number]}
    patched.append(patched.data.setdefault("diagrams", []), row, key)


def _leave_diagrams(data: Data, gone: set[str]) -> None:
    for diagram in data.get("diagrams", ()):
        diagram["trains"] = [number for number in diagram["trains"] if number not in gone]
    data["diagrams"] = [diagram for diagram in data.get("diagrams", ()) if diagram["trains"]]


def _scale(patched: Patched, scale: ScaleTable, key: str) -> None:
    """Stretch the runs of all trains that are meant; InputError for a train that is not there."""
    trains = {entry_name(train, i): train for i, train in enumerate(patched.data["trains"])}
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
        written_s = moved_s + (before_s or 0)
        planned_s = _times_s(patched.file, key, call, before_s)
        first_s = min(planned_s.values())
        if before_s is not None and scale.from_s <= before_s < scale.to_s:
            moved_s += round((first_s - before_s) * (scale.times - 1.0))
            changed = True
        before_s = max(planned_s.values())
        if moved_s:
            for name, time_s in planned_s.items():
                call[name] = time_text(time_s + moved_s, written_s)
            patched.origins[id(call), ""] = key
    return changed


def _times_s(file: str, key: str, call: dict[str, Any], after_s: int | None) -> dict[str, int]:
    """Times of a call, those that it has, s."""
    found: dict[str, int] = {}
    for name in ("arrival", "departure", "pass"):
        if call.get(name) is not None:
            after_s = found[name] = seconds_of(file, key, call[name], after_s)
    return found
