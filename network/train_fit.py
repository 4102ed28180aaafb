"""Whether a train fits where it calls: between the points of a track, or along the platform of a halt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from network.errors import InputError
from network.files.toml_input import one_of
from network.model import Direction, Line, PlatformTrack
from network.timetable import Timetable, platform_of

TRACK_MARGIN_M: Final = (
    5.0  # between a standing train's rear and the section's end; assumed, for the stop error
)


def validate_train_fits(
    line: Line, stock_length_m: Mapping[str, float], timetable: Timetable, file: str
) -> None:
    """Check that each train fits wherever it calls; `stock_length_m` is by the stock ids of the diagrams.

    On a platform track the train must clear the rear end of its section by `TRACK_MARGIN_M` when its front
    is at the mark, or it would stand on the points; at a halt it must not be longer than the platform.
    Raises InputError naming track, usable length and train length, or a stock of unknown length.
    """
    for i, diagram in enumerate(timetable.diagrams):
        if diagram.stock_id not in stock_length_m:
            raise InputError(file, f"diagrams[{i}].stock", diagram.stock_id, one_of(stock_length_m))
        length_m = stock_length_m[diagram.stock_id]
        for number in diagram.train_numbers:
            train = timetable.trains[number]
            for call in train.calls:
                if not call.stops:
                    continue
                platform = platform_of(line, call, train.direction)
                usable_m = usable_length_m(line, platform, train.direction)
                if length_m > usable_m:
                    where = f"train {number} at {call.station_id} track {platform.name}: length"
                    expected = f"at most {usable_m:.1f} m, what track {platform.name} can hold"
                    raise InputError(file, where, f"{length_m:.1f} m", expected)


def usable_length_m(line: Line, platform: PlatformTrack, direction: Direction) -> float:
    """Longest train (m) that can call at `platform` in `direction`, see `validate_train_fits`."""
    if line.stations[platform.station_id].is_halt and platform.platform_m is not None:
        low_m, high_m = platform.platform_m
        return high_m - low_m
    piece = line.pieces[platform.piece_id]
    mark_m = platform.marks_m[direction]
    behind_m = mark_m - piece.from_m if direction is Direction.DOWN else piece.to_m - mark_m
    return behind_m - TRACK_MARGIN_M
