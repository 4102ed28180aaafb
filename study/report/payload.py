"""What the page knows of a run: one object of plain data, which the modules under `web` draw and tabulate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeAlias

from network.files.raw import is_table
from onboard.driving.tuning import OFFSET_STEP_MPS2, OFFSET_ZERO, STEP_S
from study.report.courses import Fineness, blocks_shown, courses_shown, devices_shown, line_shown, sections_shown, trains_shown
from study.report.data import Run
from study.report.drill import DrillShown, Mark
from study.report.packing import packed, places_in
from study.report.papers import tables_shown
from study.report.tasc import KMHPS_PER_MPS2, Tuned, most_telling, response_surface, waves_shown

FORMAT: Final = 1

# Of each stock, stretches of time (from, to, s) with one sentence each, in English and in Japanese.
Waits: TypeAlias = Mapping[str, Sequence[tuple[float, float, str, str]]]


def payload_of(
    run: Run,
    facts: Mapping[str, Any],
    tuned: Mapping[str, Tuned],
    drill: DrillShown | None,
    waits: Waits,
) -> dict[str, Any]:
    """Everything but the courses of trains; those come with `courses_of`, by their fineness."""
    begin_s, end_s = run.window_s
    return {
        "format": FORMAT,
        "line": line_shown(run.line),
        "window": [begin_s, end_s],
        "trains": trains_shown(run),
        "sections": sections_shown(run),
        "devices": devices_shown(run.line),
        "blocks": blocks_shown(run),
        "marks": [] if drill is None else [_mark(mark) for mark in drill.marks],
        "broken": _broken_at(facts),
        "waits": waits_shown(waits),
        "tuning": _tuning(tuned),
        "tables": [table.as_dict() for table in tables_shown(run, facts, tuned, drill)],
    }


def courses_of(run: Run, fineness: Fineness) -> dict[str, Any]:
    """The courses of trains as fine as asked, and how fine that is."""
    tolerance = {"m": fineness.place_m, "kmh": fineness.speed_kmh, "notch": fineness.notch}
    return {"courses": courses_shown(run, fineness), "tolerance": tolerance}


def _mark(mark: Mark) -> dict[str, Any]:
    return {
        "label": mark.label,
        "kind": mark.kind.value,
        "text": mark.text,
        "from": _finite(mark.from_s),
        "to": _finite(mark.to_s),
        "at": None if mark.at_s is None else _finite(mark.at_s),
        "passed": mark.passed,
        "happened": mark.happened,
    }


def _finite(value: float) -> float | None:
    return round(value, 1) if math.isfinite(value) else None


def _broken_at(facts: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Broken invariants that have a time, for their marks on the graph."""
    return [
        {"t": _finite(item["t_s"]), "checker": str(item.get("checker", "")), "text": str(item.get("text", ""))}
        for item in facts.get("violations", ())
        if is_table(item) and item.get("t_s") is not None
    ]


def waits_shown(waits: Waits) -> dict[str, Any]:
    """Sentences once each, and for each stock when which of them held; whole seconds."""
    spans = [(unit, *span) for unit, all_of in waits.items() for span in all_of]
    pairs = [(en, ja) for _, _, _, en, ja in spans]
    distinct = list(dict.fromkeys(pairs))
    place = {pair: i for i, pair in enumerate(distinct)}
    units, of = places_in([unit for unit, *_ in spans])
    return {
        "en": [en for en, _ in distinct],
        "ja": [ja for _, ja in distinct],
        "units": units,
        "unit": of,
        "from": packed([from_s for _, from_s, *_ in spans], 1),
        "to": packed([to_s for _, _, to_s, *_ in spans], 1),
        "text": [place[pair] for pair in pairs],
    }


def _tuning(tuned: Mapping[str, Tuned]) -> dict[str, Any] | None:
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
        "designed": packed(designed, 1000),
        "actual": packed(actual, 1000),
        "smooth": packed(smooth, 1000),
    }
