"""What the pictures are made of that page and plot both have: their layers, each with label, colour and line, and axes.

The page gets them with its data, a figure of matplotlib takes `line` or `face` of each layer: a colour, label or dash
is changed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from network.model import Direction
from study.report.style import (
    AUXILIARY,
    DIRECTION_COLOUR,
    INK,
    PALE,
    PLAN_COLOUR,
    RED,
    REGENERATED,
    RULE,
    STANDING,
    TRACTION,
    UNIT_COLOURS,
)
from study.wording.catalogue import phrase
from study.wording.phrase import NOTHING, Phrase

PX_PER_PT: Final = 4.0 / 3.0


@dataclass(frozen=True, slots=True)
class Layer:
    """One layer: what it is called, its colour and opacity; of a line its width in pt, and dashes in widths."""

    label: Phrase
    colour: str
    opacity: float = 1.0
    width_pt: float = 0.0
    dashes: tuple[float, ...] = ()

    def face(self) -> dict[str, Any]:
        """How matplotlib fills it."""
        return {"color": self.colour, "alpha": self.opacity, "lw": 0.0, "label": self.label.en}

    def line(self) -> dict[str, Any]:
        """How matplotlib draws its line."""
        style = (0, self.dashes) if self.dashes else "-"
        return {
            "color": self.colour,
            "alpha": self.opacity,
            "lw": self.width_pt,
            "ls": style,
            "label": self.label.en,
        }

    def for_page(self) -> dict[str, Any]:
        """Label, opacity, colour with it, width and dashes in px."""
        width_px = self.width_pt * PX_PER_PT
        return {
            "label": self.label.both,
            "opacity": self.opacity,
            "colour": f"{self.colour}{round(255 * self.opacity):02x}",
            "width": round(width_px, 2),
            "dashes": [round(dash * width_px, 2) for dash in self.dashes],
        }


@dataclass(frozen=True, slots=True)
class PictureDesign:
    """Layers by name, from the lowest to the highest, and what stands at its axis upwards, with the unit."""

    layers: Mapping[str, Layer]
    up: Phrase = NOTHING

    def for_page(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "up": self.up.both,
            "layers": {name: layer.for_page() for name, layer in self.layers.items()},
        }


_SPEED: Final = phrase("speed")
RUN_CURVE: Final = PictureDesign(
    {
        "limit": Layer(phrase("speed limit of the line"), INK, width_pt=0.9),
        "permitted": Layer(phrase("permitted by supervision"), RED, width_pt=0.8),
        "target": Layer(phrase("target"), PALE, width_pt=0.9, dashes=(4, 2)),
        "down": Layer(_SPEED, DIRECTION_COLOUR[Direction.DOWN], width_pt=1.6),
        "up": Layer(_SPEED, DIRECTION_COLOUR[Direction.UP], width_pt=1.6),
        "braked": Layer(phrase("supervision brakes"), RED),
    },
    up=phrase("speed, km/h"),
)
ENERGY: Final = PictureDesign(
    {
        "traction": Layer(phrase("traction"), TRACTION),
        "auxiliary": Layer(phrase("auxiliary, running"), AUXILIARY),
        "standing": Layer(phrase("auxiliary, standing"), STANDING),
        "regenerated": Layer(phrase("regenerated"), REGENERATED),
    },
    up=phrase("energy, kWh"),
)
# Held and occupied are seen in the colour of the stock; the legend of the plot has them in grey.
OCCUPANCY: Final = PictureDesign(
    {
        "held": Layer(phrase("held"), "#555555", opacity=0.25),
        "occupied": Layer(phrase("occupied"), "#555555"),
    }
)
# What a drill puts on the train graph.
DRILL: Final = PictureDesign(
    {
        "lasts": Layer(phrase("while a fault lasts (F)"), RED, opacity=0.07),
        "stretch": Layer(phrase("its stretch of the line"), RED, opacity=0.3),
        "train": Layer(phrase("the train that has it"), RED, opacity=0.3, width_pt=7.0),
        "act": Layer(phrase("a person acts (A)"), INK, width_pt=0.8, dashes=(2, 2)),
    }
)
# Lines of trains, by direction, and what else links or compares them. `empty`: the dashes of trains without passengers.
TRAIN_GRAPH: Final = PictureDesign(
    {
        "crossing": Layer(NOTHING, "#7a6a3a", width_pt=0.5, dashes=(2, 3)),
        "turn": Layer(NOTHING, PALE, width_pt=0.75, dashes=(1.5, 2.5)),
        "run_down": Layer(NOTHING, DIRECTION_COLOUR[Direction.DOWN], opacity=0.6, width_pt=2.0),
        "run_up": Layer(NOTHING, DIRECTION_COLOUR[Direction.UP], opacity=0.6, width_pt=2.0),
        "plan_down": Layer(NOTHING, PLAN_COLOUR[Direction.DOWN], width_pt=0.65),
        "plan_up": Layer(NOTHING, PLAN_COLOUR[Direction.UP], width_pt=0.65),
        "empty": Layer(NOTHING, PALE, width_pt=0.65, dashes=(6, 4)),
        "beside": Layer(NOTHING, "#3c3c3c", width_pt=0.9, dashes=(4, 2)),
        "gone": Layer(NOTHING, RED, width_pt=1.0, dashes=(4, 2)),
    }
)
WAYS: Final[Mapping[int, str]] = {Direction.DOWN: "down", Direction.UP: "up"}
STOP_ERRORS: Final = PictureDesign({}, up=phrase("front beyond the mark, m"))
PICTURES: Final[Mapping[str, PictureDesign]] = {
    "train_graph": TRAIN_GRAPH,
    "run_curve": RUN_CURVE,
    "energy": ENERGY,
    "occupancy": OCCUPANCY,
    "drill": DRILL,
    "stop_errors": STOP_ERRORS,
}
# Colours that page and plot share, by the page's names.
PALETTE: Final[Mapping[str, str | tuple[str, ...]]] = {
    "ink": INK,
    "rule": RULE,
    "red": RED,
    "down": DIRECTION_COLOUR[Direction.DOWN],
    "up": DIRECTION_COLOUR[Direction.UP],
    "traction": TRACTION,
    "regenerated": REGENERATED,
    "auxiliary": AUXILIARY,
    "units": UNIT_COLOURS,
}
