"""`branchline reproduce`: published experiments, the paper's figures beside ours."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from branchline.ending import end, judged, print_json
from branchline.options import Json, LinkName


def reproduce(
    name: Annotated[str, typer.Argument(help="Name of a reproduction; 'list' shows them.")],
    link: LinkName = "simulated",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all random draws.")] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", help="Directory for pictures, if there are any.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Run a short part only; the remarks say what is left out.")
    ] = False,
    data: Annotated[
        Path | None, typer.Option("--data", help="Folder of reference data that is not shipped.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Rebuild a published experiment and print the paper's figures beside ours."""
    from papers.reproduction import Options
    from papers.specification import REPRODUCTIONS, reproduction
    from study.runner.run import link_of

    if name == "list":
        print_json(sorted(REPRODUCTIONS)) if as_json else sys.stdout.write(
            "\n".join(sorted(REPRODUCTIONS)) + "\n"
        )
        return
    options = Options(
        seed=seed,
        link=link_of(link).value,
        out=None if out is None else str(out),
        data=None if data is None else str(data),
        quick=quick,
    )
    result = reproduction(name)(options)
    outcome = judged(result.passed)
    if as_json:
        print_json(result.as_dict(), outcome)
    else:
        _print_reproduction(result.as_dict(), result.beside)
    end(outcome)


def _verdict(row: dict[str, Any]) -> str:
    if not row["judged"]:
        return "told"
    return "yes" if row["passed"] else "NO"


def _print_reproduction(result: dict[str, Any], beside: str) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(soft_wrap=False)
    parameters = Table(title=f"{result['name']}: {result['title']}", title_justify="left")
    for head in ("parameter", "value", "origin"):
        parameters.add_column(head)
    for p in result["parameters"]:
        parameters.add_row(p["name"], f"{p['value']} {p['unit']}".strip(), p["origin"])
    console.print(parameters)
    rows = Table()
    columns = ("paper", "ours", *((beside,) if beside else ()))
    for head in ("case", *columns, "criterion", "passed"):
        rows.add_column(head)
    for row in result["rows"]:
        cells = ("" if row[column] is None else str(row[column]) for column in columns)
        rows.add_row(row["case"], *cells, row["criterion"], _verdict(row))
    console.print(rows)
    if result["figures"]:
        figures = Table(title="told, not judged", title_justify="left")
        for head in ("figure", "value", "what it says"):
            figures.add_column(head)
        for figure in result["figures"]:
            figures.add_row(figure["name"], str(figure["value"]), figure["meaning"])
        console.print(figures)
    for remark in result["remarks"]:
        console.print(f"- {remark}")
    console.print("passed" if result["passed"] else "NOT passed")
