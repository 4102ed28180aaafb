"""`branchline import oudia` and `branchline export oudia`: timetables of OuDia and OuDiaSecond."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline import options
from branchline.ending import print_json
from branchline.importing_timetables import (
    OUTSIDE_MIN_S,
    TURN_MIN_S,
    ImportOptions,
    write_or_count,
    write_read_back,
)
from branchline.progress import print_aside
from study.outcome import Outcome

if TYPE_CHECKING:
    from exchange.oudia.route import OudiaDia, OudiaRoute
    from network.model import Line
    from network.timetable import Timetable, TimetableTrain


def import_oudia(
    source: Annotated[Path, typer.Argument(help="File of OuDia (.oud) or OuDiaSecond (.oud2).")],
    out: options.TimetableOut = None,
    line: options.LineName = None,
    dia: Annotated[str | None, typer.Option("--dia", help="Which Dia, if the file has several.")] = None,
    timetable_id: options.TimetableId = None,
    name: options.ByHand = None,
    names: options.ByHandFile = None,
    add: options.Additions = None,
    train: options.RunBy = None,
    turn_min: options.TurnMin = TURN_MIN_S,
    outside_min: options.OutsideMin = OUTSIDE_MIN_S,
    without: options.Without = None,
    as_json: options.Json = False,
) -> None:
    """Read a file of OuDia or OuDiaSecond and, with --line, write its timetable file."""
    from exchange.oudia.nodes import read_oudia
    from exchange.oudia.published import published_of
    from exchange.oudia.route import route_of
    from network.errors import COMMAND_LINE, InputError

    route = route_of(read_oudia(source), str(source))
    counts = _counted(route)
    if line is None:
        if out is not None:
            raise InputError(
                COMMAND_LINE, "--line", None, "the line of the timetable file that is to be written"
            )
        _say(counts if dia is None else _counted(route, [route.dia(dia)]), as_json=as_json)
        return
    chosen = route.dia(dia)
    if not (name or names or add or train or without) and _read_back(
        route, chosen, line, timetable_id, out, as_json=as_json
    ):
        return
    credit = f"{source.name}: {route.name}, {chosen.name} ({route.kind})"
    wanted = ImportOptions(
        credit,
        "oudia",
        line,
        out,
        timetable_id,
        name or (),
        names,
        add,
        turn_min,
        outside_min,
        train=train,
        without=without or (),
    )
    write_or_count(
        published_of(route, chosen), wanted, {"file_type": route.kind, "dia": chosen.name}, as_json=as_json
    )


def export_oudia(
    source: Annotated[
        str, typer.Argument(help="A run directory, a shipped scenario, or a scenario file (.toml).")
    ],
    out: Annotated[Path, typer.Argument(help="File to write (.oud2).")],
    as_json: options.Json = False,
) -> None:
    """Write a timetable for OuDiaSecond; of a run directory also the day as run, as a second Dia."""
    from exchange.oudia.writer import AS_RUN, plan_name, write_oudia

    line, timetable, as_run = timetables_of(source)
    write_oudia(out, line, timetable, as_run or ())
    dias = [{"name": plan_name(timetable), "trains": len(timetable.trains)}]
    dias += [{"name": AS_RUN, "trains": len(as_run)}] if as_run else []
    _say(
        {"line": line.id, "timetable": timetable.head.id, "stations": len(line.stations), "dias": dias},
        as_json=as_json,
    )
    print_aside(f"wrote {out}")


def timetables_of(source: str) -> tuple[Line, Timetable, tuple[TimetableTrain, ...] | None]:
    """Line and timetable, and of a run directory its trains as they were run; None of a scenario."""
    if Path(source).is_dir():
        from study.record.as_run import trains_as_run
        from study.record.read_back import read_run

        run = read_run(Path(source))
        return run.line, run.timetable, trains_as_run(run.timetable, run.tables.stops)
    from scenario.scenario import load_scenario

    setup = load_scenario(source).setup
    return setup.line, setup.timetable, None


def _read_back(
    route: OudiaRoute,
    dia: OudiaDia,
    line_name: str,
    timetable_id: str | None,
    out: Path | None,
    *,
    as_json: bool,
) -> bool:
    """Whether the file is one of ours and whole; then it is read back as it was written."""
    from exchange.oudia.exact import read_back
    from network.files.line_file import load_line
    from network.files.shipped import shipped_line

    line = load_line(shipped_line(line_name))
    back = read_back(route, dia, line)
    if back.file is None:
        if back.why:
            print_aside(f"read as any other file: {back.why}")
        return False
    write_read_back(back.file, timetable_id, out, {"dia": dia.name}, as_json=as_json)
    return True


def _counted(route: OudiaRoute, dias: Iterable[OudiaDia] | None = None) -> dict[str, Any]:
    """What a file holds: stations, and for each Dia its trains."""
    from exchange.oudia.route import summary_of

    shown = [summary_of(dia) for dia in (route.dias if dias is None else dias)]
    return {
        "file_type": route.kind,
        "name": route.name,
        "stations": len(route.stations),
        "trains": sum(dia["trains"] for dia in shown),
        "dias": shown,
        "station_names": [station.name for station in route.stations],
    }


def _say(figures: dict[str, Any], *, as_json: bool) -> None:
    """Figures as `key: value`, a Dia a line."""
    from network.raw import is_list, is_table

    if as_json:
        print_json(figures, Outcome.GOOD)
        return
    for key, value in figures.items():
        if is_list(value) and all(is_table(item) for item in value):
            for item in value:
                parts = (
                    f"{name} {part}"
                    for name, part in item.items()
                    if name not in ("name", "left") and part != ""
                )
                left = f"; left: {', '.join(item['left'])}" if item.get("left") else ""
                sys.stdout.write(f"dia {item['name']}: {', '.join(parts)}{left}\n")
        elif is_list(value):
            sys.stdout.write(f"{key}: {', '.join(map(str, value))}\n")
        else:
            sys.stdout.write(f"{key}: {value}\n")
