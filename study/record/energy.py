"""Where energy went: the rows of the tables `energy`, `energy_legs`, `energy_hours` and `layovers`.

With the auxiliaries the parts of a row make up its net, but for the residual.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

from simulation.result import EnergyPhase
from study.record.columns import From, Revenue, Station, To, Train, Unit, clock, kwh, seconds
from study.record.figure import Adds, Figure, Kind, ShownIn, figures_of, seen_in
from study.wording.catalogue import phrase
from vehicle.train_file import RegenerationReceiver

_SUMS: Final = ShownIn.REPORT | ShownIn.SUMS
_FILES: Final = _SUMS | ShownIn.ROWS_COMPARED
_LISTED: Final = _FILES | ShownIn.ROWS_LISTED
_FIRST: Final = _LISTED | ShownIn.LISTED_BY


def _km(digits: int) -> Figure:
    return Figure(phrase("km"), "", digits, Adds.SUM, seen=_FILES)


def _part(name: str) -> Figure:
    return kwh(name, ShownIn.PARTS)


@dataclass(frozen=True, kw_only=True)
class EnergyDrawn:
    """What was drawn and given back."""

    traction_kwh: Annotated[float, kwh("traction", _LISTED)]
    auxiliary_kwh: Annotated[float, kwh("auxiliary", _FILES | ShownIn.PARTS)]
    regenerated_kwh: Annotated[float, kwh("regenerated", _LISTED)]
    net_kwh: Annotated[float, kwh("net", _FIRST), "traction and auxiliary, less what came back"]


@dataclass(frozen=True, kw_only=True)
class EnergySpent(EnergyDrawn):
    """The same, and where it went."""

    kinetic_kwh: Annotated[float, _part("change of motion"), "of what turns too"]
    resistance_kwh: Annotated[float, _part("running resistance"), "starting resistance too"]
    gradient_kwh: Annotated[float, _part("gradients"), "lifted; below 0 downhill"]
    curve_kwh: Annotated[float, _part("curves")]
    friction_kwh: Annotated[float, _part("air brake")]
    traction_loss_kwh: Annotated[float, _part("losses pulling"), "motors and inverters that pull or coast"]
    regeneration_loss_kwh: Annotated[
        float, _part("losses braking"), "motors and inverters that brake, and resistors"
    ]
    rejected_kwh: Annotated[
        float,
        _part("of these not taken back"),
        "no part: not taken by battery or wire, burnt by resistors",
    ]
    residual_kwh: Annotated[float, _part("left open"), "what the parts leave open"]


@dataclass(frozen=True, kw_only=True)
class _Who:
    unit: Unit
    train: Train
    revenue: Revenue


@dataclass(frozen=True, kw_only=True)
class _WhoAndWhere(_Who):
    unit: str
    from_station: From
    to_station: To


@dataclass(frozen=True, kw_only=True)
class _Ran:
    cars: int
    distance_km: Annotated[float, _km(1)]
    running_s: Annotated[float, seconds("running")]
    standing_s: Annotated[float, seconds("standing")]


@dataclass(frozen=True, kw_only=True)
class SpentByTrain(EnergySpent, _Ran):
    """The same of a train that ran."""

    standing_kwh: Annotated[
        float,
        kwh("of it standing", _SUMS),
        "of the auxiliary: at stops, before stop limits, in portals",
    ]


@dataclass(frozen=True, kw_only=True)
class TrainEnergy(SpentByTrain, _Who):
    """One train, from where it begins to move to where it ends; layovers have a table of their own."""

    regenerated_to: Annotated[RegenerationReceiver, "who takes what comes back"]


@dataclass(frozen=True, kw_only=True)
class LegEnergy(SpentByTrain, _WhoAndWhere):
    """One train and leg: from a place where it stops to the next, with the stop there."""

    distance_km: Annotated[float, _km(2)]


@dataclass(frozen=True, kw_only=True)
class _WhenAndWho:
    hour_s: Annotated[float, "when the hour begins"]
    unit: str
    phase: Annotated[EnergyPhase, "what the stock did meanwhile"]


@dataclass(frozen=True, kw_only=True)
class HourOfEnergy(EnergyDrawn, _WhenAndWho):
    """One hour, stock and phase: what it took and gave in that hour, stabled stock too."""


@dataclass(frozen=True, kw_only=True)
class _Stay:
    unit: Unit
    station: Station
    after_train: Annotated[str | None, Figure(phrase("after train"), seen=ShownIn.REPORT, kind=Kind.TRAIN)]
    before_train: Annotated[str | None, Figure(phrase("before train"), seen=ShownIn.REPORT, kind=Kind.TRAIN)]
    from_s: Annotated[float, clock("from")]
    to_s: Annotated[float, clock("to")]


@dataclass(frozen=True, kw_only=True)
class LayoverEnergy(EnergySpent, _Stay):
    """One stay where one train of a stock ends and the next begins."""


TAKEN: Final = tuple(figures_of(EnergyDrawn))
# auxiliaries apart
PARTS: Final = tuple(name for name in seen_in(EnergySpent, ShownIn.PARTS) if name not in TAKEN)
