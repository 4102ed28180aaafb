"""Real runs of the paper's test line as the documentation shows them: who said what when, and table 3 by restarts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

import polars as pl

from network.clock import clock
from network.model import TagPurpose
from onboard import notes
from radio.noted import Noted, Sent
from scenario.scenario import Scenario, load_scenario
from simulation.events import Event, FaultOver, JournalEntry, PointsLocked, PointsMoving
from simulation.faults.devices import PowerCut
from simulation.faults.links import ANY, Cut
from simulation.faults.links import FaultyLink as RadioLink
from simulation.faults.script import Script, ScriptedFault, Trigger, matcher_of
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from wayside.config import MANAGER_ID
from wayside.said import Freed, Granted

T = TypeVar("T", bound=Noted)

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


def run_without_failure() -> FinishedRun:
    """The paper's run from section 3 to section 8."""
    return execute(load_scenario(SCENARIO), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)


def sequence(run: FinishedRun) -> str:
    """The run as a Mermaid sequence diagram."""
    steps: list[tuple[float, str]] = []
    parties: dict[str, str] = {}  # name in the diagram by party, which may not have a hyphen in it
    sent: dict[tuple[str, str, str], float] = {}
    terminals = {p.id: p.terminal_id for p in run.scenario.setup.line.points.values()}
    for entry in run.result.journal.entries:
        who, t_s, event = entry.who, entry.t_s, entry.event
        if isinstance(event, Sent):
            key = (who, event.receiver, str(event.kind))
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
        over: str | None = who
        if isinstance(event, PointsMoving | PointsLocked):
            over = terminals.get(event.points_id)
        note = _note(event)
        if note and over is not None:
            parties.setdefault(over, over.replace("-", "_"))
            steps.append((t_s, f"Note over {parties[over]}: {clock(int(t_s))} {note}"))
    order = [UNIT, MANAGER_ID, *sorted(set(parties) - {UNIT, MANAGER_ID})]
    lines = ["```mermaid", "sequenceDiagram"]
    lines += [f"  participant {parties[party]} as {party}" for party in order if party in parties]
    lines += [f"  {text}" for _, text in steps]
    return "\n".join([*lines, "```"])


def _note(event: Event) -> str:
    """What an event says in the diagram; empty for those that are not drawn."""
    note = ""
    match event:
        case Granted():
            note = f"{', '.join(event.section_ids)} granted, token {_token(event.token)}"
        case Freed():
            note = f"{', '.join(event.section_ids)} free"
        case notes.LimitSet():
            note = f"stop limit km {event.kilometrage_m / 1000.0:.3f}, {_why(event)}"
        case notes.Departs():
            note = f"departs {event.station}"
        case notes.Arrived():
            note = f"stands at {event.station}"
        case notes.TagRead() if event.purpose is not TagPurpose.POSITION:
            note = f"tag {event.tag_id} ({_purpose(event)})"
        case notes.Proven():
            note = f"{event.points_id} proven {event.position.value}"
        case PointsMoving():
            note = f"{event.points_id} moves to {event.target.value}"
        case PointsLocked():
            note = f"{event.points_id} locked {event.position.value}"
        case _:
            pass
    return note


def _token(token: int) -> str:
    return f"{token >> 32}.{token & 0xFFFFFFFF}"


def _purpose(tag: notes.TagRead) -> str:
    return tag.purpose.value.replace("_", " ")


def _why(limit: notes.LimitSet) -> str:
    return limit.why if limit.before is None else f"before section {limit.before}, {limit.why}"


def stop_limits(run: FinishedRun) -> tuple[tuple[str, ...], ...]:
    """When the stop limit moved, where to and why there."""
    return tuple(
        (clock(int(entry.t_s)), f"km {entry.event.kilometrage_m / 1000.0:.3f}", _why(entry.event))
        for entry in run.result.journal.entries
        if isinstance(entry.event, notes.LimitSet)
    )


def restart_rows() -> tuple[tuple[str, ...], ...]:
    """Table 3 by runs: place, what found the position, stop limit then, the way in, and without radio."""
    scenario = load_scenario(SCENARIO)
    return tuple(_restart_row(scenario, case) for case in RESTARTS)


def _restart_row(scenario: Scenario, case: RestartCase) -> tuple[str, ...]:
    run, dark = (_with_restart(scenario, case, radio=radio) for radio in (True, False))
    entries = _after_restart(run)
    stood_km = _front_km(run, entries[0].t_s)
    said = [entry.event for entry in entries]
    found = _found(said)
    resumed = _first(said, notes.Resumed)
    later = said if resumed is None else said[said.index(resumed) :]
    limit = None if resumed is None else _first(later, notes.LimitSet)
    position = "not before it is in" if found is None else _found_by(run, found, stood_km)
    return (
        f"{case.place} (km {stood_km:.2f})",
        position,
        "none" if limit is None else f"km {limit.kilometrage_m / 1000.0:.2f}, {_why(limit)}",
        _way_in(said, resumed),
        _without_radio(dark),
    )


def _with_restart(scenario: Scenario, case: RestartCase, *, radio: bool) -> FinishedRun:
    matcher = matcher_of(case.event)
    if matcher is None:
        raise ValueError(case.event)
    trigger = Trigger(on=matcher, after_s=case.after_s)
    faults = [ScriptedFault(PowerCut(target=UNIT), trigger, POWER_OFF_S)]
    if not radio:
        cut = Cut(target=RadioLink(UNIT, ANY, both_ways=True))
        faults.append(ScriptedFault(cut, trigger, NO_RADIO_S))
    setup = replace(scenario.setup, script=Script(tuple(faults)))
    return execute(replace(scenario, setup=setup), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)


def _after_restart(run: FinishedRun) -> list[JournalEntry]:
    """What the unit wrote from its restart on; the first entry is the restart."""
    entries = [e for e in run.result.journal.entries if e.who == UNIT]
    first = next(i for i, entry in enumerate(entries) if isinstance(entry.event, notes.UnitRestarted))
    return entries[first:]


def _first(said: Sequence[Event], kind: type[T]) -> T | None:
    return next((event for event in said if isinstance(event, kind)), None)


def _found(said: Sequence[Event]) -> notes.TagRead | None:
    """The reading of the tag that gave the position."""
    tag: notes.TagRead | None = None
    for event in said:
        if isinstance(event, notes.TagRead):
            tag = event
        if isinstance(event, notes.PositionFound):
            return tag
    return None


def _found_by(run: FinishedRun, tag: notes.TagRead, stood_km: float) -> str:
    at_km = run.scenario.setup.line.tags[tag.tag_id].position_m / 1000.0
    return f"by tag {tag.tag_id} ({_purpose(tag)}), {round((at_km - stood_km) * 1000.0, -1):.0f} m on"


def _way_in(events: Sequence[Event], resumed: notes.Resumed | None) -> str:
    """In the order of the journal: looks of the crew, normal running, proofs, arrival."""
    said: list[str] = ["on sight at 15 km/h at most"]
    for event in events:
        match event:
            case notes.CrewWaitsAtPoints():
                said.append(f"the crew waits before {event.points_id}")
            case notes.CrewCheckedPoints():
                said.append(f"the crew stops and looks at {event.points_id}")
            case notes.Resumed():
                said.append("normal running")
            case notes.Proven(by_crew=False):
                said.append(f"{event.points_id} proven")
            case notes.Arrived():
                said.append(f"stands at {event.station}")
            case _:
                pass
    if _first(events, notes.Arrived) is None:
        said.append("**does not get in**")
    elif resumed is None:
        said.append("on sight to the end")
    return ", ".join(dict.fromkeys(said))


def _without_radio(run: FinishedRun) -> str:
    """Where it waits when the radio comes back, and whether it gets in afterwards."""
    entries = _after_restart(run)
    over_s = next(
        e.t_s
        for e in run.result.journal.entries
        if isinstance(e.event, FaultOver) and e.event.kind == Cut.kind
    )
    before = [entry.event for entry in entries if entry.t_s < over_s]
    if (arrived := _first(before, notes.Arrived)) is not None:
        return f"gets in on sight and stands at {arrived.station}"
    known = "position known" if _first(before, notes.PositionFound) else "position not known"
    after = "gets in" if _first([entry.event for entry in entries], notes.Arrived) else "**does not get in**"
    return f"waits at km {_front_km(run, over_s):.2f}, {known}; {after} when it reaches again"


def _front_km(run: FinishedRun, t_s: float) -> float:
    """True kilometrage of the front, km. A train that has not moved yet has no rows before its first."""
    rows = run.tables.trajectory.filter(pl.col("unit") == UNIT)
    row = max(rows.filter(pl.col("t_s") <= t_s).height - 1, 0)
    return float(rows["kilometrage_m"][row]) / 1000.0
