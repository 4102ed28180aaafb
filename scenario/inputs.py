"""What a run was made from, as the tables of its files after all patches: enough to read its inputs back.

A run directory keeps it, so that it says what was run when the files have long been changed.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from network.errors import InputError
from network.files.edits import Change
from network.files.json_input import read_json
from network.files.toml_input import Record, one_of, validate
from network.raw import is_table

FORMAT: Final = 1  # of the file; another number is of another version of the program


class Inputs(Record):
    """The tables of a run: scenario (without `extends` and `patch`), line, timetable, trains by their names.

    They have the keys and units of the files that they are from. `stock` gives the name of the train of each stock id,
    `learned` what each knew of its brakes when the run began. `changes` is what patches have changed, `assumed` every
    assumption. All of it is what JSON can hold.
    """

    format: int = FORMAT
    scenario: dict[str, Any]
    line: dict[str, Any]
    timetable: dict[str, Any]
    trains: dict[str, dict[str, Any]]
    stock: dict[str, str]
    learned: dict[str, dict[str, Any]]
    changes: list[Change]
    assumed: list[str]

    def as_json(self) -> str:
        """The file's text."""
        tables = self.model_dump()
        return json.dumps(tables, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def read_inputs(path: Path) -> Inputs:
    """What `Inputs.as_json` wrote. Raises InputError for anything else; what the tables say is not checked here."""
    file, data = str(path), read_json(path, object)
    if not is_table(data) or "format" not in data:
        raise InputError(file, "", None, "the inputs of a run")
    if data["format"] != FORMAT:
        expected = f"{FORMAT}, the format of this version of branchline: run the scenario again"
        raise InputError(file, "format", data["format"], expected)
    read = validate(data, file, Inputs)
    for stock_id, name in read.stock.items():
        if name not in read.trains:
            raise InputError(file, f"stock.{stock_id}", name, one_of(read.trains, name))
    return read
