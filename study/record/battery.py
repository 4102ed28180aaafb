"""Sets that run on batteries: the rows of the tables `battery` and `charges`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from simulation.result import BatteryEvent
from study.record.columns import Station, Train, Unit, clock, kwh
from study.record.figure import Figure, Kind, ShownIn
from study.wording.catalogue import phrase


@dataclass(frozen=True, slots=True)
class BatteryMoment:
    """One moment of a set: each half minute and at each of its events; sums are of the day."""

    t_s: float
    unit: str
    train: Annotated[str, "off the line the one before"]
    event: BatteryEvent
    station: Annotated[str, "where it stands; empty elsewhere"]
    soc: Annotated[float, "0 to 1"]
    soc_low: Annotated[float, "low end of the window"]
    soc_kept: Annotated[float, "with what is to be kept back"]
    stored_kwh: Annotated[float, "between empty and that state of charge"]
    above_low_kwh: float
    power_kw: Annotated[float, "at the terminals, the mean since the row before; above 0 out"]
    supply_kw: Annotated[float, "what charger or wire gives at most"]
    given_kwh: Annotated[float, kwh("given", digits=1), "at the terminals, out"]
    taken_kwh: Annotated[float, kwh("taken", context="battery", digits=1), "at the terminals, in"]
    lost_kwh: Annotated[float, kwh("lost", context="battery", digits=1), "in its resistance"]
    supplied_kwh: Annotated[
        float,
        kwh("from chargers and wires", digits=1),
        "by chargers and wires, to battery and train",
    ]
    missing_kwh: Annotated[float, kwh("missing", digits=1), "asked for and not to be had"]
    spilled_kwh: Annotated[float, "came back and was not taken"]


@dataclass(frozen=True, slots=True)
class ChargeTaken:
    """One charge, from the first current to the last: at a charger, off the line, or by a generator brought."""

    unit: Unit
    train: Annotated[Train, "that leaves with it"]
    station: Annotated[Station, "empty: off the line, or between stations"]
    from_s: Annotated[float, clock("from")]
    to_s: Annotated[float, clock("to")]
    soc_from: float
    soc_to: float
    minutes: Annotated[float, Figure(phrase("minutes charged"), "", 1, seen=ShownIn.REPORT)]
    minutes_suffice: Annotated[
        float | None,
        Figure(phrase("minutes that suffice"), "", 1, seen=ShownIn.REPORT),
        "so that it comes there with just that; none: no time would do",
    ]
    gained_kwh: Annotated[float, kwh("gained", digits=1, kind=Kind.SIGNED)]
    next_way_kwh: Annotated[
        float,
        kwh("next way takes", digits=1),
        "what the battery lost from there to the next charge",
    ]
    margin_kwh: Annotated[
        float,
        kwh("margin over what is kept", digits=1, kind=Kind.SIGNED),
        "above what is to be kept back, at the next charge",
    ]
