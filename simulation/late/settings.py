"""`[late]`: from which distributions the disturbances of a day are drawn; without the table a day has none.

Each table is a source of its own, with a seeded stream of its own for every train, stop or device: whether another one
is there, or what it says, changes no draw of it. A table says where its figures come from (`source`).
"""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from network.files.chances import DelayFactor, MtbfH, MtbfKm, MtbfOperations, PerDay
from network.files.kinds import TEXTS_MAX, about
from network.files.names import Identifier, Prose
from network.files.part_of_day import PartOfDay
from network.files.quantities import Distance, Share
from network.files.toml_input import Record
from simulation.late.spread import DrawnTime

Ids = Annotated[tuple[str, ...], Field(strict=False, max_length=TEXTS_MAX)]
Source = Annotated[
    Prose, Field(min_length=1), about("where the figures come from: a publication, or assumed and why")
]
Switch = Annotated[bool, about("whether it is used; if not, nothing is drawn from it")]


class EntryDelays(Record):
    """`[late.entry.<name>]`: trains that come late to their portal. The first that fits a train counts."""

    on: Switch = True
    portals: Annotated[Ids, about("portal sections; none: all")] = ()
    share: Annotated[Share, about("share of trains that come late", "all of them")] = 1.0
    seconds: Annotated[DrawnTime, about("how late those are")]
    source: Source


class Peak(PartOfDay):
    """`late.dwell.<name>.peaks`: a part of the day in which passengers take longer, or less long."""

    times: Annotated[DelayFactor, about("factor of the draw")]


class DwellScatter(Record):
    """`[late.dwell.<name>]`: passengers who need longer than the shortest stop; spare time of the plan takes it up."""

    on: Switch = True
    share: Annotated[Share, about("share of stops", "all of them")] = 1.0
    seconds: Annotated[DrawnTime, about("time beyond the shortest stop")]
    stations: Annotated[dict[str, DelayFactor], about("factor of the draw, by station; elsewhere 1")] = Field(
        default_factory=dict
    )
    peaks: Annotated[
        tuple[Peak, ...],
        Field(strict=False, max_length=TEXTS_MAX),
        about("parts of the day, by the planned departure; the first that holds counts"),
    ] = ()
    source: Source

    def factor(self, station_id: str, departure_s: float) -> float:
        """By what a draw for that stop is multiplied."""
        peak = next((peak.times for peak in self.peaks if peak.from_s <= departure_s < peak.to_s), 1.0)
        return self.stations.get(station_id, 1.0) * peak


class DoorDelays(Record):
    """`[late.doors.<name>]`: doors that do not close at once as the train is to leave: nothing takes that up."""

    on: Switch = True
    share: Annotated[Share, about("share of stops")]
    seconds: Annotated[DrawnTime, about("until they close")]
    source: Source


class DeadZones(Record):
    """`[late.dead_zones.<name>]`: stretches that the radio does not reach for a while; no unit knows of them."""

    on: Switch = True
    per_day: Annotated[
        PerDay, about("mean number in a day; the number is Poisson's, time and place are even")
    ]
    length_low_m: Annotated[Distance, about("least length")]
    length_high_m: Annotated[Distance, about("greatest length, evenly between")]
    seconds: Annotated[DrawnTime, about("how long it lasts")]
    source: Source

    @field_validator("length_high_m")
    @classmethod
    def _not_shorter(cls, high_m: float, info: ValidationInfo) -> float:
        if high_m < (low_m := info.data.get("length_low_m", 0.0)):
            raise ValueError(f"at least length_low_m = {low_m:g}")
        return high_m


class Failures(Record):
    """`[late.failures.<name>]`: what breaks by chance and is repaired: a fault of docs/faults.md, with its own keys.

    It breaks after times, runs or throws that are exponential (geometric) with that mean: it does not age in a day.
    """

    model_config = ConfigDict(extra="allow")

    on: Switch = True
    kind: Annotated[Identifier, about("kind of fault, of docs/faults.md; its own keys stand beside this one")]
    targets: Annotated[Ids, about("what may break; none: everything that this kind may aim at")] = ()
    mtbf_h: Annotated[
        MtbfH | None, about("mean hours between failures: of a unit, on the line; of others, of the day")
    ] = None
    mtbf_km: Annotated[MtbfKm | None, about("units: mean kilometres between failures")] = None
    mtbf_operations: Annotated[MtbfOperations | None, about("points: mean throws between failures")] = None
    seconds: Annotated[
        DrawnTime | None, about("until it is repaired; left out only of kinds that are over at once")
    ] = None
    source: Source

    @model_validator(mode="after")
    def _one_mean(self) -> Self:
        if sum(value is not None for value in (self.mtbf_h, self.mtbf_km, self.mtbf_operations)) != 1:
            raise ValueError("one of mtbf_h, mtbf_km and mtbf_operations")
        return self


class Late(Record):
    """`[late]`: what makes a day late."""

    entry: Annotated[dict[str, EntryDelays], about("trains that come late, by name")] = Field(
        default_factory=dict
    )
    dwell: Annotated[dict[str, DwellScatter], about("passengers, by name; what tables draw adds up")] = Field(
        default_factory=dict
    )
    doors: Annotated[dict[str, DoorDelays], about("doors, by name; what tables draw adds up")] = Field(
        default_factory=dict
    )
    dead_zones: Annotated[dict[str, DeadZones], about("the radio, by name")] = Field(default_factory=dict)
    failures: Annotated[dict[str, Failures], about("what breaks, by name")] = Field(default_factory=dict)
