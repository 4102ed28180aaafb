"""A comparison as parts of a page: of the report of a run, or of a page of its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from study.compare.comparison import Comparison, Comparisons, verdict_of
from study.compare.graph import draw_both
from study.compare.grids import (
    inputs_grid,
    measures_grid,
    meets_grid,
    moved_grid,
    moved_matrix,
    once_grid,
    rows_grid,
)
from study.compare.measures import TABLES
from study.compare.side import Side
from study.report.parts import Part
from study.report.style import svg_of

OPEN_ROWS: Final = 40  # longer tables are folded
_GRAPH_HELP: Final = (
    "Trains that moved: thick in colour as they ran, thin and dashed as they ran in the other run."
    " Pale: not moved."
)
_ROWS: Final = {
    "margins": (
        "Margins that differ",
        "As planned over the least running time, and what was left on arrival.",
        "余裕時分の相違",
        "計画の余裕（最小運転時分に対する）と、到着時に残った余裕",
    ),
    "energy": (
        "Energy by train",
        "What differs, the largest difference first.",
        "列車別電力量",
        "相違のあるもの、差の大きい順",
    ),
    "driving": (
        "Driving by hop",
        "Traction less what came back, notches, coasting and arrival; the largest difference first.",
        "駅間ごとの運転",
        "力行から回生を引いた電力量、ノッチ、惰行、到着。差の大きい順",
    ),
    "telegrams": ("Telegrams by kind", "", "電文の種別", ""),
    "stops": (
        "Stops at the mark",
        "Errors that differ by a millimetre or more; beyond the mark is positive.",
        "停止位置",
        "誤差が 1 mm 以上異なるもの。行き過ぎが正",
    ),
}


def parts_against(found: Comparisons, index: int = 0, *, graphs: bool = True) -> tuple[Part, ...]:
    """What changed from the first run to one of the others, in the order in which a planner reads it.

    The report of a run leaves out the picture of both `graphs`: its own graph shows the other run. Call within
    `study.report.style.drawing`.
    """
    pair, base, new = found.pairs[index], found.sides[0], found.sides[index + 1]
    two = found.of_two(index)
    first = Part(
        f"What changed against {base.label}",
        " ".join(verdict_of(pair)),
        grids=(measures_grid(two),),
        title_ja=f"{base.label} からの変化",
    )
    if pair.nothing_differs:
        return (first,)
    listed = [
        Part(
            "Inputs that differ",
            _inputs_text(pair),
            grids=(inputs_grid(pair),),
            title_ja="入力の相違",
            caption_ja=f"{len(pair.inputs):,} 件（両走行の変更指定を反映）",
        ),
        Part(
            "Times that moved",
            f"Seconds by which arrival / departure moved, where by more than {pair.over_s:g} s; + is later in"
            f" {new.label}.",
            grids=(moved_matrix(pair, new),),
            title_ja="変化した着発時刻",
            caption_ja=f"着／発の変化（秒、{pair.over_s:g} 秒を超えるもの）。＋は {new.label} の方が遅い",
        ),
        Part("Every time that moved", "", grids=(moved_grid(pair, new),), title_ja="変化した着発時刻の一覧"),
        Part(
            "Came in one run only",
            "Of trains that run in both.",
            grids=(once_grid(pair, new),),
            title_ja="一方の走行だけの着発",
            caption_ja="両走行に共通の列車のもの",
        ),
        Part(
            "Meets that moved",
            "As run: where and when the fronts passed.",
            grids=(meets_grid(pair, base, new),),
            title_ja="変化した行違い",
            caption_ja="走行実績で、列車の先頭どうしがすれ違った時刻と場所",
        ),
        *(_of_table(pair, table, new) for table in TABLES),
    ]
    both = (
        (Part("Both train graphs", _GRAPH_HELP, (svg_of(draw_both(base, new, pair), f"both{index}"),)),)
        if graphs
        else ()
    )
    return (first, *both, *(_folded(part) for part in listed if part.grids[0].rows))


def _of_table(pair: Comparison, table: str, new: Side) -> Part:
    """What differs in one of the tables."""
    title, caption, title_ja, caption_ja = _ROWS[table]
    return Part(
        title, caption, grids=(rows_grid(pair, table, new),), title_ja=title_ja, caption_ja=caption_ja
    )


def _folded(part: Part) -> Part:
    """A long table is folded; its line says how long."""
    count = len(part.grids[0].rows)
    return part if count <= OPEN_ROWS else replace(part, folded=f"{count:,} rows")


def _inputs_text(pair: Comparison) -> str:
    count = len(pair.inputs)
    return f"{count:,} {'difference' if count == 1 else 'differences'}, the patches of both runs carried out."
