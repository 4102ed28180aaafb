"""Where the reference data that a reproduction reads lies: it belongs to others and is not shipped."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from network.errors import COMMAND_LINE, InputError
from papers.reproduction import Options

VARIABLE: Final = "BRANCHLINE_DATA"
BESIDE: Final = Path(__file__).resolve().parents[1] / "../shared/data"  # of a checked-out project


def reference_folder(options: Options, name: str) -> Path:
    """A folder of the reference data: below `--data`, else below the environment's BRANCHLINE_DATA, else beside it all.

    Raises InputError where it is absent: that experiment cannot be made without.
    """
    chosen = options.data or os.environ.get(VARIABLE)
    folder = Path(chosen) if chosen else BESIDE
    if not (folder / name).is_dir():
        key = VARIABLE if chosen and not options.data else "--data"
        expected = f"a folder that holds the reference data {name!r}, by --data or {VARIABLE}"
        raise InputError(COMMAND_LINE, key, chosen, expected)
    return (folder / name).resolve()
