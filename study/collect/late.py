"""What was drawn for a late day, and what it came to, for summary.json and the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from network.clock import clock
from simulation.late_day import DrawnDisturbance, counts_of, late_day
from simulation.result import RunResult
from simulation.setup import Setup
from study.measures.day_figures import late_figures
from study.record.parts import PagePart, TextTable
from study.wording.catalogue import phrase
from study.wording.parties import party
from study.wording.phrase import Language

_HEAD: Final = (
    phrase("when"),
    phrase("who"),
    phrase("where"),
    phrase("seconds"),
    phrase("what", "drill"),
    phrase("drawn from"),
)


def late_summary(result: RunResult, setup: Setup) -> dict[str, Any]:
    """The key `late`: every thing drawn in a sentence, how many from each table, and whose fault lateness was, s."""
    day, figures = late_day(setup), late_figures(result, setup)
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
    counted = ", ".join(f"{number} from {source}" for source, number in counts_of(day).items())
    caption = phrase(
        "Seed {seed} draws this, and the same again: {counted}. When: the planned time that it is about."
    ).fill(seed=setup.seed, counted=counted)
    folded = phrase("{count} things drawn").fill(count=len(day.drawn))
    title = phrase("What was drawn for this day")
    return PagePart(
        title.en,
        caption.en,
        grids=(_grid(setup, day.drawn, "en"),),
        folded=folded.en,
        folded_ja=folded.ja,
        grids_ja=(_grid(setup, day.drawn, "ja"),),
        title_ja=title.ja,
        caption_ja=caption.ja,
    )


def _grid(setup: Setup, drawn: Sequence[DrawnDisturbance], language: Language) -> TextTable:
    rows = tuple(
        (
            "" if one.at_s is None else clock(int(one.at_s)),
            party(one.who).in_(language),
            one.place if language == "en" else _place(setup, one.place),
            f"{one.seconds:.1f}",
            one.what if language == "en" else _what(setup, one),
            f"{one.source}: {one.of}",
        )
        for one in drawn
    )
    return TextTable(tuple(name.in_(language) for name in _HEAD), rows, 3, 4)


def _what(setup: Setup, one: DrawnDisturbance) -> str:
    """What was drawn, in Japanese."""
    form = phrase(one.source.split(".")[1], "drawn").ja
    return form.format(who=party(one.who).in_("ja"), place=_place(setup, one.place), seconds=one.seconds)


def _place(setup: Setup, place: str) -> str:
    station = setup.line.stations.get(place)
    return place if station is None else station.name_ja or station.name
