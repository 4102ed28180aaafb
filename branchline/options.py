"""Options that several commands have, each with one meaning and one text."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from branchline.ending import JSON_OPTION


def _free(out: Path | None) -> Path | None:
    """Before anything is read: nothing stands there."""
    from network.files.json_input import check_free, check_place

    if out is not None:
        check_free(out)
        check_place(out)
    return out


def _placed(param: typer.CallbackParam, out: Path | None) -> Path | None:
    from network.files.json_input import check_place

    if out is not None:
        check_place(out, param.opts[0])
    return out


def written_last(option: str, text: str) -> Any:  # noqa: ANN401
    """The option of a file that is written at the end: before anything is computed, it can be."""
    return typer.Option(option, help=text, callback=_placed)


ScenarioName = Annotated[str, typer.Argument(help="A shipped scenario, or a scenario file (.toml).")]
Json = Annotated[
    bool, typer.Option(JSON_OPTION, help="Print one JSON object on stdout and nothing else there.")
]
Seed = Annotated[
    int | None, typer.Option("--seed", min=0, help="Seed of all random draws; default: that of the scenario.")
]
Out = Annotated[Path | None, typer.Option("--out", help="Run directory; default runs/<scenario>.")]
LinkName = Annotated[
    str,
    typer.Option(
        "--link", help="How telegrams travel: simulated, or zenoh with a process for each wayside device."
    ),
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
    Path | None,
    typer.Argument(
        help="Timetable file (TOML) to write, a new one; without it nothing is written.", callback=_free
    ),
]
StationListOut = Annotated[
    Path | None,
    typer.Argument(
        help="Station list (TOML) to write, a new file, for `branchline new line`.", callback=_free
    ),
]
FragmentOut = Annotated[Path, typer.Argument(help="TOML fragment to write, a new file.", callback=_free)]
TimetableId = Annotated[
    str | None, typer.Option("--id", help="With --line: id of the timetable; default made of line and day.")
]
ByHand = Annotated[
    list[str] | None,
    typer.Option(
        "--name",
        help="With --line: match a station by hand: SOURCE=ID, or SOURCE=- to leave it out; may be repeated.",
    ),
]
ByHandFile = Annotated[
    Path | None,
    typer.Option("--names", help='With --line: TOML file of such pairs: "name in the source" = "id".'),
]
Additions = Annotated[
    str | None,
    typer.Option(
        "--add",
        help="With --line: trains and sets that the source lacks: shipped additions, or a file (.toml).",
    ),
]
RunBy = Annotated[
    str | None,
    typer.Option(
        "--train",
        help="With --line: a shipped train, or a train file (.toml): computed arrivals are no earlier than it can run;"
        " a source with departures alone is arranged as `branchline arrange` does it.",
    ),
]
TurnMin = Annotated[
    int, typer.Option("--turn-min", min=0, max=86_400, help="With --line: least time to turn back, s.")
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        help="With --line: a train to leave out, by its number on the line; several times for several.",
    ),
]
OutsideMin = Annotated[
    int,
    typer.Option(
        "--outside-min",
        min=0,
        max=86_400,
        help="With --line: least time that a set stays beyond a portal, s.",
    ),
]
SolverWork = Annotated[
    float,
    typer.Option(
        "--work",
        min=0.001,
        help="How much the solver may work; 1 is about eight seconds of one processor.",
    ),
]
