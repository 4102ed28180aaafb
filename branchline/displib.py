"""`branchline export displib`, `import displib`: a late day as a dispatching problem, its solution as an order."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json, ScenarioName, Seed
from branchline.progress import print_aside


def export_displib(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Argument(help="File to write (JSON).")],
    seed: Seed = None,
    as_json: Json = False,
) -> None:
    """Write a late day as a problem in the form of DISPLIB, from the line's blocking times.

    `branchline best displib` solves it; `import displib` makes a scenario in which trains go in that order.
    """
    import msgspec

    from network.files.json_input import write_bytes_aside
    from plan.dispatching.day import day_of
    from scenario.scenario import load_scenario
    from study.outcome import Outcome

    instance = day_of(load_scenario(scenario, seed).setup).instance
    write_bytes_aside(out, msgspec.json.encode(instance), b"{")
    operations = sum(map(len, instance.trains))
    if as_json:
        figures = {"file": str(out), "sets": len(instance.trains), "operations": operations}
        print_json(figures | {"delays": len(instance.objective)}, Outcome.GOOD)
        return
    text = f"{len(instance.trains)} sets, {operations} operations, {len(instance.objective)} trains that may be late"
    sys.stdout.write(f"wrote {out}: {text}\n")


def import_displib(
    scenario: ScenarioName,
    solution: Annotated[Path, typer.Argument(help="Solution in the form of DISPLIB (JSON).")],
    out: Annotated[Path, typer.Argument(help="Scenario file to write (.toml).")],
    seed: Seed = None,
    run: Annotated[
        bool, typer.Option("--run", help="Also run it, and compare its delays with those of the solution.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Write a scenario in which trains go in the order of a solution of a problem that `export displib` wrote."""
    from network.errors import InputError
    from plan.dispatching.checker import objections
    from plan.dispatching.day import day_of, moves_of
    from plan.dispatching.instance import read_solution
    from scenario.scenario import load_scenario
    from study.making.place import extended_by, write_new
    from study.outcome import Outcome

    base = extended_by(out, scenario)
    loaded, solved = load_scenario(scenario, seed), read_solution(solution)
    day = day_of(loaded.setup)
    if wrong := objections(day.instance, solved):
        raise InputError(str(solution), "events", wrong[0], "a solution of this scenario's day and seed")
    given = moves_of(loaded.setup, day.order(solved))
    text = (
        f"extends = {json.dumps(base)}\nid = {json.dumps(f'{loaded.id}_ordered')}\n"
        f"name = {json.dumps(f'{loaded.name}, in the order of {solution.name}')}\n"
        f"seed = {loaded.setup.seed}\n\n[dispatch]\ngiven = {json.dumps(given)}\n"
    )
    write_new(out, text)
    figures: dict[str, object] = {"file": str(out), "promised_s": solved.objective_value}
    lines = [f"wrote {out}: promised {solved.objective_value / 60.0:.1f} min late in all at last stops"]
    if run:
        from study.measures.day_figures import day_figures
        from study.runner.run import CarrierKind, PartyLink, execute

        print_aside("running the day in that order")
        ordered = load_scenario(str(out))
        done = execute(ordered, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
        kept_min = day_figures(done.result, ordered.setup).lost_train_minutes
        figures["kept_s"] = 60.0 * kept_min
        lines.append(f"kept: {kept_min:.1f} min, as run")
    if as_json:
        print_json(figures, Outcome.GOOD)
        return
    sys.stdout.writelines(f"{line}\n" for line in lines)
