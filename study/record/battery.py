"""Sets that run on batteries: the rows of the tables `battery` and `charges`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from simulation.result import BatteryEvent
from study.record.columns import Station, Train, Unit, clock, kwh
from study.record.figure import Figure, Kind, ShownIn
from study.wording.phrase import Phrase


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
    given_kwh: Annotated[float, kwh("given", "放電", digits=1), "at the terminals, out"]
    taken_kwh: Annotated[float, kwh("taken", "充電", digits=1), "at the terminals, in"]
    lost_kwh: Annotated[float, kwh("lost", "損失", digits=1), "in its resistance"]
    supplied_kwh: Annotated[
        float,
        kwh("from chargers and wires", "充電設備・架線から", digits=1),
        "by chargers and wires, to battery and train",
    ]
    missing_kwh: Annotated[float, kwh("missing", "不足", digits=1), "asked for and not to be had"]
    spilled_kwh: Annotated[float, "came back and was not taken"]


@dataclass(frozen=True, slots=True)
class ChargeTaken:
    """One charge, from the first current to the last."""

    unit: Unit
    train: Annotated[Train, "that leaves with it"]
    station: Annotated[Station, "empty: off the line"]
    from_s: Annotated[float, clock("from", "開始")]
    to_s: Annotated[float, clock("to", "終了")]
    soc_from: float
    soc_to: float
    minutes: Annotated[float, Figure(Phrase("minutes charged", "充電 分"), "", 1, seen=ShownIn.REPORT)]
    minutes_suffice: Annotated[
        float | None,
        Figure(Phrase("minutes that suffice", "充足分"), "", 1, seen=ShownIn.REPORT),
        "so that it comes there with just that; none: no time would do",
    ]
    gained_kwh: Annotated[float, kwh("gained", "増加", digits=1, kind=Kind.SIGNED)]
    next_way_kwh: Annotated[
        float,
        kwh("next way takes", "次の区間", digits=1),
        "what the battery lost from there to the next charge",
    ]
    margin_kwh: Annotated[
        float,
        kwh("margin over what is kept", "留保分との差", digits=1, kind=Kind.SIGNED),
        "above what is to be kept back, at the next charge",
    ]
