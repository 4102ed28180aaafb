"""What was drawn for a late day, and what it came to, for summary.json and the report."""

from __future__ import annotations

from typing import Any

from network.clock import clock
from simulation.late_day import DrawnDisturbance, counts_of, late_day
from simulation.result import RunResult
from simulation.setup import Setup
from study.measures.day_figures import day_figures
from study.record.parts import PagePart, TextTable
from study.wording.outcome import DRAWN
from study.wording.parties import party

_HEAD_JA = ("時刻", "列車・装置", "場所", "秒", "内容", "分布")
_HEAD = ("when", "who", "where", "seconds", "what", "drawn from")


def late_summary(result: RunResult, setup: Setup) -> dict[str, Any]:
    """The key `late`: every thing drawn in a sentence, how many from each table, and whose fault lateness was, s."""
    day, figures = late_day(setup), day_figures(result, setup)
    return {
        "drawn": [one.sentence for one in day.drawn],
        "counts": counts_of(day),
        "within": list(figures.within),
        "mean_late_s": figures.mean_late_s,
        "primary_s": figures.primary_s,
        "secondary_s": figures.secondary_s,
        "other_s": figures.other_s,
        "primary_delays": figures.primary_delays,
        "recovery_s": figures.recovery_s,
        "recovery_mean_s": figures.recovery_mean_s,
        "late_time_s": figures.late_time_s,
        "recovered": figures.recovered,
        "deadlock": list(figures.deadlock),
    }


def late_part(setup: Setup) -> PagePart | None:
    """The report's part with everything that was drawn; None on a day for which nothing was."""
    day = late_day(setup)
    if not day.drawn:
        return None
    rows = tuple(
        (_clock(one), one.who, one.place, f"{one.seconds:.1f}", one.what, _from(one)) for one in day.drawn
    )
    said = [(one, DRAWN[one.source.split(".")[1]], _place(setup, one.place)) for one in day.drawn]
    rows_ja = tuple(
        (
            _clock(one),
            party(one.who).in_("ja"),
            place,
            f"{one.seconds:.1f}",
            form.format(who=party(one.who).in_("ja"), place=place, seconds=one.seconds),
            _from(one),
        )
        for one, form, place in said
    )
    counted = ", ".join(f"{number} from {source}" for source, number in counts_of(day).items())
    return PagePart(
        "What was drawn for this day",
        f"Seed {setup.seed} draws this, and the same again: {counted}. When: the planned time that it is about.",
        grids=(TextTable(_HEAD, rows, 3, 4),),
        folded=f"{len(rows)} things drawn",
        folded_ja=f"{len(rows)} 件",
        grids_ja=(TextTable(_HEAD_JA, rows_ja, 3, 4),),
        title_ja="この日に生じさせた遅れの原因",
        caption_ja=f"乱数の種 {setup.seed} から決まり、同じ種では同じになる。時刻はその計画上の時刻",
    )


def _clock(one: DrawnDisturbance) -> str:
    return "" if one.at_s is None else clock(int(one.at_s))


def _from(one: DrawnDisturbance) -> str:
    return f"{one.source}: {one.of}"


def _place(setup: Setup, place: str) -> str:
    station = setup.line.stations.get(place)
    return place if station is None else station.name_ja or station.name
