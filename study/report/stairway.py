"""The blocking-time stairway (閉そく占有時分, Sperrzeitentreppe): what the time of each section goes into.

Sections stand one below the other in the order of the line, those beside one another too, short ones higher than they
are long: else a set of points would not be seen. Trains are drawn through the sections that they run through.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import polars as pl

from study.capacity.blocking_table import read_blocking
from study.capacity.occupation import Conflict, Occupation, OccupationPart
from study.report.data import ReportedRun, section_name, sections_in_order
from study.report.packing import packed_column, places_in
from study.report.style import INK, RED, RULE, WIDTH_IN, TimeBand, centred, draw_clock_axis, time_bands
from study.wording.catalogue import phrase
from study.wording.phrase import Language

if TYPE_CHECKING:  # the page of a run draws its stairway itself
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_IN: Final = 4.4
LEAST_SHARE: Final = 0.045  # of the panel's height, that the shortest section has
SEEN_S: Final = 1.0  # on the page shorter slices are their neighbour's

# One hue a cost, one shade a part of it.
PART_COLOURS: Final[Mapping[OccupationPart, str]] = {
    OccupationPart.REQUEST: "#08306b",
    OccupationPart.AIR: "#2171b5",
    OccupationPart.GRANT: "#4292c6",
    OccupationPart.PROOF: "#6baed6",
    OccupationPart.RELEASE: "#9ecae1",
    OccupationPart.THROW: "#e6550d",
    OccupationPart.APPROACH: "#c7e9c0",
    OccupationPart.RUN: "#41ab5d",
    OccupationPart.HELD: "#00602b",
    OccupationPart.LENGTH: "#84c98a",
    OccupationPart.READY: "#f2e6c2",
    OccupationPart.DWELL: "#d9b95a",
    OccupationPart.LAYOVER: "#e8d28f",
    OccupationPart.CHANGE_ENDS: "#a6801d",
    OccupationPart.CHARGING: "#d36ba6",
    OccupationPart.START: "#238b45",
    OccupationPart.BOUND: "#cbbfe0",
    OccupationPart.RULE: "#9e87c7",
}


def draw_stairway(
    run: ReportedRun,
    occupations: Sequence[Occupation],
    conflicts: Sequence[Conflict] = (),
    *,
    language: Language = "en",
) -> Figure | None:
    """The stairway in the panels of the train graph; hatched in red: what two trains want at once. None: no time."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    if not occupations:
        return None
    bands, grid = time_bands(*run.window_s)
    rows = _rows(run)
    names = [section_name(run, section_id, japanese=language == "ja") for section_id in rows]
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * len(bands) + 0.7), layout="constrained")
    for axes, band in zip(figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands, strict=True):
        draw_clock_axis(axes, band, grid)
        axes.set_ylim(1.0, 0.0)
        axes.set_yticks([(low + high) / 2 for low, high in rows.values()], names, fontsize=6.5)
        axes.tick_params(axis="y", length=0)
        for _, high in rows.values():
            axes.axhline(high, color=RULE, lw=0.5, zorder=0.6)
        _draw_boxes(axes, occupations, rows, band)
        _draw_conflicts(axes, conflicts, rows, band)
        _draw_trains(axes, run, rows, band)
        axes.spines[:].set_color(RULE)
    parts = [part for part in OccupationPart if any(one.of_part(part) > 0.0 for one in occupations)]
    legend = [
        Patch(color=PART_COLOURS[part], lw=0, label=phrase(part.value, "part").in_(language))
        for part in parts
    ]
    if conflicts:
        legend.append(Patch(fc="none", ec=RED, hatch="////", lw=0.8, label="conflict"))
    figure.legend(handles=legend, loc="outside lower left", ncols=9, handlelength=1.2, fontsize=6.5)
    return figure


def _rows(run: ReportedRun) -> dict[str, tuple[float, float]]:
    """Where each section stands, as shares of the height from above, in the order of the line."""
    sections = sections_in_order(run)
    lengths_m = [
        max((run.line.pieces[piece].length_m for piece in section.piece_ids), default=0.0)
        for section in sections
    ]
    whole_m = sum(lengths_m) or 1.0
    shares = np.maximum(np.asarray(lengths_m) / whole_m, LEAST_SHARE)
    ends = np.concatenate(([0.0], np.cumsum(shares / shares.sum())))
    return {s.id: (float(a), float(b)) for s, a, b in zip(sections, ends[:-1], ends[1:], strict=True)}


def _draw_boxes(
    axes: Axes, occupations: Iterable[Occupation], rows: Mapping[str, tuple[float, float]], band: TimeBand
) -> None:
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    boxes: list[Rectangle] = []
    colours: list[str] = []
    frames: list[Rectangle] = []
    for one in occupations:
        row = rows.get(one.section_id)
        if row is None or not band.meets(one.begin_s, one.end_s):
            continue
        frames.append(Rectangle((one.begin_s, row[0]), one.length_s, row[1] - row[0]))
        for piece in one.slices:
            boxes.append(Rectangle((piece.begin_s, row[0]), piece.length_s, row[1] - row[0]))
            colours.append(PART_COLOURS[piece.part])
    axes.add_collection(PatchCollection(boxes, facecolor=colours, edgecolor="none", alpha=0.75, zorder=1.0))
    axes.add_collection(PatchCollection(frames, facecolor="none", edgecolor=INK, lw=0.45, zorder=1.6))


def _draw_conflicts(
    axes: Axes, conflicts: Iterable[Conflict], rows: Mapping[str, tuple[float, float]], band: TimeBand
) -> None:
    from matplotlib.patches import Rectangle

    for one in conflicts:
        row, from_s = rows.get(one.section_id), one.second.begin_s
        if row is not None and band.meets(from_s, from_s + one.overlap_s):
            box = Rectangle((from_s, row[0]), one.overlap_s, row[1] - row[0])
            box.set(fc="none", ec=RED, hatch="////", lw=0.8, zorder=4.0)
            axes.add_patch(box)


def _draw_trains(
    axes: Axes, run: ReportedRun, rows: Mapping[str, tuple[float, float]], band: TimeBand
) -> None:
    """Each train's front through the rows of the sections that it is in, with its number where it begins."""
    pieces = run.line.pieces
    for (_, number), course in run.courses.items():
        shown = course.filter(pl.col("t_s").is_between(band.from_s, band.to_s))
        if shown.is_empty():
            continue
        heights: list[float] = []
        for piece_id, at_m in shown.select("piece", "kilometrage_m").iter_rows():
            piece = pieces[piece_id]
            low, high = rows[piece.section_id]
            section = run.line.sections[piece.section_id]
            from_m = min(pieces[p].from_m for p in section.piece_ids)
            to_m = max(pieces[p].to_m for p in section.piece_ids)
            share = min(max((at_m - from_m) / max(to_m - from_m, 1e-9), 0.0), 1.0)
            heights.append(low + share * (high - low))
        axes.plot(shown["t_s"].to_numpy(), heights, color=INK, lw=0.8, zorder=3.0)
        middle = len(heights) // 2
        centred(
            axes,
            float(shown["t_s"][middle]),
            heights[middle],
            number,
            5.5,
            color=INK,
            va="bottom",
            zorder=5.0,
            clip_on=True,
            bbox={"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.3},
        )


def stairway_shown(run: ReportedRun) -> dict[str, Any]:
    """The stairway as the page has it: whole seconds, and no slice too short to be seen."""
    found = [one for one in read_blocking(run.tables.blocking) if one.section_id in run.line.sections]
    slices = [(one, part, begin_s, end_s) for one in found for part, begin_s, end_s in _coarse(one)]
    sections, at = places_in([one.section_id for one, *_ in slices])
    trains, of = places_in([one.number for one, *_ in slices])
    parts, what = places_in([part.value for _, part, *_ in slices])
    return {
        "sections": sections,
        "trains": trains,
        "parts": [phrase(part, "part").both for part in parts],
        "colours": [PART_COLOURS[OccupationPart(part)] for part in parts],
        "section": at,
        "train": of,
        "part": what,
        "from": packed_column([begin_s for *_, begin_s, _ in slices], 1),
        "to": packed_column([end_s for *_, end_s in slices], 1),
    }


def _coarse(one: Occupation) -> list[tuple[OccupationPart, float, float]]:
    """The slices of an occupation, what is shorter than a second added to the one before it, or after it."""
    found: list[tuple[OccupationPart, float, float]] = []
    begin_s = one.begin_s
    for piece in one.slices:
        if piece.length_s < SEEN_S and found:
            found[-1] = (*found[-1][:2], piece.end_s)
        elif piece.length_s >= SEEN_S:
            found.append((piece.part, found[-1][2] if found else begin_s, piece.end_s))
    return found
