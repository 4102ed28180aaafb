from collections.abc import Callable, Sequence

import polars as pl
import pytest

from study.record.figure import schema_of
from study.record.tables import ROWS, make_table

Row = tuple[str, str, float | None, float | None]


@pytest.fixture
def make_stops() -> Callable[[Sequence[Row]], pl.DataFrame]:
    """A table of stops from (train, station, arrival, departure); the rest is empty."""

    def make(rows: Sequence[Row]) -> pl.DataFrame:
        known = [
            {"train": t, "station": s, "arrival_s": a, "departure_s": d, "revenue": True, "cancelled": False}
            for t, s, a, d in rows
        ]
        return make_table(
            "stops", {name: [row.get(name) for row in known] for name in schema_of(ROWS["stops"])}
        )

    return make
