"""`branchline plot`: pictures and tables of a finished run, by kind."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json, written_last
from branchline.progress import print_aside
from network.errors import InputError

LIST = "list"


def plot(
    run: Annotated[str, typer.Argument(help="Run directory; or 'list', which shows the kinds.")],
    kind: Annotated[str | None, typer.Argument(help="What to show: see 'branchline plot list'.")] = None,
    train: Annotated[str | None, typer.Option("--train", help="Only this train, by number.")] = None,
    station: Annotated[
        str | None, typer.Option("--station", help="Only this station, by id or name.")
    ] = None,
    from_time: Annotated[str | None, typer.Option("--from", help="From this time, HH:MM.")] = None,
    to_time: Annotated[str | None, typer.Option("--to", help="Until this time, HH:MM.")] = None,
    form: Annotated[
        str | None, typer.Option("--format", help="png, svg or csv; default by --out, else png.")
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option("--with", help="Another run directory to show beside it; may be repeated."),
    ] = None,
    lang: Annotated[str, typer.Option("--lang", help="en or ja.")] = "en",
    out: Annotated[
        Path | None, written_last("--out", "File to write; default <kind>[-train][-station].<format>.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw one picture of a finished run as PNG or SVG, or write its table as CSV."""
    from study.plot.kinds import KINDS, kind_of

    if run == LIST and kind is None:
        _list(as_json=as_json)
        return
    if kind is None:
        raise InputError("command line", "KIND", None, f"one of {', '.join(KINDS)}")
    if lang not in ("en", "ja"):
        raise InputError("command line", "--lang", lang, "one of en, ja")
    from study.plot.choice import Choice, time_of
    from study.plot.write import default_name, format_of, write_plot
    from study.record.read_back import read_run

    shown, written_as = kind_of(kind), format_of(form, out)
    choice = Choice(
        train,
        station,
        time_of("--from", from_time),
        time_of("--to", to_time),
        "ja" if lang == "ja" else "en",
        tuple(read_run(directory) for directory in beside or ()),
    )
    read = read_run(Path(run))
    path = Path(default_name(shown, choice, written_as)) if out is None else out
    write_plot(read, shown, choice, written_as, path)
    if as_json:
        print_json({"kind": shown.name, "format": written_as.value, "file": str(path)})
    else:
        print_aside(f"wrote {path}")


def _list(*, as_json: bool) -> None:
    """Every kind in a line: its name, what it shows, what may be chosen of it."""
    from study.plot.kinds import KINDS

    if as_json:
        print_json(
            {
                "kinds": [
                    {
                        "name": kind.name,
                        "title": kind.title.en,
                        "takes": sorted(option.value for option in kind.takes),
                        "needs": sorted(option.value for option in kind.needs),
                    }
                    for kind in KINDS.values()
                ]
            }
        )
        return
    for kind in KINDS.values():
        options = [
            option.value + (" (needed)" if option in kind.needs else "")
            for option in sorted(kind.takes, key=lambda option: option.value)
        ]
        sys.stdout.write(f"{kind.name:18} {kind.title.en:42} {', '.join(options)}\n")
