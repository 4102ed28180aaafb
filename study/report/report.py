"""The run report: one HTML file with every figure inside it, which opens offline and prints.

Figures come from `study.report.graph`, `_curve`, `_occupancy` and `_charts`; this module gathers them with
the tables of the page and fills `templates/report.html.j2`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import polars as pl
from jinja2 import Environment, PackageLoader, StrictUndefined

from network.files.raw import is_table
from network.model import Line
from network.timetable import Timetable
from study.report.charts import draw_delays, draw_stop_errors
from study.report.curve import chosen_trains, draw_run_curve
from study.report.data import Run
from study.report.drill import DrillShown, MarkKind, expectation_rows, item_rows
from study.report.energy import energy_fact, energy_parts, place_name
from study.report.face import FACE, japanese_face
from study.report.graph import draw_train_graph
from study.report.margins import margin_fact, margin_part
from study.report.occupancy import draw_occupancy
from study.report.parts import Fact, Grid, Part
from study.report.style import clock, drawing, svg_of
from study.report.tasc import Tuned, draw_approaches, draw_response, learned_rows, most_telling
from study.run.summary import TELEGRAM_COUNTS, summarise
from study.run.tables import RunTables

REPORT_FILE: Final = "report.html"
EVENTS_SHOWN: Final = 200
CHANGES_SHOWN: Final = 200
CHANGES_OPEN: Final = 20  # more are folded
DRILL_HELP: Final = (
    " Faults are red bands (F), acts dashed lines (A); below, each has a row of its own, and so has each expectation"
    " (E): grey is the stretch judged, a green dot where it was met, a red cross where it was not."
)


def write_report(
    directory: Path,
    line: Line,
    timetable: Timetable,
    tables: RunTables,
    summary: Mapping[str, Any],
    tuned: Mapping[str, Tuned] | None = None,
    drill: DrillShown | None = None,
    first: Sequence[Part] = (),
) -> Path:
    """Write `report.html` into `directory` and return its path; written aside, then renamed.

    `summary` holds what the tables cannot tell, each key optional: "scenario", "day", "seed", "digest",
    "parties" (names), "violations" (invariants broken: text, or objects with t_s, checker and text),
    "invariants_broken" (how many, with those that a train has not arrived), "broken" (text: what else makes it a
    failure), "broken_expectations" (text: what a drill expected), "changes" (objects with file, key, old and new),
    "ended_because" (text), "unfinished" (texts: what was missing then) and "outside_design" (texts). Figures of
    `study.run.summary.summarise` found in it are used as they are.
    `tuned` is what each train learned of its stops, by unit; `drill` what the run was a drill of,
    `first` parts that come before all others.
    Raises OSError when the file cannot be written.
    """
    run = Run(line, timetable, tables)
    facts = {**summarise(tables, timetable), **summary}
    with drawing():
        parts = _parts(run, facts, tuned or {}, drill)
    environment = Environment(
        loader=PackageLoader("study", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html.j2").render(
        line=line,
        subtitle=_subtitle(timetable, facts),
        headline=(*_drill_facts(drill), *_headline(run, facts)),
        broken=_broken(facts),
        parts=(*first, *parts),
        assumed=(*line.assumed, *timetable.assumed),
    )
    page = page.replace(FACE, japanese_face(page), 1)
    directory.mkdir(parents=True, exist_ok=True)
    aside, path = directory / f".{REPORT_FILE}.part", directory / REPORT_FILE
    aside.write_text(page, encoding="utf-8")
    return aside.replace(path)


def _subtitle(timetable: Timetable, facts: Mapping[str, Any]) -> str:
    words = [timetable.name or timetable.id, facts.get("day"), facts.get("scenario")]
    return " · ".join(str(word) for word in dict.fromkeys(words) if word)


def _headline(run: Run, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The figures a planner looks for first."""
    planned, arrived = facts["trains_planned"], facts["trains_arrived"]
    telegrams = facts["telegrams"]
    return (
        Fact("Trains arrived", f"{arrived} of {planned} planned", arrived < planned),
        _invariants(facts),
        *_ending(facts),
        *_lateness(run, facts),
        *margin_fact(run, facts),
        Fact("Stops", _stops(facts)),
        energy_fact(facts, run.tables.energy),
        Fact("Telegrams", ", ".join(f"{telegrams[name]:,} {name}" for name in TELEGRAM_COUNTS)),
        Fact("Parties", ", ".join(str(party) for party in facts.get("parties", ())) or "not recorded"),
        Fact("Seed", str(facts.get("seed", "not recorded"))),
        Fact("Journal digest", str(facts.get("digest", "not recorded"))),
        Fact("Motion digest", str(facts.get("motion_digest", "not recorded"))),
    )


def _lateness(run: Run, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The latest arrival or departure and the earliest departure, each with its place in the table of delays."""

    def where(at: Mapping[str, Any] | None) -> str:
        return "" if at is None else f", {at['what']} of {at['train']} at {place_name(run, at['station'])}"

    late_s, early_s = facts["late_s_max"], float(facts["early_departure_s_max"])
    missing = facts["trains_planned"] - facts["trains_arrived"]
    if late_s is None:
        latest = Fact("Worst lateness", "no train arrived", bad=True)
    else:
        text = f"{late_s:.0f} s{where(facts.get('late_at'))}" if late_s > 0.0 else "none late"
        more = f" of what ran; {missing} train{'s' if missing > 1 else ''} did not arrive" if missing else ""
        latest = Fact("Worst lateness", text + more, missing > 0)
    before = f"{early_s:.0f} s before plan{where(facts.get('early_at'))}" if early_s else "none before plan"
    return latest, Fact("Earliest departure", before, early_s >= 1)


def _invariants(facts: Mapping[str, Any]) -> Fact:
    """How many rules were broken; that a train has not arrived is one, and said apart."""
    named = len(facts.get("violations", ()))
    all_of_them = max(int(facts.get("invariants_broken", named)), named)
    missing = all_of_them - named
    if not all_of_them:
        return Fact("Invariants broken", "none")
    apart = f", {missing} of them that a train has not arrived" if missing else ""
    return Fact("Invariants broken", f"{all_of_them}{apart}", bad=True)


def _ending(facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """Why the run ended, and that something was missing then."""
    if "ended_because" not in facts:
        return ()
    return (Fact("Ended because", str(facts["ended_because"]), bool(facts.get("unfinished"))),)


def _drill_facts(drill: DrillShown | None) -> tuple[Fact, ...]:
    return () if drill is None else (Fact("Drill", drill.verdict(), not drill.passed),)


def _drill_part(drill: DrillShown) -> Part:
    """What was done to the line, what was expected, and what became of it."""
    items = item_rows(drill.of(MarkKind.FAULT, MarkKind.ACT))
    judged = expectation_rows(drill.of(MarkKind.EXPECTATION))
    grids = [Grid(("", "expected", "verdict", "what happened"), judged)]
    if items:
        grids.insert(0, Grid(("", "fault or act", "begun", "over"), items))
    return Part("Drill", drill.score, grids=tuple(grids))


def _stops(facts: Mapping[str, Any]) -> str:
    mean_m, sigma_m, worst_m = (facts[f"stop_error_m_{name}"] for name in ("mean", "sigma", "max_abs"))
    if mean_m is None:
        return "none measured"
    sigma = "" if sigma_m is None else f", σ {sigma_m:.3f} m"
    return f"{facts['stops']}: mean {mean_m:+.3f} m{sigma}, worst {worst_m:.3f} m from the mark".replace(
        "-", "−"
    )


def _broken(facts: Mapping[str, Any]) -> tuple[str, ...]:
    """Broken invariants, what else failed, what happened outside the design, unmet expectations, as lines of text."""
    lines: list[str] = []
    for item in facts.get("violations", ()):
        if is_table(item):
            at = f"{clock(item['t_s'], seconds=True)} " if item.get("t_s") is not None else ""
            lines.append(f"{at}{item.get('checker', '')}: {item.get('text', '')}")
        else:
            lines.append(str(item))
    lines += [str(text) for text in facts.get("broken", ())]
    lines += [f"Outside the design: {text}" for text in facts.get("outside_design", ())]
    return (*lines, *(f"Expected: {text}" for text in facts.get("broken_expectations", ())))


def _parts(
    run: Run, facts: Mapping[str, Any], tuned: Mapping[str, Tuned], drill: DrillShown | None
) -> tuple[Part, ...]:
    """Every part of the report, in the order in which a planner reads them."""
    graph, tips = draw_train_graph(run, () if drill is None else drill.marks)
    parts = [] if drill is None else [_drill_part(drill)]
    parts += [
        Part(
            "Train graph",
            "Plan thin, run thick; blue runs down, orange up, dashed carries no passengers; dotted links are"
            f" turn-rounds, red crosses are interventions of supervision.{'' if drill is None else DRILL_HELP}",
            (svg_of(graph, "graph", tips),),
        )
    ]
    for index, (unit, train) in enumerate(chosen_trains(run)):
        parts.append(
            Part(
                f"Run curve: {train}, unit {unit}, {run.directions[train].name.lower()}",
                "The latest of the most complete trains of its direction, running from left to right;"
                " gradient and curves as the train meets them (climbing and right-hand above the line).",
                (svg_of(draw_run_curve(run, unit, train), f"curve{index}"),),
            )
        )
    occupancy = svg_of(draw_occupancy(run), "occupancy")
    parts.append(
        Part(
            "Section occupancy",
            "By the manager's register (pale) and in truth (solid), by unit.",
            (occupancy,),
        )
    )
    parts.extend(energy_parts(run, facts))
    parts.extend(margin_part(run))
    for title, caption, figure in (
        ("Stop errors", "Bars by station are means.", draw_stop_errors(run, facts)),
        (
            "Stopping",
            "The last 400 m of every stop at a mark, by unit: what the train ran and what its target-speed pattern"
            " asked for.",
            draw_approaches(run),
        ),
        (
            "Delays",
            "Seconds after plan, arrival/departure (minus: before it), in the colour of the worse of both. To arrive"
            " early is no fault where whole minutes are planned; a departure before its time is red.",
            draw_delays(run),
        ),
    ):
        svg = () if figure is None else (svg_of(figure, title.split()[0].lower()),)
        parts.append(Part(title, caption if svg else "Nothing to show: the run has none.", svg))
    parts.extend(_tuning_part(tuned))
    parts.extend(_changes_part(facts.get("changes", ())))
    parts.append(Part("Trains", "", grids=(_train_grid(run),), folded="Plan and run of every train"))
    return (*parts, _telegram_part(run.tables.telegrams), _event_part(run.tables.events))


def _changes_part(changes: Sequence[Mapping[str, Any]]) -> tuple[Part, ...]:
    """What a what-if has changed of the files it names; nothing where it changed nothing."""
    if not changes:
        return ()
    shown = tuple(
        (str(c["file"]), str(c["key"]), _value(c["old"]), _value(c["new"])) for c in changes[:CHANGES_SHOWN]
    )
    rest = len(changes) - len(shown)
    return (
        Part(
            "What was changed",
            f"{len(changes):,} {'difference' if len(changes) == 1 else 'differences'} from the files that the scenario"
            " names and extends.",
            grids=(Grid(("file", "key", "old", "new"), shown),),
            folded="" if len(shown) <= CHANGES_OPEN else "File, key, old and new value",
            notes=(f"and {rest:,} more in summary.json",) if rest else (),
        ),
    )


def _value(value: object) -> str:
    """A value as the files write it, tables in one line; a dash where there is none."""
    return "–" if value is None else json.dumps(value, ensure_ascii=False)


def _tuning_part(tuned: Mapping[str, Tuned]) -> tuple[Part, ...]:
    """What the trains have learned of their brakes; nothing where none learned."""
    unit = most_telling(tuned)
    if unit is None:
        return ()
    figure = draw_response(tuned[unit], unit)
    header = (
        "unit",
        "stops counted",
        "left out",
        "dead time designed, s",
        "learned, s",
        "offset learned, km/h/s",
    )
    return (
        Part(
            "Self-tuning",
            "What each train has learned of its brake from its own stops, and the response surface of the one that"
            " differs most from its design.",
            () if figure is None else (svg_of(figure, "tuning"),),
            (Grid(header, learned_rows(tuned), numbers_from=1),),
        ),
    )


def _train_grid(run: Run) -> Grid:
    """One row a train: unit, plan and truth of its first departure and last arrival."""
    first_last = {
        train: (rows["unit"][0], rows["departure_s"][0], rows["arrival_s"][-1])
        for (train,), rows in run.tables.stops.group_by("train", maintain_order=True)
    }
    rows: list[tuple[str, str, str, str, str, str, str, str]] = []
    for number in run.trains:
        planned = run.timetable.trains.get(number)
        unit, left_s, came_s = first_last.get(number, ("did not run", None, None))
        calls = planned.calls if planned else ()
        names = [run.line.stations[call.station_id].name for call in calls]
        rows.append(
            (
                number,
                str(unit),
                run.directions[number].name.lower(),
                f"{names[0]} – {names[-1]}" if names else "not in the timetable",
                _time(calls[0].last_s if calls else None),
                _time(left_s),
                _time(calls[-1].first_s if calls else None),
                _time(came_s),
            )
        )
    header = ("train", "unit", "direction", "from – to", "planned", "departed", "planned", "arrived")
    return Grid(header, tuple(rows), numbers_from=4)


def _time(time_s: float | None) -> str:
    return "–" if time_s is None else clock(time_s, seconds=True)


def _telegram_part(telegrams: pl.DataFrame) -> Part:
    counts = [*TELEGRAM_COUNTS, "bytes"]

    def grid(key: str, title: str) -> Grid:
        sums = telegrams.group_by(key).agg(pl.col(counts).sum()).sort(key)
        rows = tuple((str(row[0]), *(f"{value:,}" for value in row[1:])) for row in sums.iter_rows())
        return Grid((title, *counts), rows, numbers_from=1)

    return Part(
        "Telegrams",
        "Lost by the air, dropped by the receiver's checks.",
        grids=(grid("kind", "kind"), grid("source", "sent by"), grid("destination", "sent to")),
    )


def _event_part(events: pl.DataFrame) -> Part:
    shown = events.sort("t_s", maintain_order=True).head(EVENTS_SHOWN)
    rows = tuple(
        (clock(t_s, seconds=True), source, kind, text)
        for t_s, source, kind, text in shown.select("t_s", "source", "kind", "text").iter_rows()
    )
    kinds = events.group_by("kind").len().sort("len", "kind", descending=[True, False]).iter_rows()
    caption = (
        ", ".join(f"{count:,} {kind}" for kind, count in kinds) or "None: no intervention, refusal or fault."
    )
    rest = len(events) - len(shown)
    notes: Sequence[str] = (f"and {rest:,} more in events.parquet",) if rest else ()
    grids = (Grid(("time", "source", "kind", "text"), rows),) if rows else ()
    return Part("Events", caption, grids=grids, notes=tuple(notes))
