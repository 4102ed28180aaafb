"""Real runs of the paper's test line as the documentation shows them: who said what when, and table 3 by restarts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import polars as pl

from network.timetable import clock
from simulation.faults.devices import PowerOff
from simulation.faults.links import ANY, Cut
from simulation.faults.links import Link as RadioLink
from simulation.faults.script import Failure, Script, Trigger, matcher_of
from study.run.run import Link, Run, execute
from study.scenario.scenario import Scenario, load_scenario
from wayside.config import MANAGER_ID

Entry = Mapping[str, Any]

SCENARIO: Final = "rtri_test_line"
UNIT: Final = "K1"
TRAIN: Final = "T1"
SAME_AGAIN_S: Final = 10.0  # a telegram sent again within this is the same one repeated
POWER_OFF_S: Final = 60.0
NO_RADIO_S: Final = 400.0


@dataclass(frozen=True, slots=True)
class RestartCase:
    """A place of table 3: where in the paper's terms, and when the power must fail for the train to stop there."""

    place: str
    event: str
    after_s: float = 0.0


RESTARTS: Final = (
    RestartCase("on the departure track, beyond tag (2)", f"train {TRAIN} departs A"),
    RestartCase("from the departure points to tag (3)", f"train {TRAIN} departs A", 12.0),
    RestartCase("between the stations, from tag (3) to tag (4)", f"train {TRAIN} passes tag 601"),
    RestartCase("between the stations, beyond tag (4), a tag ahead", f"train {TRAIN} passes tag 602"),
    RestartCase("between the stations, no tag before the points", f"train {TRAIN} passes tag 603"),
    RestartCase("beyond the arrival points, before tag (1)", f"train {TRAIN} passes tag 701"),
    RestartCase("on the arrival track, between tags (1) and (2)", f"train {TRAIN} passes tag 801"),
)


def run_without_failure() -> Run:
    """The paper's run from section 3 to section 8."""
    return execute(load_scenario(SCENARIO), Link.SIMULATED)


def sequence(run: Run) -> str:
    """The run as a Mermaid sequence diagram."""
    steps: list[tuple[float, str]] = []
    parties: dict[str, str] = {}  # name in the diagram by party, which may not have a hyphen in it
    sent: dict[tuple[str, str, str], float] = {}
    terminals = {p.id: p.terminal_id for p in run.scenario.setup.line.points.values()}
    for entry in run.result.journal.entries:
        who, what, t_s = str(entry["who"]), str(entry["what"]), float(entry["t"])
        if what == "sent":
            key = (who, str(entry["to"]), str(entry["kind"]))
            again = t_s - sent.get(key, -SAME_AGAIN_S) < SAME_AGAIN_S and key[2] in (
                "PointsCommand",
                "PointsProof",
            )
            sent[key] = t_s
            if again:
                continue
            for party in key[:2]:
                parties.setdefault(party, party.replace("-", "_"))
            steps.append((t_s, f"{parties[who]}->>{parties[key[1]]}: {key[2]}"))
            continue
        over = terminals.get(str(entry.get("points"))) if who == "world" else who
        note = _note(entry)
        if note and over is not None:
            parties.setdefault(over, over.replace("-", "_"))
            steps.append((t_s, f"Note over {parties[over]}: {clock(int(t_s))} {note}"))
    order = [UNIT, MANAGER_ID, *sorted(set(parties) - {UNIT, MANAGER_ID})]
    lines = ["```mermaid", "sequenceDiagram"]
    lines += [f"  participant {parties[party]} as {party}" for party in order if party in parties]
    lines += [f"  {text}" for _, text in steps]
    return "\n".join([*lines, "```"])


def _note(entry: Entry) -> str:
    """What a journal entry says in the diagram; empty for those that are not drawn."""
    sections = ", ".join(entry.get("sections", ()))
    note = ""
    match entry["what"]:
        case "granted":
            note = f"{sections} granted, token {_token(entry['token'])}"
        case "freed":
            note = f"{sections} free"
        case "stop_limit":
            note = f"stop limit km {entry['kilometrage_m'] / 1000.0:.3f}, {_why(entry)}"
        case "departs":
            note = f"departs {entry['station']}"
        case "arrived":
            note = f"stands at {entry['station']}"
        case "tag_read" if entry["purpose"] != "position":
            note = f"tag {entry['tag']} ({_purpose(entry)})"
        case "proven":
            note = f"{entry['points']} proven {entry['position']}"
        case "points_moving":
            note = f"{entry['points']} moves to {entry['target']}"
        case "points_locked":
            note = f"{entry['points']} locked {entry['position']}"
    return note


def _token(token: int) -> str:
    return f"{token >> 32}.{token & 0xFFFFFFFF}"


def _purpose(entry: Entry) -> str:
    return str(entry["purpose"]).replace("_", " ")


def _why(entry: Entry) -> str:
    return f"before section {entry['before']}, {entry['why']}" if entry["before"] else str(entry["why"])


def stop_limits(run: Run) -> tuple[tuple[str, ...], ...]:
    """When the stop limit moved, where to and why there."""
    return tuple(
        (clock(int(entry["t"])), f"km {float(entry['kilometrage_m']) / 1000.0:.3f}", _why(entry))
        for entry in run.result.journal.entries
        if entry["what"] == "stop_limit"
    )


def restart_rows() -> tuple[tuple[str, ...], ...]:
    """Table 3 by runs: place, what found the position, stop limit then, the way in, and without radio."""
    scenario = load_scenario(SCENARIO)
    return tuple(_restart_row(scenario, case) for case in RESTARTS)


def _restart_row(scenario: Scenario, case: RestartCase) -> tuple[str, ...]:
    run, dark = (_with_restart(scenario, case, radio=radio) for radio in (True, False))
    entries = _after_restart(run)
    stood_km = _front_km(run, float(entries[0]["t"]))
    found = _found(entries)
    resumed = _first(entries, "resumed")
    later = entries if resumed is None else entries[entries.index(resumed) :]
    limit = None if resumed is None else _first(later, "stop_limit")
    position = "not before it is in" if found is None else _found_by(run, found, stood_km)
    return (
        f"{case.place} (km {stood_km:.2f})",
        position,
        "none" if limit is None else f"km {float(limit['kilometrage_m']) / 1000.0:.2f}, {_why(limit)}",
        _way_in(entries, resumed),
        _without_radio(dark),
    )


def _with_restart(scenario: Scenario, case: RestartCase, *, radio: bool) -> Run:
    matcher = matcher_of(case.event)
    if matcher is None:
        raise ValueError(case.event)
    trigger = Trigger(on=matcher, after_s=case.after_s)
    faults = [Failure(PowerOff(target=UNIT), trigger, POWER_OFF_S)]
    if not radio:
        cut = Cut(target=RadioLink(UNIT, ANY, both_ways=True))
        faults.append(Failure(cut, trigger, NO_RADIO_S))
    setup = replace(scenario.setup, script=Script(tuple(faults)))
    return execute(replace(scenario, setup=setup), Link.SIMULATED)


def _after_restart(run: Run) -> list[Entry]:
    """What the unit wrote from its restart on; the first entry is the restart."""
    entries = [e for e in run.result.journal.entries if e["who"] == UNIT]
    first = next(i for i, entry in enumerate(entries) if entry["what"] == "restarted")
    return entries[first:]


def _first(entries: Sequence[Entry], *what: str) -> Entry | None:
    return next((entry for entry in entries if entry["what"] in what), None)


def _found(entries: Sequence[Entry]) -> Entry | None:
    """The reading of the tag that gave the position."""
    tag: Entry | None = None
    for entry in entries:
        if entry["what"] == "tag_read":
            tag = entry
        if entry["what"] == "position_found":
            return tag
    return None


def _found_by(run: Run, tag: Entry, stood_km: float) -> str:
    at_km = run.scenario.setup.line.tags[int(tag["tag"])].position_m / 1000.0
    return f"by tag {tag['tag']} ({_purpose(tag)}), {round((at_km - stood_km) * 1000.0, -1):.0f} m on"


def _way_in(entries: Sequence[Entry], resumed: Entry | None) -> str:
    """In the order of the journal: looks of the crew, normal running, proofs, arrival."""
    said: list[str] = ["on sight at 15 km/h at most"]
    for entry in entries:
        match entry["what"]:
            case "crew_waits_at_points":
                said.append(f"the crew waits before {entry['points']}")
            case "crew_checked_points":
                said.append(f"the crew stops and looks at {entry['points']}")
            case "resumed":
                said.append("normal running")
            case "proven" if entry.get("by") != "crew":
                said.append(f"{entry['points']} proven")
            case "arrived":
                said.append(f"stands at {entry['station']}")
    if _first(entries, "arrived") is None:
        said.append("**does not get in**")
    elif resumed is None:
        said.append("on sight to the end")
    return ", ".join(dict.fromkeys(said))


def _without_radio(run: Run) -> str:
    """Where it waits when the radio comes back, and whether it gets in afterwards."""
    entries = _after_restart(run)
    over_s = next(
        float(e["t"])
        for e in run.result.journal.entries
        if e["what"] == "fault_over" and e["kind"] == Cut.kind
    )
    before = [entry for entry in entries if float(entry["t"]) < over_s]
    if (arrived := _first(before, "arrived")) is not None:
        return f"gets in on sight and stands at {arrived['station']}"
    known = "position known" if _first(before, "position_found") else "position not known"
    after = "gets in" if _first(entries, "arrived") else "**does not get in**"
    return f"waits at km {_front_km(run, over_s):.2f}, {known}; {after} when it reaches again"


def _front_km(run: Run, t_s: float) -> float:
    """True kilometrage of the front, km. A train that has not moved yet has no rows before its first."""
    rows = run.tables.trajectory.filter(pl.col("unit") == UNIT)
    row = max(rows.filter(pl.col("t_s") <= t_s).height - 1, 0)
    return float(rows["kilometrage_m"][row]) / 1000.0
