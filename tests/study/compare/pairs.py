"""Scenarios that differ in one thing, and what differs between two run directories, worked out from their tables alone.

Nothing here uses what compares: polars joins, sums and counts, on the Parquet files as they lie there.
"""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl

from tests.trains import day_of

SLOWER_POINTS: Final = """
[patch.line.set]
"points.OGN.11.throw_time_s" = 45.0
"points.OGN.21.throw_time_s" = 45.0
"""
RADIO_OF_2_S: Final = """
[patch.air.set]
delay_mean_s = 2.0
"""
RESTRICTION: Final = """
[[patch.line.add.limits]]
from_km = 9.4
to_km = 9.8
speed_kmh = 25.0
directions = ["down", "up"]
"""
OTHER_TRAIN: Final = """
[trains]
default = "br642"
"""
# 323M of the weekday, which the round trip lacks; it meets 324M at Ogane and stays at Karasuyama.
ONE_MORE: Final = day_of(
    "323M down, portal:HSK.MD to stabled: HSK -/06:36; SHN 06:41/06:41; NIT 06:44/06:45; KNY 06:48/06:49;"
    " OGN 06:55/06:56; KBN 07:00/07:00; TAK 07:04/07:04; KRS 07:09/-",
    V3="323M",
).replace("[[", "[[patch.timetable.add.")
ONE_LESS: Final = """
[patch.timetable.remove]
trains = ["347M"]
"""
ROUND_TRIP_PAIRS: Final[Mapping[str, str]] = {
    "slower_points": SLOWER_POINTS,
    "radio_of_2_s": RADIO_OF_2_S,
    "restriction": RESTRICTION,
    "one_more": ONE_MORE,
    "other_train": OTHER_TRAIN,
}
WEEKDAY_PAIRS: Final[Mapping[str, str]] = {
    "slower_points": SLOWER_POINTS,
    "radio_of_2_s": RADIO_OF_2_S,
    "restriction": RESTRICTION,
    "one_less": ONE_LESS,
    "other_train": OTHER_TRAIN,
}


def scenario(folder: Path, base: str, name: str, text: str) -> Path:
    """A scenario that extends another."""
    file = folder / f"{name}.toml"
    file.write_text(f'extends = "{base}"\nid = "{name}"\nname = "{name}"\n{text}', "utf-8")
    return file


def moved_directly(base: Path, new: Path, over_s: float) -> set[tuple[str, str, str, float]]:
    """(train, station, what, seconds) of every arrival and departure that moved, by a join."""
    found: set[tuple[str, str, str, float]] = set()
    old, late = (pl.read_parquet(folder / "stops.parquet") for folder in (base, new))
    for what in ("arrival", "departure"):
        joined = old.join(late, on=["train", "station"], suffix="_new").select(
            "train", "station", (pl.col(f"{what}_s_new") - pl.col(f"{what}_s")).round(1).alias("by_s")
        )
        moved = joined.filter(pl.col("by_s").abs() > over_s)
        found |= {(train, station, what, by_s) for train, station, by_s in moved.iter_rows()}
    return found


def trains_directly(folder: Path) -> set[str]:
    return set(pl.read_parquet(folder / "stops.parquet")["train"])


def net_kwh_directly(folder: Path) -> float:
    tables = [pl.read_parquet(folder / f"{name}.parquet") for name in ("energy", "layovers")]
    return sum(float(table["net_kwh"].sum()) for table in tables)


def net_kwh_by_train_directly(folder: Path) -> dict[str, float]:
    table = pl.read_parquet(folder / "energy.parquet").group_by("train").agg(pl.col("net_kwh").sum())
    return dict(table.iter_rows())


def sent_directly(folder: Path) -> dict[str, int]:
    table = pl.read_parquet(folder / "telegrams.parquet").group_by("kind").agg(pl.col("sent").sum())
    return dict(table.iter_rows())


def share_in_time_directly(folder: Path, what: str, most_s: float) -> float:
    stops = pl.read_parquet(folder / "stops.parquet").filter(pl.col(f"planned_{what}_s").is_not_null())
    late_s = stops[f"{what}_s"] - stops[f"planned_{what}_s"]
    return 100.0 * sum(late is not None and round(late, 1) <= most_s for late in late_s) / len(late_s)


def least_left_directly(folder: Path) -> float:
    return float(str(pl.read_parquet(folder / "margins.parquet")["left_s"].drop_nulls().min()))


def meets_directly(folder: Path) -> dict[tuple[str, str], str]:
    """The station of each pair of opposing trains that stand there at one time, by the table of stops.

    On a line with one crossing station that is where trains meet; their directions are those of their samples.
    """
    samples = (
        pl.read_parquet(folder / "trajectory.parquet").group_by("train").agg(pl.col("direction").first())
    )
    direction = dict(samples.iter_rows())
    stood: list[dict[str, Any]] = (
        pl.read_parquet(folder / "stops.parquet").drop_nulls(["arrival_s", "departure_s"]).to_dicts()
    )
    found: dict[tuple[str, str], str] = {}
    for down, up in product(stood, stood):
        apart = direction[down["train"]] <= direction[up["train"]] or down["station"] != up["station"]
        overlap = down["arrival_s"] < up["departure_s"] and up["arrival_s"] < down["departure_s"]
        if overlap and not apart:
            found[down["train"], up["train"]] = down["station"]
    return found


def gap_directly(folder: Path, down: str, up: str, time_s: float) -> float:
    """How far the fronts of two trains are apart along the line at a time, m, by their samples."""
    samples = pl.read_parquet(folder / "trajectory.parquet")
    at_m = []
    for train in (down, up):
        own = samples.filter(pl.col("train") == train).sort("t_s")
        at_m.append(float(np.interp(time_s, own["t_s"].to_numpy(), own["kilometrage_m"].to_numpy())))
    return abs(at_m[0] - at_m[1])
