"""What units believe of the line and of their trains where it is not what is so: `[belief]` of a scenario.

The words of `[line_patch]` (set, add, remove_tags), laid on the line as it is, and `trains = { K1 = "some_train" }`,
the train file that the unit of a stock goes by. What is believed has the same pieces as what is so: a unit that
believed in another track layout could not be told where it may go.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from network.errors import InputError
from network.files.line_file import line_of
from network.files.line_schema import LineFile
from network.files.patch import KEY as LINE_PATCH
from network.files.patch import patch_line_data
from network.files.toml_input import one_of, parse_table, read_text, validate
from network.model import Line
from simulation.setup import Belief
from vehicle.train_file import TrainType, load_train, shipped_train

KEY: Final = "belief"
TRAINS: Final = "trains"


def belief_of(
    file: str, line_file: Path, line: Line, line_patch: Mapping[str, Any], table: Mapping[str, Any]
) -> Belief:
    """The belief that a scenario's table gives, `line` being what is so. InputError names the key in `file`."""
    words = {key: value for key, value in table.items() if key != TRAINS}
    believed = _believed_line(file, line_file, line_patch, words) if words else line
    for piece_id in sorted({*line.pieces, *believed.pieces}):
        if line.pieces.get(piece_id) != believed.pieces.get(piece_id):
            raise InputError(file, KEY, piece_id, "a belief that leaves the track layout as it is")
    return Belief(believed)


def _believed_line(file: str, path: Path, line_patch: Mapping[str, Any], words: Mapping[str, Any]) -> Line:
    data: Mapping[str, Any] = parse_table(read_text(path), str(path))
    if line_patch:
        data = patch_line_data(data, line_patch, file)
    try:
        return line_of(validate(patch_line_data(data, words, file), file, LineFile), file)
    except InputError as error:
        key = f"{KEY}.{error.key.removeprefix(LINE_PATCH + '.')}"
        raise InputError(file, key, error.value, error.expected) from error


def with_trains(file: str, belief: Belief, named: object, trains: Mapping[str, TrainType]) -> Belief:
    """The belief with the train files that units go by; `trains` are the trains as they are."""
    if not isinstance(named, dict):
        raise InputError(file, f"{KEY}.{TRAINS}", named, "a table: stock id = train file")
    believed = {}
    for stock_id, name in named.items():
        key = f"{KEY}.{TRAINS}.{stock_id}"
        if stock_id not in trains:
            raise InputError(file, key, stock_id, f"a stock id: {one_of(sorted(trains), stock_id)}")
        near = Path(file).parent / str(name)
        try:
            kind = load_train(near if near.is_file() else shipped_train(str(name)))
        except InputError as error:
            raise InputError(file, key, name, error.expected) from error
        believed[stock_id] = replace(kind, id=f"{kind.id}, as {stock_id} believes")
    return replace(belief, trains=believed)
