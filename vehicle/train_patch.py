"""Patch a train (what-if): the tables `[patch.train.<id>]` of a scenario, on the data of a train file.

`set` and `times` as in `network.files.edits`; a key that only one table has may stand without its table
(`mass_empty_t = 80.0`). What is patched is nobody's published figure any more, so its provenance becomes
`assumed: set by <the scenario>`. What is wrong then is put down to the patch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

from network.errors import InputError
from network.files.edits import Change, Data, FilePatch, Patched, PatchInFile, differences, words_of
from vehicle.train_file import TrainType, read_train, train_of


def patched_train(path: Path, patches: Sequence[PatchInFile]) -> tuple[TrainType, Data, tuple[Change, ...]]:
    """The kind of train of a file with patches, one after the other, its tables then, and what the patches changed.

    Raises InputError, which names the train file when it is wrong as it stands, else the file of the patch.
    """
    before = data = read_train(path)
    train = train_of(data, str(path))
    for asked in patches:
        patched = _patched(data, asked)
        data = patched.data
        try:
            train = train_of(data, str(path))
        except InputError as error:
            raise patched.blame(error) from error
    changes = differences(path.name, figures_alone(before), figures_alone(data))
    return train, data, tuple(changes)


def _patched(data: Mapping[str, Any], asked: PatchInFile) -> Patched:
    words = words_of(asked, FilePatch)
    for word, given in (("add", words.add), ("remove", words.remove)):
        if given:
            raise InputError(
                asked.file, f"{asked.key}.{word}", None, "set or times: a train file has no lists"
            )
    full = words.model_copy(
        update={
            "values": {_full(data, path): value for path, value in words.values.items()},
            "times": {_full(data, path): factor for path, factor in words.times.items()},
        }
    )
    patched = Patched(asked.file, asked.key, "train", deepcopy(dict(data)))
    patched.write_all(full)
    provenance = patched.data.setdefault("provenance", {})
    for path in (path for path in (*full.values, *full.times) if "." in path):
        provenance[path] = f"assumed: set by {Path(asked.file).name}"
    return patched


def figures_alone(data: Mapping[str, Any]) -> dict[str, Any]:
    """A train file without where its figures come from."""
    return {key: value for key, value in data.items() if key != "provenance"}


def _full(data: Mapping[str, Any], path: str) -> str:
    """The key path with its table, where it is without and only one table has that key."""
    owners = [table for table, values in data.items() if isinstance(values, dict) and path in values]
    return f"{owners[0]}.{path}" if "." not in path and len(owners) == 1 else path
