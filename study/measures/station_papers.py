"""A station's papers from the table of stops: track occupation (番線) and station timetable (駅時刻表).

Both are tables (polars), one row a fact, times in s since midnight, null where nothing was planned or nothing came;
`.to_dicts()` is JSON. Planned and as run stand side by side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import polars as pl

from network.model import Line
from network.timetable import FromTrain, Timetable, TimetableTrain
from study.measures.missing import missing_calls

TRACK_OCCUPATION: Final[Mapping[str, type[pl.DataType]]] = {
    "station": pl.String,
    "track": pl.String,
    "unit": pl.String,
    "train": pl.String,  # that came, or begins here
    "next_train": pl.String,  # that goes on: another one where the stock turns back or changes its number
    "kind": pl.String,  # network.timetable.CallKind
    "planned_from_s": pl.Float64,  # null: begins here, or no arrival is planned
    "planned_to_s": pl.Float64,  # null: ends here
    "from_s": pl.Float64,
    "to_s": pl.Float64,
}
STATION_TIMETABLE: Final[Mapping[str, type[pl.DataType]]] = {
    "station": pl.String,
    "direction": pl.String,  # "down" or "up"
    "train": pl.String,
    "unit": pl.String,
    "revenue": pl.Boolean,
    "kind": pl.String,  # network.timetable.CallKind
    "track": pl.String,
    "origin": pl.String,  # station of its first call
    "destination": pl.String,  # station of its last call
    "planned_arrival_s": pl.Float64,
    "planned_departure_s": pl.Float64,
    "arrival_s": pl.Float64,
    "departure_s": pl.Float64,
}
MOVES_S: Final = 1.0  # a departure is booked when the train has moved
Row = Mapping[str, Any]


def track_occupation(
    stops: pl.DataFrame, line: Line, timetable: Timetable, waits: pl.DataFrame | None = None
) -> pl.DataFrame:
    """TRACK_OCCUPATION: one row a stay at a station, or a passing; by station along the line, track and time.

    A stock that ends as one train and begins as the next in the same place has one row, from the arrival of the one to
    the departure of the other. `stops` and `waits` are tables of a run; the latter tells when stock stood here that no
    call says (stabled, broken down, or before it goes on by a portal), else that is null.
    """
    stands = {} if waits is None else _stands(waits)
    stops = pl.concat([stops, missing_calls(stops, timetable)])
    rows = [_stay(stay, stands.get(stay[0]["unit"], [])) for stay in _stays(stops, timetable)]
    only = {
        station.id: station.tracks[0].name for station in line.stations.values() if len(station.tracks) == 1
    }
    frame = pl.DataFrame(rows, schema=TRACK_OCCUPATION, orient="row").with_columns(
        pl.coalesce("track", pl.col("station").replace_strict(only, default=None, return_dtype=pl.String))
    )
    known_s = pl.coalesce("planned_from_s", "from_s", "planned_to_s", "to_s")
    return _along(frame, line).sort("at", "track", known_s, maintain_order=True).drop("at")


def station_timetable(
    stops: pl.DataFrame, line: Line, timetable: Timetable, end_s: float = math.inf
) -> pl.DataFrame:
    """STATION_TIMETABLE: one row a call; by station along the line, direction (down first) and planned time.

    `stops` is the table of a run; calls that nobody came to have no times as run, those planned after `end_s` no row.
    """
    rows: list[dict[str, Any]] = []
    for row in pl.concat([stops, missing_calls(stops, timetable, end_s)]).iter_rows(named=True):
        train = timetable.trains.get(row["train"])
        if train is None:
            continue
        own = {
            "direction": train.direction.name.lower(),
            "origin": train.calls[0].station_id,
            "destination": train.calls[-1].station_id,
        }
        if row["station"] == own["destination"] and train.due_calls[-1].departure_s is None:
            row["planned_departure_s"] = None
        rows.append({name: own.get(name, row.get(name)) for name in STATION_TIMETABLE})
    frame = pl.DataFrame(rows, schema=STATION_TIMETABLE, orient="row")
    due_s = pl.coalesce("planned_departure_s", "planned_arrival_s", "departure_s", "arrival_s")
    return _along(frame, line).sort("at", "direction", due_s, maintain_order=True).drop("at")


def _along(frame: pl.DataFrame, line: Line) -> pl.DataFrame:
    """With the kilometrage of the station as `at`."""
    at_m = {station.id: station.position_m for station in line.stations.values()}
    return frame.with_columns(pl.col("station").replace_strict(at_m, default=None).alias("at"))


def _stays(stops: pl.DataFrame, timetable: Timetable) -> Iterator[tuple[Row, Row]]:
    """First and last row of each stay: the same one but where one train of a stock becomes the next."""
    for part in stops.partition_by("unit", maintain_order=True):
        rows = list(part.iter_rows(named=True))
        joined = False
        for row, following in zip(rows, [*rows[1:], None], strict=True):
            if joined:
                joined = False
                continue
            joined = following is not None and _goes_on(row, following, timetable.trains)
            yield row, following if joined and following is not None else row


def _goes_on(row: Row, following: Row, trains: Mapping[str, TimetableTrain]) -> bool:
    """Whether a stock begins its next train where it has ended the one before."""
    after = trains.get(following["train"])
    same_place = row["station"] == following["station"] and row["train"] != following["train"]
    return same_place and after is not None and isinstance(after.begins, FromTrain)


def _stands(waits: pl.DataFrame) -> dict[str, list[tuple[str, float, float]]]:
    """(station, from, to) of every stand at a station, by stock: its waits there, one after the other."""
    found: dict[str, list[tuple[str, float, float]]] = {}
    for unit, place, from_s, to_s in waits.select("unit", "place", "from_s", "to_s").iter_rows():
        stands = found.setdefault(unit, [])
        if stands and place and stands[-1][0] == place and stands[-1][2] == from_s:
            stands[-1] = (place, stands[-1][1], to_s)
        elif place:
            stands.append((place, from_s, to_s))
    return found


def _stay(stay: tuple[Row, Row], stands: list[tuple[str, float, float]]) -> dict[str, Any]:
    first, last = stay
    passes = first["kind"] == "pass"
    begins = "departure" if passes else "arrival"
    from_s, to_s = first[f"{begins}_s"], last["departure_s"]
    known_s = from_s if from_s is not None else to_s
    stood = (
        (began_s, ended_s)
        for station, began_s, ended_s in stands
        if known_s is not None and station == first["station"] and began_s <= known_s <= ended_s + MOVES_S
    )
    began_s, ended_s = (None, None) if passes else next(stood, (None, None))
    return {
        "station": first["station"],
        "track": first["track"],
        "unit": first["unit"],
        "train": first["train"],
        "next_train": last["train"],
        "kind": first["kind"],
        "planned_from_s": first[f"planned_{begins}_s"],
        "planned_to_s": last["planned_departure_s"],
        "from_s": began_s if from_s is None else from_s,
        "to_s": ended_s if to_s is None else to_s,
    }
