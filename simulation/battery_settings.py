"""`[battery]` of a scenario: trains run on their batteries, how much is in them, and what they do off the line."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from network.files.kinds import about
from network.files.quantities import (
    BatteryPowerKw,
    ChargeTime,
    Consumption,
    HeatingKw,
    OwnWay,
    Share,
    SpeedKmh,
)
from network.files.toml_input import Record
from network.units import J_PER_KWH


class Departure(StrEnum):
    """What a set does whose battery does not suffice to its next charge."""

    WAIT = "wait"
    LEAVE = "leave"


class Beyond(Record):
    """`[battery.beyond]`: what sets do off the line, from their leaving by a portal to their coming back.

    First they run there, then they charge; a set that is back too soon for that charges for less.
    """

    distance_km: Annotated[
        OwnWay,
        about(
            "run off the line, there and back",
            "published: 11.7 km to Utsunomiya; assumed: every set goes there",
        ),
    ] = 23.4
    speed_kmh: Annotated[
        SpeedKmh, about("mean speed there, stops among it", "assumed: the local trains of the main line")
    ] = 60.0
    consumption_kwh_per_km: Annotated[
        Consumption,
        about(
            "taken from the battery there, auxiliaries among it",
            "published: the main line has a wire of 1500 V, from which sets run",
        ),
    ] = 0.0
    charge_min: Annotated[
        ChargeTime, about("minutes of charging there, at most", "assumed: under the wire of the main line")
    ] = 20.0
    charge_kw: Annotated[
        BatteryPowerKw, about("power of that, at most", "assumed: as the normal charging of Hoshakuji")
    ] = 200.0

    @property
    def runs_s(self) -> float:
        """How long the run there takes, s."""
        return self.distance_km / self.speed_kmh * 3600.0

    @property
    def takes_j(self) -> float:
        """What running there takes of the battery, J."""
        return self.distance_km * self.consumption_kwh_per_km * J_PER_KWH


class BatterySettings(Record):
    """`[battery]`: trains that have a battery run on it and on nothing else; without the table all run from a wire."""

    departure: Annotated[
        Departure,
        Field(strict=False),
        about(
            "a set whose charge does not take it to its next charge waits (at a charger for the charge, elsewhere for"
            " a person), or leaves on time whatever",
            "assumed: nobody publishes the rule",
        ),
    ] = Departure.WAIT
    start_share: Annotated[
        Share,
        about("share of the usable window in the battery when the day begins", "assumed: charged overnight"),
    ] = 1.0
    start_of: Annotated[dict[str, Share], about("the same by stock id")] = Field(default_factory=dict)
    reserve_share: Annotated[
        Share,
        about(
            "share of the usable window that must remain at the next charge, as a set predicts when it leaves a"
            " charger or begins a train",
            "assumed: a tenth",
        ),
    ] = 0.1
    prediction_share: Annotated[
        Share,
        about(
            "added to what a unit predicts: for losses in the battery and other driving than predicted",
            "assumed: a tenth",
        ),
    ] = 0.1
    shed_to_kw: Annotated[
        HeatingKw,
        about(
            "auxiliaries that stay on in a set that stands without a charger and has no more than its reserve above"
            ' what it needs to leave; the reserve alone with departure = "leave"',
            "assumed: lights, radio, doors and the air of the brakes of two cars; that heating and cooling can wait:"
            " FRA, Feasibility of Load-Shedding (2021)",
        ),
    ] = 5.0
    brought_kw: Annotated[
        BatteryPowerKw,
        about(
            "power of the generator that staff bring to a set without charge (bring_power)",
            "assumed: what a lorry carries",
        ),
    ] = 60.0
    heating_kw: Annotated[
        HeatingKw, about("auxiliaries beyond those of the train file: a cold day", "assumed: a mild day")
    ] = 0.0
    beyond: Beyond = Field(default_factory=Beyond)
    beyond_after: Annotated[
        dict[str, Beyond], about("the same after one train, by the number of the train that leaves the line")
    ] = Field(default_factory=dict)

    def beyond_of(self, number: str) -> Beyond:
        """What the set of a train does after that has left the line."""
        return self.beyond_after.get(number, self.beyond)
