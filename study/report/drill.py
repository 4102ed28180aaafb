"""A drill in the report: its faults, acts and expectations beside the train graph, numbered, and in tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

from matplotlib.axes import Axes

from study.report.style import INK, PALE, RED, RULE, TimeBand, TimeGrid, draw_clock_axis, spread

ROW_IN: Final = 0.17
MET: Final = "#2e7d4f"
_TEXT_MAX: Final = 46
_TAG_GAP_SHARE: Final = 0.02  # least distance of the numbers on the graph, share of the panel's width


class MarkKind(Enum):
    """What a mark stands for; the value is the letter of its number."""

    FAULT = "F"
    ACT = "A"
    EXPECTATION = "E"


@dataclass(frozen=True, slots=True)
class Mark:
    """One item of a drill. An expectation's stretch is what was judged, `at_s` when it was met or broken."""

    kind: MarkKind
    number: int
    text: str
    from_s: float
    to_s: float
    at_s: float | None = None
    passed: bool = True
    happened: str = ""

    @property
    def label(self) -> str:
        """F1, A1, E1."""
        return f"{self.kind.value}{self.number}"

    def shows(self, band: TimeBand) -> bool:
        """Whether any of it falls in the panel."""
        if band.meets(self.from_s, self.to_s):
            return True
        at_s = self.from_s if self.at_s is None else self.at_s
        return band.from_s <= at_s <= band.to_s


@dataclass(frozen=True, slots=True)
class DrillShown:
    """What the report shows of a drill; `score` is a sentence."""

    passed: bool
    marks: tuple[Mark, ...]
    score: str

    def of(self, *kinds: MarkKind) -> tuple[Mark, ...]:
        """Marks of some kinds, in order."""
        return tuple(mark for mark in self.marks if mark.kind in kinds)

    def unmet(self) -> tuple[str, ...]:
        """Expectations that were not met, and what happened."""
        return tuple(
            f"{mark.text}: {mark.happened}" for mark in self.of(MarkKind.EXPECTATION) if not mark.passed
        )

    def verdict(self) -> str:
        """Passed or not, in words."""
        judged, unmet = len(self.of(MarkKind.EXPECTATION)), len(self.unmet())
        return f"NOT passed: {unmet} of {judged} expectations not met" if unmet else f"passed: {judged} met"


def strip_height_in(marks: Sequence[Mark]) -> float:
    """Height of the strip for these marks."""
    return ROW_IN * len(marks)


def mark_graph(axes: Axes, marks: Sequence[Mark], band: TimeBand) -> None:
    """On a panel of the train graph: faults as pale bands, acts as lines, each with its number at the top."""
    shown = sorted((m for m in marks if m.kind is not MarkKind.EXPECTATION), key=lambda m: m.from_s)
    for mark in shown:
        if mark.kind is MarkKind.FAULT:
            axes.axvspan(mark.from_s, mark.to_s, color=RED, alpha=0.07, lw=0, zorder=0.4)
            axes.axvline(mark.from_s, color=RED, lw=0.7, alpha=0.7, zorder=0.55)
        else:
            axes.axvline(mark.from_s, color=INK, lw=0.8, ls=(0, (2, 2)), zorder=0.55)
    width_s = band.to_s - band.from_s
    margin_s = _TAG_GAP_SHARE / 2 * width_s
    places = [min(max(mark.from_s, band.from_s + margin_s), band.to_s - margin_s) for mark in shown]
    for mark, at_s in zip(shown, spread(places, _TAG_GAP_SHARE * width_s), strict=True):
        axes.text(
            at_s,
            0.99,
            mark.label,
            transform=axes.get_xaxis_transform(),
            ha="center",
            va="top",
            fontsize=7,
            color=RED if mark.kind is MarkKind.FAULT else INK,
            zorder=6,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
        )


def draw_strip(axes: Axes, marks: Sequence[Mark], band: TimeBand, grid: TimeGrid) -> None:
    """Under a panel: a row a fault, act or expectation, on the panel's clock."""
    draw_clock_axis(axes, band, grid)
    axes.tick_params(axis="x", labeltop=False, labelbottom=False)
    axes.set_ylim(len(marks) - 0.5, -0.5)
    axes.set_yticks(range(len(marks)), [f"{m.label}  {shortened(m.text)}" for m in marks], fontsize=7)
    axes.tick_params(axis="y", length=0)
    for row, (mark, label) in enumerate(zip(marks, axes.get_yticklabels(), strict=True)):
        axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
        if mark.kind is MarkKind.EXPECTATION:
            label.set_color(INK if mark.passed else RED)
            _draw_expectation(axes, row, mark, band)
        elif mark.kind is MarkKind.FAULT and mark.to_s > mark.from_s:
            axes.barh(row, mark.to_s - mark.from_s, left=mark.from_s, height=0.5, color=RED, alpha=0.55, lw=0)
        else:
            colour = RED if mark.kind is MarkKind.FAULT else INK
            axes.plot([mark.from_s], [row], ls="", marker="D", ms=4, mew=0, color=colour, clip_on=False)
    axes.spines[:].set_color(RULE)


def _draw_expectation(axes: Axes, row: int, mark: Mark, band: TimeBand) -> None:
    """The stretch judged, pale, and a dot where it was met or a cross where it was not."""
    from_s, to_s = max(mark.from_s, band.from_s), min(mark.to_s, band.to_s)
    if to_s > from_s:
        axes.barh(row, to_s - from_s, left=from_s, height=0.22, color=PALE, alpha=0.45, lw=0)
    at_s = mark.to_s if mark.at_s is None else mark.at_s
    if band.from_s <= at_s <= band.to_s:
        style, colour = ("o", MET) if mark.passed else ("X", RED)
        size = 4.5 if mark.passed else 6
        axes.plot([at_s], [row], ls="", marker=style, ms=size, mew=0, color=colour, clip_on=False, zorder=4)


def shortened(text: str) -> str:
    """At most so many characters that stations' names beside the graph keep their room."""
    return text if len(text) <= _TEXT_MAX else text[: _TEXT_MAX - 1].rstrip() + "…"
