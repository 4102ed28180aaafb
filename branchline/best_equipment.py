"""`branchline best equipment`: the cheapest equipment for so many trains an hour, as a curve of cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.best_interval import ScenarioOut, new_day, write_answer
from branchline.ending import end_with
from branchline.extras import needing_extra
from branchline.options import Json, ScenarioName, written_last
from branchline.progress import print_aside

if TYPE_CHECKING:
    from plan.equipping.cheapest import EquipmentChoice, EquippedLine
    from simulation.setup import Setup


def equipment(
    scenario: ScenarioName,
    trains: Annotated[
        float | None,
        typer.Option(
            "--trains",
            min=0.01,
            max=60.0,
            help="Trains an hour each way; default: what each number costs.",
        ),
    ] = None,
    loops: Annotated[
        int, typer.Option("--loops", min=0, max=3, help="How many loops may be added at most.")
    ] = 1,
    options: Annotated[
        Path | None,
        typer.Option("--options", help="A file of options of your own ([[option]]): docs/best.md."),
    ] = None,
    cost: Annotated[
        list[str] | None, typer.Option("--cost", help="What an option costs, NAME=COST; may be repeated.")
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option("--without", help="An option to leave out; may be repeated.")
    ] = None,
    out: ScenarioOut = None,
    proof: Annotated[
        Path | None,
        written_last("--proof", "With --trains: file for the proof that nothing cheaper is enough (JSON)."),
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option("--check", help="Without --out or --proof: only check this proof; search nothing."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the cheapest equipment for so many trains an hour: loops, points, limits, radio, release, virtual blocks.

    Trains are evenly spaced. Every choice is computed, each least interval proven. Costs are assumed (a loop: 100)
    unless --cost says others.
    """
    from network.files.json_input import read_json, write_aside
    from scenario.scenario import load_scenario

    with needing_extra("plan", "equipment"):
        from plan.equipping.cheapest import (
            CheapestProof,
            EquipmentAsked,
            choices_of,
            curve_of,
            objections_to,
            proof_of,
            worked_out,
        )
    from plan.equipping.options import options_of_file, tables_of
    from plan.moving.proof import proof_text

    def with_tables(tables: Mapping[str, Any]) -> Setup:
        return load_scenario(scenario, tables=tables or None).setup

    if out is not None:
        new_day(out, scenario)
    own = () if options is None else tuple(options_of_file(options))
    asked = EquipmentAsked(loops, own, frozenset(without or ()), dict(map(_cost, cost or ())))
    choices = choices_of(with_tables, asked)
    if check is not None:
        claimed = read_json(check, CheapestProof)
        wrong = list(objections_to(with_tables, choices, claimed))
        right = f"right: nothing below a cost of {claimed.cost:g} has an interval of {claimed.interval_s} s or less"
        end_with({"objections": wrong}, wrong or [right], good=not wrong, as_json=as_json)
    until_s = 0.0 if trains is None else 3600.0 / trains
    found = worked_out(with_tables, choices, until_s)
    reached = found[-1].interval_s <= until_s
    if proof is not None and reached:
        write_aside(proof, proof_text(proof_of(found, int(until_s))))
    elif proof is not None:
        print_aside(
            "no proof is written: there is none of a cost that was not asked for (--trains), or not found"
        )
    curve = curve_of(found)
    best = curve[-1] if curve else None
    if out is not None and best is not None and best.setup is not None and best.found is not None:
        write_answer(out, best.setup, best.found, scenario, tables_of(best.choice.options))
    figures = {
        "choices": len(choices),
        "worked_out": len(found),
        "curve": [_figures(one) for one in curve],
        "reached": reached if trains is not None else None,
    }
    good = bool(curve) if trains is None else reached
    end_with(figures, _rows(choices, found, curve, trains), good=good, as_json=as_json)


def _cost(text: str) -> tuple[str, float]:
    from network.errors import COMMAND_LINE, InputError

    name, _, value = text.partition("=")
    try:
        cost = float(value)
    except ValueError:
        cost = -1.0
    if not name or not 0.0 <= cost < 1e12:
        raise InputError(COMMAND_LINE, "--cost", text, "a name and what it costs, such as loop=100")
    return name, cost


def _figures(one: EquippedLine) -> dict[str, Any]:
    return {
        "cost": one.choice.cost,
        "options": list(one.choice.names),
        "interval_s": one.interval_s,
        "trains_an_hour": round(3600.0 / one.interval_s, 3),
    }


def _what(choice: EquipmentChoice) -> str:
    return ", ".join(one.what for one in choice.options) or "nothing more"


def _rows(
    choices: Sequence[EquipmentChoice],
    found: Sequence[EquippedLine],
    curve: Sequence[EquippedLine],
    trains: float | None,
) -> Iterator[str]:
    if trains is not None and curve and curve[-1].interval_s <= 3600.0 / trains:
        best = curve[-1]
        cheaper = [one for one in found if one.choice.cost < best.choice.cost]
        yield (
            f"{trains:g} trains an hour each way, evenly spaced, cost {best.choice.cost:g}: {_what(best.choice)};"
            f" every {best.interval_s:.0f} s"
        )
        if cheaper:
            yield f"nothing cheaper does: each of {len(cheaper)} choices {_needs_more(cheaper)}{_least(cheaper)}"
    elif trains is not None:
        yield (
            f"{trains:g} trains an hour each way, evenly spaced, cannot be had: each of {len(found)} choices"
            f" {_needs_more(found)}"
        )
    yield f"{'cost':>6}  {'interval':>8}  {'an hour':>7}  with"
    for one in curve:
        what = f"{_what(one.choice)}{_decides(one)}"
        yield f"{one.choice.cost:6.0f}  {one.interval_s:6.0f} s  {3600.0 / one.interval_s:7.2f}  {what}"
    left = [one for one in found if one.why_not]
    yield (
        f"{len(found)} of {len(choices)} choices worked out, in order of cost; what is not shown is no quicker than"
        f" something that costs no more. {len(left)} cannot be had{f': {left[0].why_not}' if left else ''}"
    )


def _needs_more(found: Sequence[EquippedLine]) -> str:
    """What is known of choices that do not do."""
    return f"is proven to need more time{', or cannot be had' if any(one.why_not for one in found) else ''}"


def _least(cheaper: Sequence[EquippedLine]) -> str:
    best = min(cheaper, key=lambda one: one.interval_s)
    if best.found is None or best.found.interval_s is None:
        return ""
    return f", {best.interval_s:.0f} s at least ({_what(best.choice)}, {best.choice.cost:g})"


def _decides(one: EquippedLine) -> str:
    """The sections that the one circle of trains is about that decides, in words."""
    if one.found is None or one.found.circle is None or one.setup is None:
        return ""
    from plan.moving.stints import stints_of

    circle, to_s = one.found.circle
    if to_s < one.interval_s - 1:
        return ""
    line = one.setup.line
    places: list[str] = []
    for stint in stints_of(one.found.pattern.all_legs, circle, one.found.proof.tick_s):
        for section_id in (stint.takes, stint.frees):
            station_id = line.sections[section_id].station_id
            places.append(line.stations[station_id].name if station_id else section_id)
    return f" [decides: {' – '.join(dict.fromkeys(places))}]"
