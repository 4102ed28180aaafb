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
LineName = Annotated[
    str | None,
    typer.Option(
        "--line", help="A shipped line, or a line file (.toml); without it the source is only counted."
    ),
]
TimetableOut = Annotated[
    Path | None, typer.Argument(help="Timetable file (TOML) to write; without it nothing is written.")
]
TimetableId = Annotated[
    str | None, typer.Option("--id", help="Id of the timetable; default made of line and day.")
]
ByHand = Annotated[
    list[str] | None,
    typer.Option("--name", help="A station by hand: SOURCE=ID, or SOURCE=- to leave it out. Again for more."),
]
ByHandFile = Annotated[
    Path | None, typer.Option("--names", help='TOML file of such pairs: "name in the source" = "id".')
]
Additions = Annotated[
    str | None,
    typer.Option(
        "--add", help="Shipped additions, or a file (.toml): trains and sets that nobody publishes."
    ),
]
RunBy = Annotated[
    str | None,
    typer.Option(
        "--train",
        help="A shipped train, or a train file (.toml): no arrival is computed before that train can be there.",
    ),
]
TurnMin = Annotated[int, typer.Option("--turn-min", min=0, max=86_400, help="Least time to turn back, s.")]
OutsideMin = Annotated[
    int, typer.Option("--outside-min", min=0, max=86_400, help="Least time of a set beyond a portal, s.")
]
