"""`branchline schema`: what a file may say, for editors and other programs."""

from __future__ import annotations

from typing import Annotated

import typer

from branchline.ending import print_json


def schema(
    kind: Annotated[
        str | None,
        typer.Argument(help="line, timetable, train, scenario, drill, sweep, station_list, additions."),
    ] = None,
) -> None:
    """Print the JSON Schema of one kind of file, or of all kinds by name."""
    from scenario.schemas import KINDS, schema_of

    print_json({name: schema_of(name) for name in KINDS} if kind is None else schema_of(kind))
