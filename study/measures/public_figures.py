"""Energy figures that others have published, with what they may be compared with and what not."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final


class FigureBasis(Enum):
    """What a figure is per, and so which of ours stands beside it."""

    CAR_KM = "kWh per car-km"
    TRAIN_KM = "kWh per train-km"


@dataclass(frozen=True, slots=True)
class PublicFigure:
    """One published figure. `train_id`: said of this kind of train alone; empty: of a whole railway."""

    name: str
    per: FigureBasis
    kwh: float
    source: str
    comparable: str
    train_id: str = ""
    bound: bool = False  # the true figure lies below it


PUBLIC_FIGURES: Final = (
    PublicFigure(
        "all electric trains of JR East",
        FigureBasis.CAR_KM,
        1.7,
        "Toyo Keizai online, article 50307",
        "electricity bought, so with the losses of substations and wires and without what trains regenerate for each"
        " other; long trains, faster and fuller than here; ours is drawn from battery or wire, layovers included",
    ),
    PublicFigure(
        "nine private railways round Tokyo",
        FigureBasis.CAR_KM,
        2.0,
        "livedoor news 16541981, after the railway statistics of fiscal 2016 (about 2)",
        "electricity for running trains as bought, dense commuter traffic; ours as above",
    ),
    PublicFigure(
        "the EV-E301 on the flat",
        FigureBasis.TRAIN_KM,
        190.0 / 50.0,
        'Sankei, 26 October 2015: "about 50 km on 190 kWh"',
        "a bound: nobody empties a battery, so the train takes less; on the flat, where ours climbs and descends;"
        " ours without layovers",
        "ev_e301",
        bound=True,
    ),
)
