"""`branchline best displib`, `best deadlock`: published problems of who goes first, and whether all can still go."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final

import typer

from branchline.ending import end_with
from branchline.extras import needing_extra
from branchline.options import Json, SolverWork, written_last
from branchline.progress import print_aside

VERDICTS: Final = {"ORDER": "live", "NONE": "dead", "UNKNOWN": "unknown"}


def displib(
    instance: Annotated[Path, typer.Argument(help="Instance in the form of DISPLIB (JSON).")],
    out: Annotated[Path | None, written_last("--out", "Where the solution is written (JSON).")] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            "--check",
            help="Without --out or --work: say what is wrong with this solution, and solve nothing.",
        ),
    ] = None,
    work: SolverWork = 60.0,
    as_json: Json = False,
) -> None:
    """Find the order of trains in which delays cost least, and below which cost there is none.

    The answer depends on --work alone, not on the machine.
    """
    from network.files.json_input import write_aside
    from plan.dispatching.checker import objections
    from plan.dispatching.instance import read_instance, read_solution, solution_text

    asked = read_instance(instance)
    if check is not None:
        wrong = objections(asked, solution := read_solution(check))
        end_with(
            {"objections": wrong, "objective_value": solution.objective_value},
            [*wrong, f"{len(wrong)} objections"] if wrong else [f"right: costs {solution.objective_value}"],
            good=not wrong,
            as_json=as_json,
        )
        return
    with needing_extra("plan", "displib"):
        from plan.dispatching.solver import solve

    print_aside(f"{len(asked.trains)} trains, {sum(map(len, asked.trains))} operations: solving")
    answer = solve(asked, work)
    found = answer.solution
    if found is not None and out is not None:
        write_aside(out, solution_text(found))
    if answer.impossible:
        text = "impossible: no order of these trains keeps to the instance"
    elif found is None:
        text = f"none found; every order costs at least {answer.bound}"
    elif answer.proven:
        text = f"costs {found.objective_value}: proven to be the least"
    else:
        text = f"costs {found.objective_value}; every order costs at least {answer.bound}"
    figures = {
        "objective_value": None if found is None else found.objective_value,
        "bound": answer.bound,
        "proven": answer.proven,
        "impossible": answer.impossible,
        "work": round(answer.work, 3),
    }
    end_with(figures, [f"{text} (work {answer.work:.2f})"], good=found is not None, as_json=as_json)


def deadlock(
    situations: Annotated[
        list[Path], typer.Argument(help="Situations in the form of Dal Sasso et al. (JSON).")
    ],
    as_json: Json = False,
) -> None:
    """Say of published situations whether all trains can still leave, by the search of the manager's certificate."""
    from network.errors import InputError
    from plan.deadlock import can_all_leave, read_situation

    figures: list[dict[str, Any]] = []
    lines: list[str] = []
    for file in situations:
        try:
            found = can_all_leave(read_situation(file))
        except ValueError as error:
            raise InputError(str(file), "train_routes", None, f"routes that lead on: {error}") from error
        verdict = VERDICTS[found.proof.name]
        live, who = verdict == "live", " and ".join(found.circle)
        why = "all trains can leave" if live else f"{found.proof.value}, as {who} are in each other's way"
        lines.append(f"{file.name}: {verdict}: {why} ({found.steps} moves tried)")
        figures.append(
            {
                "file": str(file),
                "verdict": verdict,
                "entered": found.entered,
                "circle": () if live else found.circle,
                "steps": found.steps,
            }
        )
    live = all(figure["verdict"] == "live" for figure in figures)
    end_with({"situations": figures}, lines, good=live, as_json=as_json)
