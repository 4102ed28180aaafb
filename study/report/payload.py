"""What the page knows of a run: one object of plain data, which the modules under `web` draw and tabulate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from network.raw import is_table
from onboard.driving.tuning import OFFSET_STEP_MPS2, OFFSET_ZERO, STEP_S
from study.measures.wait_text import text_of
from study.record.columns import tenth
from study.record.figure import rows_in
from study.record.marks import DrillShown, Mark
from study.record.parts import PagePart
from study.record.shown import LearnedTrain
from study.record.wait import NO_WAIT, Wait
from study.report.beside import Beside
from study.report.bundle import words_of_the_page
from study.report.courses import (
    Fineness,
    bare_courses_shown,
    blocks_shown,
    courses_shown,
    devices_shown,
    line_shown,
    sections_shown,
    trains_shown,
)
from study.report.data import ReportedRun
from study.report.packing import packed_column, places_in
from study.report.papers import ROWS_OF_THE_PAGE, tables_shown
from study.report.pictures import PALETTE, PICTURES
from study.report.stairway import stairway_shown
from study.report.tabular import headed_column
from study.report.tasc import KMHPS_PER_MPS2, most_telling, response_surface, waves_shown
from study.wording.catalogue import phrase
from study.wording.outcome import checker_name
from study.wording.phrase import names_of

FORMAT: Final = 1


@dataclass(frozen=True, slots=True)
class PageContents:
    """What a page shows besides a run and its figures; see `study.report.report.write_report`."""

    tuned: Mapping[str, LearnedTrain] = field(default_factory=dict[str, LearnedTrain])
    drill: DrillShown | None = None
    first: tuple[PagePart, ...] = ()
    beside: Beside | None = None


def payload_of(run: ReportedRun, facts: Mapping[str, Any], shows: PageContents) -> dict[str, Any]:
    """Everything but the courses of trains; those come with `courses_of`, by their fineness."""
    begin_s, end_s = run.window_s
    tuned, drill = shows.tuned, shows.drill
    return {
        "format": FORMAT,
        "words": words_of_the_page(),
        "palette": PALETTE,
        "pictures": {name: picture.for_page() for name, picture in PICTURES.items()},
        "line": line_shown(run.line),
        "window": [begin_s, end_s],
        "due": facts.get("latest_end_s"),  # what is planned for later is not missing
        "trains": trains_shown(run),
        "sections": sections_shown(run),
        "devices": devices_shown(run.line),
        "blocks": blocks_shown(run),
        "stairway": stairway_shown(run),
        "marks": [] if drill is None else [_mark(mark) for mark in drill.marks],
        "broken": _broken_at(facts),
        "waits": waits_shown(run),
        "tuning": _tuning(tuned),
        "columns": {
            name: {
                "title": title.both,
                "columns": [headed_column(label, figure) for label, figure in figures.items()],
            }
            for name, (title, figures) in ROWS_OF_THE_PAGE.items()
        },
        "tables": [table.as_dict() for table in tables_shown(run, facts, tuned, drill)],
    }


def courses_of(run: ReportedRun, fineness: Fineness, beside: Beside | None = None) -> dict[str, Any]:
    """The courses of trains as fine as asked, and how fine that is; of a run beside it those that moved or are gone."""
    tolerance = {"m": fineness.place_m, "kmh": fineness.speed_kmh, "notch": fineness.notch}
    other = None
    if beside is not None:
        shown = beside.moved | beside.gone
        curves = bare_courses_shown(beside.run, fineness, shown)
        other = {
            "label": beside.label,
            "moved": sorted(beside.moved),
            "gone": sorted(beside.gone),
            "courses": curves,
        }
    return {"courses": courses_shown(run, fineness), "tolerance": tolerance, "beside": other}


def _mark(mark: Mark) -> dict[str, Any]:
    return {
        "label": mark.label,
        "kind": mark.kind.value,
        "text": mark.said.both,
        "from": tenth(mark.from_s),
        "to": tenth(mark.to_s),
        "at": tenth(mark.at_s),
        "stretches": [[round(low, 1), round(high, 1)] for low, high in mark.where.stretches_m],
        "units": list(mark.where.units),
        "passed": mark.passed,
        "happened": mark.became.both,
    }


def _broken_at(facts: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Broken invariants that have a time, for their marks on the graph."""
    return [
        {
            "t": tenth(item["t_s"]),
            "kind": phrase("broken invariant").both,
            "checker": checker_name(str(item.get("checker", ""))).both,
            "text": [str(item.get("text", "")), str(item.get("ja") or item.get("text", ""))],
        }
        for item in facts.get("violations", ())
        if is_table(item) and item.get("t_s") is not None
    ]


def waits_shown(run: ReportedRun) -> dict[str, Any]:
    """Why each stock waited, and when: sentences once each, in both languages; whole seconds."""
    names = names_of(run.line)
    waits = [wait for wait in rows_in(Wait, run.tables.waits) if wait.cause not in NO_WAIT]
    sentences = [text_of(wait, names) for wait in waits]
    distinct = list(dict.fromkeys(sentences))
    place = {sentence: i for i, sentence in enumerate(distinct)}
    units, of = places_in([wait.unit for wait in waits])
    return {
        "said": [sentence.both for sentence in distinct],
        "units": units,
        "unit": of,
        "from": packed_column([wait.from_s for wait in waits], 1),
        "to": packed_column([wait.to_s for wait in waits], 1),
        "text": [place[sentence] for sentence in sentences],
    }


def _tuning(tuned: Mapping[str, LearnedTrain]) -> dict[str, Any] | None:
    """The evaluation function of the stop of the train that differs most from its design, with its waves."""
    unit = most_telling(tuned)
    if unit is None:
        return None
    one = tuned[unit]
    surface = response_surface(one.stop)
    if surface is None:
        return None
    designed, actual, smooth = waves_shown(one.stop)
    return {
        "unit": unit,
        "step_s": STEP_S,
        "step_kmhps": round(OFFSET_STEP_MPS2 * KMHPS_PER_MPS2, 6),
        "zero": OFFSET_ZERO,
        "surface": [[round(float(value), 7) for value in row] for row in surface],
        "designed": packed_column(designed, 1000),
        "actual": packed_column(actual, 1000),
        "smooth": packed_column(smooth, 1000),
    }
