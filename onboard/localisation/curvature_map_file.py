"""The file of a map of curvature: JSON, with a version; what does not fit the line is refused with one InputError.

    {
      "format": "branchline curvature map",
      "version": 1,
      "line": "karasuyama",                       id of the line that it is of
      "made": "train 322M, seed 1",               from what, in words
      "error_m": 0.5,                             how far off its places may be
      "pieces": [
        {"id": "KRS.1", "from_m": 20100.0, "to_m": 20304.0,     as in the line file, kilometrage in m
         "curvature_per_m": [0.0, 1.2e-05, ...]}                mean of each metre from from_m on, to the right going
                                                                DOWN
      ]
    }

A piece has one sample for each metre that it has begun. `error_m` widens every fix by the map. Curvature is that of the
track itself, neither filtered nor seen through a car. Refused are another version or line, and a piece that the line
does not have there, that is too short, has a gap, or has a curve sharper than 10 m.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from network.errors import InputError
from network.files.json_input import read_json, write_aside
from network.files.toml_input import one_of
from network.model import Line
from onboard.localisation.curvature_map import CurvatureMap, PieceCurvature, samples_of

FORMAT: Final = "branchline curvature map"
VERSION: Final = 1
SHARPEST_PER_M: Final = 0.1  # a curve of 10 m: trams have 11
ERROR_MOST_M: Final = 100.0
SAME_PLACE_M: Final = 1e-3
DIGITS: Final = 9  # of a curvature, 1/m


class _Piece(msgspec.Struct):
    """One piece as written."""

    id: str
    from_m: float
    to_m: float
    curvature_per_m: list[Any]


class _File(msgspec.Struct):
    """The file as written."""

    format: str
    version: int
    line: str
    made: str
    error_m: float
    pieces: list[_Piece]


def write_map(of: CurvatureMap, out_file: Path) -> None:
    """Write a map. InputError where the file cannot be written."""
    pieces = [
        {
            "id": piece_id,
            "from_m": piece.from_m,
            "to_m": piece.to_m,
            "curvature_per_m": [round(float(value), DIGITS) for value in piece.curvature_per_m],
        }
        for piece_id, piece in of.pieces.items()
    ]
    head = {"format": FORMAT, "version": VERSION, "line": of.line_id, "made": of.made, "error_m": of.error_m}
    write_aside(out_file, json.dumps(head | {"pieces": pieces}, ensure_ascii=False) + "\n")


def read_map(file: Path, line: Line) -> CurvatureMap:
    """Read the map of a line. InputError for another format, version or line, gaps, and what is too short."""
    data = read_json(file, _File)
    name = str(file)
    for key, value, expected in (
        ("format", data.format, FORMAT),
        ("version", data.version, VERSION),
        ("line", data.line, line.id),
    ):
        if value != expected:
            raise InputError(
                name, key, value, f"{expected!r}" if isinstance(expected, str) else f"{expected}"
            )
    if not 0.0 <= data.error_m <= ERROR_MOST_M:
        raise InputError(name, "error_m", data.error_m, f"0 to {ERROR_MOST_M:g} m")
    if not data.pieces:
        raise InputError(name, "pieces", None, "at least one piece of the line")
    pieces: dict[str, PieceCurvature] = {}
    for index, piece in enumerate(data.pieces):
        if piece.id in pieces:
            raise InputError(name, f"pieces[{index}].id", piece.id, "a piece that the map does not have yet")
        pieces[piece.id] = _piece(name, f"pieces[{index}]", piece, line)
    return CurvatureMap(data.line, pieces, data.error_m, data.made)


def _piece(name: str, key: str, written: _Piece, line: Line) -> PieceCurvature:
    if written.id not in line.pieces:
        raise InputError(
            name, f"{key}.id", written.id, f"a piece of {line.id}: {one_of(sorted(line.pieces), written.id)}"
        )
    piece = line.pieces[written.id]
    for end, value, expected_m in (
        ("from_m", written.from_m, piece.from_m),
        ("to_m", written.to_m, piece.to_m),
    ):
        if not abs(value - expected_m) <= SAME_PLACE_M:
            raise InputError(name, f"{key}.{end}", value, f"{expected_m:g}, as {line.id} has {written.id}")
    count = samples_of(piece.length_m)
    if len(written.curvature_per_m) != count:
        raise InputError(
            name,
            f"{key}.curvature_per_m",
            None,
            f"{count} samples, one for each metre of {written.id}, not {len(written.curvature_per_m)}",
        )
    for at, value in enumerate(written.curvature_per_m):
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (is_number and math.isfinite(value) and abs(value) <= SHARPEST_PER_M):
            expected = (
                f"a curvature of at most {SHARPEST_PER_M:g} 1/m either way; a map has no gaps within a piece"
            )
            raise InputError(name, f"{key}.curvature_per_m[{at}]", value, expected)
    return PieceCurvature(piece.from_m, piece.to_m, np.array(written.curvature_per_m, dtype=np.float64))
