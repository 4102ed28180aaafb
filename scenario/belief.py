"""What units believe of the line and of their trains where it is not what is so: `[belief]` of a scenario.

`[belief.line]` has the words of a line patch and is laid on the line as it is; `[belief.trains]` names the train file
that the unit of a stock goes by. What is believed has the same pieces as what is so: a unit that believed in another
track layout could not be told where it may go.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Final

from pydantic import Field

from network.errors import InputError
from network.files.edits import PatchInFile
from network.files.kinds import about
from network.files.text_input import existing_file
from network.files.toml_input import Record, one_of
from network.model import Line
from network.networks import has_second, with_first_alone
from network.patching.patch import LinePatch, patched_line
from simulation.setup import Belief
from vehicle.train_file import TrainType, load_train, shipped_train

KEY: Final = "belief"


class BeliefTable(Record):
    """`[belief]`: what on-board units go by where it differs from what is so."""

    line: Annotated[LinePatch | None, about("the line as units assume it, as a patch of the true one")] = None
    trains: Annotated[dict[str, str], about("train file that a unit goes by, by stock id")] = Field(
        default_factory=dict
    )


def belief_of(
    folders: Sequence[Path],
    path: Path,
    table: BeliefTable | None,
    line_file: Path,
    patches: Sequence[PatchInFile],
    line: Line,
    trains: Mapping[str, TrainType],
) -> Belief | None:
    """The belief that a scenario's table gives; `line` and `trains` are what is so, train files lie in `folders`.

    InputError names the key.
    """
    if table is None:
        return None
    believed = line
    if table.line is not None:
        words = table.line.model_dump(by_alias=True, exclude_unset=True)
        believed, _, _ = patched_line(line_file, [*patches, PatchInFile(words, str(path), f"{KEY}.line")])
        believed = believed if has_second(line) else with_first_alone(believed)
        for piece_id in sorted({*line.pieces, *believed.pieces}):
            if line.pieces.get(piece_id) != believed.pieces.get(piece_id):
                expected = "a belief that leaves the track layout as it is"
                raise InputError(str(path), f"{KEY}.line", piece_id, expected)
    return Belief(believed, _trains(folders, path, table.trains, trains))


def _trains(
    folders: Sequence[Path], path: Path, named: Mapping[str, str], trains: Mapping[str, TrainType]
) -> dict[str, TrainType]:
    believed: dict[str, TrainType] = {}
    for stock_id, name in named.items():
        key = f"{KEY}.trains.{stock_id}"
        if stock_id not in trains:
            raise InputError(str(path), key, stock_id, f"a stock id: {one_of(sorted(trains), stock_id)}")
        near = next(filter(existing_file, (folder / name for folder in folders)), None)
        try:
            kind = load_train(near or shipped_train(name))
        except InputError as error:
            raise InputError(str(path), key, name, error.expected) from error
        believed[stock_id] = replace(kind, id=f"{kind.id}, as {stock_id} believes")
    return believed
