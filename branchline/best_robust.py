"""`branchline best robust`: the same trains with their reserves where late days need them most."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.best_interval import ScenarioOut, new_day, write_extending
from branchline.ending import end_with
from branchline.options import Json, ScenarioName
from branchline.progress import print_aside

if TYPE_CHECKING:
    from network.model import Line
    from plan.reserves.robust import ReservePlan, Robust


def robust(
    scenario: ScenarioName,
    days: Annotated[
        int,
        typer.Option(
            "--days", min=1, max=1000, help="Late days drawn at random for which reserves are placed."
        ),
    ] = 40,
    fresh: Annotated[
        int,
        typer.Option(
            "--fresh", min=1, max=10_000, help="Other days, from seed 1 on, on which the answer is judged."
        ),
    ] = 200,
    move: Annotated[
        int,
        typer.Option(
            "--move", min=0, max=3600, help="By how much the first departures of like trains may move, s."
        ),
    ] = 60,
    out: ScenarioOut = None,
    as_json: Json = False,
) -> None:
    """Place the reserve times of a timetable so that trains are least late; trains, intervals and journeys stay.

    Orders, tracks and sets of trains stay too. --out also writes a sweep that runs the answer on the fresh days.
    """
    from plan.reserves.robust import most_robust, timetables_of, write_sweep
    from scenario.scenario import load_scenario

    base = new_day(out, scenario) if out is not None else scenario
    setup = load_scenario(scenario).setup
    found = most_robust(setup, days, range(1, fresh + 1), move)
    if out is not None:
        timetables = timetables_of(setup, found, out.stem)
        write_extending(out, timetables[0], scenario)
        path = write_sweep(out, base, timetables, found.fresh_seeds)
        print_aside(f"wrote {path}, which runs all three: branchline sweep {path}")
    plans = {"as it is": found.as_it_is, "spread evenly": found.evenly, "placed": found.placed}
    figures = {
        "bound_s": round(found.bound_s, 3),
        "mean_delay_s": {
            name: {"trained": round(plan.trained_s, 3), "fresh": round(plan.fresh_s, 3)}
            for name, plan in plans.items()
        },
        "reserves": {name: list(_shapes(found, plan)) for name, plan in plans.items()},
    }
    end_with(figures, _rows(setup.line, found, plans), good=True, as_json=as_json)


def _shapes(found: Robust, plan: ReservePlan) -> Iterator[dict[str, object]]:
    from plan.reserves.written import reserves_of

    for train, moved_s, rows in reserves_of(found.problem, plan.times):
        yield {
            "train": train.number,
            "trains": sum(other.shape == train.shape for other in found.problem.trains.values()),
            "first_departure_moved_s": moved_s,
            "stops": [
                {"station": s, "run_s": round(run_s, 1), "stay_s": round(stay_s, 1)}
                for s, run_s, stay_s in rows
            ],
        }


def _rows(line: Line, found: Robust, plans: dict[str, ReservePlan]) -> Iterator[str]:
    trained, fresh = f"{len(found.training_seeds)} days trained on", f"{len(found.fresh_seeds)} fresh days"
    yield f"mean delay of an arrival by the model {trained:>20} {fresh:>18}"
    for name, plan in plans.items():
        yield f"  {name:35} {plan.trained_s:18.2f} s {plan.fresh_s:16.2f} s"
    yield (
        f"on the days trained on no timetable with these orders, journeys and intervals is below {found.bound_s:.2f} s"
    )
    from plan.reserves.written import reserves_of

    both = zip(
        *(reserves_of(found.problem, plan.times) for plan in (found.as_it_is, found.placed)), strict=True
    )
    for (train, _, before), (_, moved_s, after) in both:
        count = sum(other.shape == train.shape for other in found.problem.trains.values())
        yield (
            f"train {train.number} and those like it ({count}): first departure {moved_s:+d} s;"
            " reserves, s, before and after:"
        )
        for (station_id, run_s, stay_s), (_, new_run_s, new_stay_s) in zip(before, after, strict=True):
            name = line.stations[station_id].name
            yield f"  {name:24} run there {run_s:4.0f} -> {new_run_s:4.0f}   stand {stay_s:4.0f} -> {new_stay_s:4.0f}"
