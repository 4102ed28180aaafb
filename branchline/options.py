"""Options that several commands have, each with one meaning and one text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.ending import JSON_OPTION

ScenarioName = Annotated[str, typer.Argument(help="A shipped scenario, or a scenario file (.toml).")]
Json = Annotated[
    bool, typer.Option(JSON_OPTION, help="Print one JSON object on stdout and nothing else there.")
]
Seed = Annotated[int | None, typer.Option("--seed", min=0, help="Seed of every chance in the run.")]
Out = Annotated[Path | None, typer.Option("--out", help="Run directory; default runs/<scenario>.")]
LinkName = Annotated[
    str, typer.Option("--link", help="simulated, or zenoh: a process for each wayside device.")
]
UnitsName = Annotated[
    str,
    typer.Option(
        "--units", help="Where on-board units run: 'simulator', or 'processes' (with --link zenoh)."
    ),
]
