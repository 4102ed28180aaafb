"""`branchline bench`: what the same day costs, three ways."""

from __future__ import annotations

import sys
from typing import Annotated, Any, Final

import typer

from branchline.ending import end, judged_outcome, print_json
from branchline.options import Json
from branchline.progress import print_aside


def bench(
    scenarios: Annotated[
        list[str] | None, typer.Argument(help="Scenarios to measure; default karasuyama_weekday.")
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(
            "--rounds",
            min=1,
            help="Number of rounds; medians are shown. Default: 5, of crossings and road 3.",
        ),
    ] = None,
    part: Annotated[
        list[str] | None,
        typer.Option(
            "--part",
            help="Of links, laws, collation, certificate, sweep, crossings, road, start and serve; may be repeated."
            " Default: links.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure what a simulated day costs in time and memory.

    By default: SUMO alone, the full system in one process, and the full system over Zenoh.
    """
    from study.evaluate.parts import DEFAULT, ROUNDS, ROUNDS_OF, part_of

    measures = {name: part_of(name) for name in part or (DEFAULT,)}
    found: list[dict[str, Any]] = []
    for scenario in scenarios or ["karasuyama_weekday"]:
        for name, measure in measures.items():
            count = rounds or ROUNDS_OF.get(name, ROUNDS)
            found.append({"part": name, **measure(scenario, count, print_aside)})
            if not as_json:
                _print_bench(found[-1])
    outcome = judged_outcome(all(figures.get("same_digest", True) for figures in found))
    if as_json:
        print_json({"scenarios": found}, outcome)
    end(outcome)


_HEADS: Final = {
    "wall_s": "wall s",
    "wall_s_min": "min",
    "wall_s_max": "max",
    "of_sumo_alone": "of SUMO",
    "of_simulated_links": "of simulated",
    "of_execute": "of execute",
    "cpu_s": "cpu s",
    "shut_s": "shut s",
    "sumo_waited_h": "waited h",
    "queueing_h": "by theory h",
    "even_h": "even arrivals",
    "difference_pct": "difference %",
    "of_without": "of without",
    "carrier_s": "carrier s",
    "trains_s": "trains' side s",
    "carried": "carrier's runs",
    "cpu_s_min": "min",
    "cpu_s_max": "max",
    "peak_mb": "peak MB",
    "us_per_query": "us a query",
    "us_per_telegram": "us a telegram",
    "us_per_stretch": "us a stretch",
    "us_per_stretch_beyond_sumo": "beyond SUMO",
}


def _print_bench(figures: dict[str, Any]) -> None:
    sys.stdout.write(f"{figures['scenario']}, {figures['part']}: medians of {figures['rounds']} rounds\n")
    _print_table(figures["rows"])
    if "parts" in figures:
        sys.stdout.write(f"microseconds, {figures['stretches']} stretches\n")
        _print_table(figures["parts"])
        sys.stdout.write(f"{figures['computed']}\n")
    for budget in figures["budgets"]:
        kept = "kept" if budget["kept"] else "NOT KEPT"
        found = "nothing to measure" if budget["found"] is None else f"{budget['found']:g}"
        sys.stdout.write(f"budget: {budget['what']} at most {budget['limit']:g}: {found}, {kept}\n")
    if "sweep" in figures:
        ran = figures["sweep"]
        sys.stdout.write(
            f"a sweep of {ran['days']} days: {ran['wall_s']:g} s, {100.0 * ran['share']:.0f} % of all cores;"
            f" its processes had a day at hand {100.0 * ran['at_hand']:.0f} % of the time\n"
        )
    if "optimum" in figures:
        optimum = figures["optimum"]
        sys.stdout.write(
            f"{optimum['what']}, {optimum['length_m']:.0f} m, {optimum['points']} points, {optimum['steps']} steps: "
            f"{optimum['solution_ms']:g} ms (at most {optimum['limit_ms']:g}: "
            f"{'kept' if optimum['kept'] else 'NOT KEPT'}); its bound {optimum['bound_ms']:g} ms\n"
        )
    sys.stdout.flush()  # whoever stops what comes next has this
    if "same_digest" not in figures:
        return
    same = "the same journal digest" if figures["same_digest"] else "DIFFERENT journal digests"
    print_aside(f"the full runs gave {same}")


def _print_table(rows: list[dict[str, object]]) -> None:
    """The rows under their keys; the first column is what a row is of."""
    heads = ("", *(_HEADS.get(key, key.replace("_", " ")) for key in list(rows[0])[1:]))
    for line in (
        heads,
        *(tuple(v if isinstance(v, str) else f"{v:g}" for v in row.values()) for row in rows),
    ):
        sys.stdout.write(f"{line[0]:32}" + "".join(f"{cell:>14}" for cell in line[1:]) + "\n")
