"""`branchline duties`: which stock runs what (運用), as a table and as a duty graph (運用図)."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json
from branchline.oudia import timetables_of
from branchline.progress import print_aside

if TYPE_CHECKING:
    from network.model import Line
    from study.measures.duties import SetDuty


def duties(
    source: Annotated[
        str, typer.Argument(help="A shipped scenario, a scenario file (.toml), or a run directory.")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", help="Directory for duties.csv and the graph as PNG and SVG.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Show which train set runs which trains (運用), and where it turns and waits.

    Of a scenario as planned, of a run directory as it was run.
    """
    from study.measures.duties import duties_of

    line, timetable, as_run = timetables_of(source)
    found = duties_of(line, timetable, as_run)
    if out is not None:
        from study.record.directory import replacing_folder
        from study.report.duty_graph import FILES, write_duties

        with replacing_folder(out, FILES.__contains__, "duties") as folder:
            write_duties(folder, line, found)
        print_aside(f"wrote {', '.join(sorted(FILES))} in {out}")
    if as_json:
        print_json({"line": line.id, "sets": [duty.as_dict() for duty in found]})
    else:
        _print(line, found)


def _print(line: Line, found: Sequence[SetDuty]) -> None:
    """A row a set, and under it its trains in order with what it does between them."""
    from study.report.style import clock

    width = max((len(duty.stock_id) for duty in found), default=3)
    heads = ("trains", "from", "to", "h", "h run", "km", "km empty", "least turn")
    sys.stdout.write(f"{'set':{width}}" + "".join(f"{head:>11}" for head in heads) + "\n")
    for duty in found:
        cells = ["-"] * len(heads)
        if duty.trains:
            cells = [
                str(len(duty.trains)),
                *(clock(duty.trains[0].begins_s), clock(duty.trains[-1].ends_s)),
                *(f"{duty.on_duty_s / 3600:.2f}", f"{duty.running_s / 3600:.2f}"),
                *(f"{duty.distance_m / 1000:.1f}", f"{duty.empty_m / 1000:.1f}"),
                "-" if duty.turn_min_s is None else f"{duty.turn_min_s / 60:.1f} min",
            ]
        sys.stdout.write(f"{duty.stock_id:{width}}" + "".join(f"{cell:>11}" for cell in cells) + "\n")
    for duty in found:
        sys.stdout.write(f"\n{duty.stock_id}: {_course(line, duty)}\n")
        if duty.missing:
            sys.stdout.write(f"{duty.stock_id}: did not run {', '.join(duty.missing)}\n")


def _course(line: Line, duty: SetDuty) -> str:
    """One set's day in a line: places, minutes there, and trains."""
    words = {"turn": "", "stabled": " stabled", "outside": " (beyond)", "cut short": " (cut short)"}
    parts: list[str] = []
    trains = {train.number: train for train in duty.trains}
    for gap in duty.gaps:
        name = line.stations[gap.station_id].name or gap.station_id
        minutes = "" if gap.length_s is None else f" {gap.length_s / 60:.0f} min"
        parts.append(f"{name}{words[gap.kind]}{minutes}")
        if gap.before is not None:
            parts.append(gap.before if trains[gap.before].revenue else f"{gap.before} (empty)")
    return " - ".join(parts)
