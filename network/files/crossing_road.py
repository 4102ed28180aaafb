"""`[crossings.road]`: the road that a level crossing (踏切) belongs to, what drives on it, and how.

Where a figure is `assumed`, nothing of the road's own is known: counts of a road are published as vehicles an hour
(道路交通センサス).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field, field_validator

from network.files.chances import ApproachM, Lanes, RoadTime, RoadVehicles, StopLineM
from network.files.kinds import about
from network.files.quantities import Share, SpeedKmh
from network.files.toml_input import Record, validate

HOURS: Final = 24
LANE_WIDTH_M: Final = 3.0


class CrossingRoad(Record):
    """A road with as many lanes one way as the other; vehicles drive on the left."""

    lanes: Annotated[Lanes, about("lanes each way", "assumed: a road of two lanes")] = 1
    vehicles_per_h: Annotated[
        tuple[RoadVehicles, ...],
        Field(strict=False, min_length=1, max_length=HOURS),
        about("both ways together, in each hour from midnight; a single figure: in every hour"),
    ]
    speed_kmh: Annotated[SpeedKmh, about("limit of the road", "assumed: a road through villages")] = 40.0
    approach_m: Annotated[
        ApproachM,
        about("road before the crossing; a queue that is longer waits outside", "assumed: forty cars"),
    ] = 300.0
    stop_line_m: Annotated[
        StopLineM,
        about(
            "from the stop line, at the barrier, to the middle of the track", "assumed: 2 m beside the gauge"
        ),
    ] = 5.0
    heavy_share: Annotated[
        Share, about("share of lorries and buses, 12 m long; the others are cars", "assumed")
    ] = 0.1
    half_barriers: Annotated[
        bool, about("whether barriers close the lanes that lead in alone, so that there is a way round")
    ] = False
    round_share: Annotated[
        Share, about("share of drivers who drive round half barriers when they have waited", "assumed: none")
    ] = 0.0
    round_after_s: Annotated[
        RoadTime, about("how long those wait first, mean of an exponential", "assumed: a minute")
    ] = 60.0
    stall_share: Annotated[
        Share, about("share of vehicles that stall on the crossing, and go on by themselves", "assumed: none")
    ] = 0.0
    stall_s: Annotated[
        RoadTime, about("how long those stand, mean of an exponential", "assumed: two minutes")
    ] = 120.0

    @field_validator("vehicles_per_h")
    @classmethod
    def _one_or_each(cls, vehicles_per_h: tuple[float, ...]) -> tuple[float, ...]:
        if len(vehicles_per_h) not in (1, HOURS):
            raise ValueError(f"one figure, or {HOURS}")
        return vehicles_per_h

    def per_h(self, hour: int) -> float:
        """Vehicles both ways in an hour of the day, which may be one after midnight."""
        return self.vehicles_per_h[hour % len(self.vehicles_per_h)]

    @property
    def speed_mps(self) -> float:
        """Limit of the road, m/s."""
        return self.speed_kmh / 3.6

    @property
    def width_m(self) -> float:
        """All lanes together, along the track."""
        return 2.0 * self.lanes * LANE_WIDTH_M


def roads_of(data: Mapping[str, Any], file: str) -> dict[str, CrossingRoad]:
    """The roads in the tables of a line file that was found right, by id of the crossing; `file` names it."""
    rows = data.get("crossings", ())
    return {row["id"]: validate(row["road"], file, CrossingRoad) for row in rows if "road" in row}
