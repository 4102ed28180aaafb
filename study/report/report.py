"""The run report: one HTML file with everything inside it, which opens offline, is pointed at, searched and printed.

`payload` says what the page knows, `bundle` brings the modules of `web` that draw it, and this module fits the two and
the headline into `templates/report.html.j2`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from markupsafe import Markup

from network.model import Line
from network.timetable import Timetable
from study.measures.summary import summarise
from study.record.directory import INCOMPLETE_FILE, REPORT_FILE
from study.record.marks import DrillShown
from study.record.parts import PagePart
from study.record.read_back import RunRead
from study.record.shown import LearnedTrain
from study.record.tables import RunTables
from study.report.beside import Beside
from study.report.bundle import import_map, modules, style_sheet
from study.report.courses import FINEST_FIRST
from study.report.data import ReportedRun
from study.report.face import FACE, japanese_face
from study.report.facts import broken_lines, headline
from study.report.packing import deflated
from study.report.payload import PageContents, courses_of, payload_of
from study.report.template import rendered
from study.wording.assumptions import assumption

BYTES_AIMED: Final = 1_000_000


def write_report(
    directory: Path,
    line: Line,
    timetable: Timetable,
    tables: RunTables,
    summary: Mapping[str, Any],
    tuned: Mapping[str, LearnedTrain] | None = None,
    drill: DrillShown | None = None,
    first: Sequence[PagePart] = (),
    beside: Beside | None = None,
) -> Path:
    """Write `report.html` into `directory` and return its path; written aside, then renamed.

    `summary` holds what the tables cannot tell, each key optional: "scenario", "day", "seed", "digest",
    "parties" (names), "violations" (invariants broken: text, or objects with t_s, checker and text),
    "invariants_broken" (how many, with those that a train has not arrived), "broken" (text: what else makes it a
    failure), "broken_expectations" (text: what a drill expected), "changes" (objects with file, key, old and new),
    "ended_because" (text), "unfinished" (texts: what was missing then) and "outside_design" (texts). Figures of
    `study.measures.summary.summarise` found in it are used as they are.
    `tuned` is what each train learned of its stops, by unit; `drill` what the run was a drill of; `first` parts that
    come before all others, such as what changed against the run `beside`, which the train graph shows too.
    Raises OSError when the file cannot be written.
    """
    run = ReportedRun(line, timetable, tables)
    facts = {**summarise(tables, timetable), **summary}
    page = page_of(run, facts, PageContents(tuned or {}, drill, tuple(first), beside))
    directory.mkdir(parents=True, exist_ok=True)
    aside, path = directory / f".{REPORT_FILE}.part", directory / REPORT_FILE
    aside.write_text(page, encoding="utf-8")
    return aside.replace(path)


def page_of(run: ReportedRun, facts: Mapping[str, Any], shows: PageContents) -> str:
    """The page, with curves as fine as its size allows: the finest that keeps it within `BYTES_AIMED`."""
    payload = payload_of(run, facts, shows)
    page = rendered(
        "report.html.j2",
        line=run.line,
        subtitle=_subtitle(run.timetable, facts),
        headline=headline(run, facts, shows.drill),
        broken=broken_lines(facts),
        parts=shows.first,
        assumed=[assumption(text, run.line) for text in (*run.line.assumed, *run.timetable.head.assumed)],
        style=style_sheet(),
        payload=deflated(payload),
        courses=_COURSES,
        import_map=import_map(),
    )
    # What is packed is read by eyes, too: its characters count for the font.
    shown = "".join((page, json.dumps(payload, ensure_ascii=False), *modules().values()))
    page = page.replace(FACE, japanese_face(shown), 1)
    room = BYTES_AIMED - len(page.encode("utf-8")) + len(_COURSES)
    courses = ""
    for fineness in FINEST_FIRST:
        courses = deflated(courses_of(run, fineness, shows.beside))
        if len(courses) <= room:
            break
    return page.replace(_COURSES, courses, 1)


_COURSES: Final = Markup("<!-- courses of trains -->")  # no name can hold it: names are escaped


def _subtitle(timetable: Timetable, facts: Mapping[str, Any]) -> str:
    words = [timetable.head.name or timetable.head.id, facts.get("day"), facts.get("scenario")]
    return " · ".join(str(word) for word in dict.fromkeys(words) if word)


def report_again(run: RunRead, folder: Path) -> Path:
    """Write the report of a run that was read back; the same as the first one but for the courses of a run that it was
    compared with. In the run's own directory it makes that whole. Returns the report's path.
    """
    facts = run.shown.facts(run.summary, run.inputs)
    tuned = run.shown.tuned(run.learned)
    report = write_report(
        folder, run.line, run.timetable, run.tables, facts, tuned, run.shown.drill, run.shown.parts
    )
    (folder / INCOMPLETE_FILE).unlink(missing_ok=True)
    return report
