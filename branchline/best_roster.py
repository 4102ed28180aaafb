"""`branchline best roster`: the least number of sets that run a timetable's trains, with a certificate."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.best_interval import ScenarioOut, new_day, times_beside, write_extending
from branchline.ending import end_with
from branchline.options import Json, ScenarioName, written_last

if TYPE_CHECKING:
    from network.model import Line
    from plan.roster.facts import RosterTrain
    from plan.roster.least import FewestSets


def roster(
    scenario: ScenarioName,
    turn: Annotated[
        int,
        typer.Option(
            "--turn", min=0, max=86_400, help="Time that crews need on a track beyond changing ends, s."
        ),
    ] = 0,
    outside: Annotated[
        int, typer.Option("--outside", min=0, max=86_400, help="The least time of a set off the line, s.")
    ] = 1800,
    out: ScenarioOut = None,
    proof: Annotated[
        Path | None, written_last("--proof", "Where the certificate that fewer cannot do is written (JSON).")
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            "--check", help="Without --out or --proof: only check this certificate; search nothing."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the least number of sets that run a timetable's trains at their times and on their tracks, and prove it.

    Sets on the line stay on their tracks; those outside may come back as any train of their kind.
    """
    import msgspec

    from network.errors import COMMAND_LINE, InputError
    from network.files.json_input import read_json, write_aside
    from plan.moving.proof import proof_text
    from plan.roster.cover import FewerCannot
    from plan.roster.facts import RosterTerms, roster_trains
    from plan.roster.least import fewest_sets, named
    from plan.roster.recount import RosterRecount
    from scenario.scenario import load_scenario

    if out is not None:
        new_day(out, scenario)
    setup = load_scenario(scenario).setup
    terms = RosterTerms(turn, outside)
    if check is not None:
        asked = read_json(check, FewerCannot)
        wrong = RosterRecount(roster_trains(setup), terms).objections(asked)
        right = f"right: no fewer than {asked.sets} sets can run these trains"
        end_with({"objections": wrong}, wrong or [right], good=not wrong, as_json=as_json)
    found = fewest_sets(setup, terms)
    if found.stranded:
        raise InputError(
            COMMAND_LINE, "--turn", turn, f"a time in which sets turn back before train {found.stranded[0]}"
        )
    if proof is not None:
        write_aside(proof, proof_text(found.roster.why))
    if out is not None:
        write_extending(out, named(found.timetable, times_beside(out).stem), scenario)
    figures = {
        "trains": len(found.trains),
        "today": found.today,
        "least": len(found.roster.sets),
        "at_least_with_empty_workings": found.at_least_with_empty_workings,
        "runs": found.judged.good,
        "sets": {own.stock_id: list(own.train_numbers) for own in found.timetable.diagrams},
        "why": msgspec.to_builtins(found.roster.why),
    }
    end_with(figures, _rows(setup.line, found), good=found.judged.good, as_json=as_json)


def _rows(line: Line, found: FewestSets) -> Iterator[str]:
    why, numbers = found.roster.why, {train.number: train for train in found.trains}
    sets = len(found.roster.sets)
    run = "1 set runs" if sets == 1 else f"{sets} sets run"
    yield f"{run} the {len(found.trains)} trains, which {found.today} run today: no fewer can"
    begin = [numbers[number] for number in why.begin]
    if why.after:
        yield f"why: of the {len(begin)} trains {_named(line, begin)}"
        yield f"  only {len(why.after)} can follow another train, for only {', '.join(why.after)} end in time and place"
    else:
        yield "why: none of these trains can follow another one, so no two of them are one set's:"
        yield f"  {_named(line, begin)}"
    fewer = found.at_least_with_empty_workings
    yield (
        "empty workings would not help: even if sets ran empty at once and unhindered, no fewer would do"
        if fewer == len(found.roster.sets)
        else f"with empty workings no fewer than {fewer} would do; whether so few can is not said"
    )
    for diagram in found.timetable.diagrams:
        own = [numbers[number] for number in diagram.train_numbers]
        yield (
            f"set {diagram.stock_id}: {len(own)} trains, {_where(line, own[0], begins=True)} to"
            f" {_where(line, own[-1], begins=False)}: {' '.join(diagram.train_numbers)}"
        )
    yield from _night(line, found)
    yield f"as `check` has it, with these sets: {found.judged.verdict}"


def _named(line: Line, trains: list[RosterTrain]) -> str:
    return ", ".join(f"{train.number} ({_where(line, train, begins=True)})" for train in trains)


def _where(line: Line, train: RosterTrain, *, begins: bool) -> str:
    from network.clock import clock

    event = train.begins if begins else train.ends
    station_id = event.place if event.outside else line.sections[event.place].station_id
    where = line.stations[station_id].name if station_id else event.place
    return f"{'beyond ' if event.outside else ''}{where} {clock(event.time_s)}"


def _night(line: Line, found: FewestSets) -> Iterator[str]:
    """Places where not as many sets end the day as begin it."""
    numbers = {train.number: train for train in found.trains}
    stand: Counter[str] = Counter()
    for own in found.roster.sets:
        for event, by in ((numbers[own[0]].begins, -1), (numbers[own[-1]].ends, 1)):
            station_id = (
                event.place if event.outside else line.sections[event.place].station_id or event.place
            )
            stand[station_id] += by
    for station_id, by in sorted(stand.items()):
        if by:
            more = "more sets end than begin" if by > 0 else "fewer sets end than begin"
            name = line.stations[station_id].name
            yield f"by night: at {name} {abs(by)} {more} the day; an empty working brings them back"
