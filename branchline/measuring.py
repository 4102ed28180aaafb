"""`branchline bench`: what the same day costs, three ways."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import typer

from branchline.ending import end, judged, print_json
from branchline.options import Json
from branchline.progress import tell


def bench(
    scenarios: Annotated[
        list[str] | None, typer.Argument(help="Scenarios to measure; default karasuyama_weekday.")
    ] = None,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Rounds; medians are shown.")] = 3,
    as_json: Json = False,
) -> None:
    """Measure the same day three ways: SUMO alone, full system, full system over Zenoh."""
    from study.evaluate.bench import bench as measure

    found = [measure(scenario, rounds, tell) for scenario in scenarios or ["karasuyama_weekday"]]
    outcome = judged(all(figures["same_digest"] for figures in found))
    if as_json:
        print_json({"scenarios": found}, outcome)
    else:
        for figures in found:
            _print_bench(figures)
    end(outcome)


def _print_bench(figures: dict[str, Any]) -> None:
    head = f"{figures['scenario']}, {figures['trains']} trains: medians of {figures['rounds']} rounds"
    sys.stdout.write(head + "\n")
    _print_table(("", "wall s", "min", "max", "of SUMO", "of simulated", "peak MB"), figures["rows"])
    sys.stdout.write(f"microseconds, {figures['stretches']} stretches\n")
    heads = ("", "queries", "telegrams", "us a query", "us a telegram", "us a stretch", "beyond SUMO")
    _print_table(heads, figures["parts"])
    sys.stdout.write(f"{figures['computed']}\n")
    for budget in figures["budgets"]:
        kept = "kept" if budget["kept"] else "NOT KEPT"
        sys.stdout.write(
            f"budget: {budget['what']} at most {budget['limit']:g}: {budget['found']:g}, {kept}\n"
        )
    optimum = figures["optimum"]
    sys.stdout.write(
        f"{optimum['what']}, {optimum['length_m']:.0f} m, {optimum['points']} points, {optimum['steps']} steps: "
        f"{optimum['solution_ms']:g} ms (at most {optimum['limit_ms']:g}: "
        f"{'kept' if optimum['kept'] else 'NOT KEPT'}); its bound {optimum['bound_ms']:g} ms\n"
    )
    same = "the same journal digest" if figures["same_digest"] else "DIFFERENT journal digests"
    tell(f"the full runs gave {same}")


def _print_table(heads: tuple[str, ...], rows: list[dict[str, object]]) -> None:
    for line in (heads, *(tuple(_short(value) for value in row.values()) for row in rows)):
        sys.stdout.write(f"{line[0]:32}" + "".join(f"{cell:>14}" for cell in line[1:]) + "\n")


def _short(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"
