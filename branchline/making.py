"""`branchline new`: files made from little, to go on from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.making_files import new_curvature_map, new_drill, new_scenario, new_timetable, new_train
from branchline.progress import print_aside

makers = typer.Typer(help="Write a file to start from; it works as it stands and marks what it assumes.")
makers.command("scenario")(new_scenario)
makers.command("timetable")(new_timetable)
makers.command("train")(new_train)
makers.command("drill")(new_drill)
makers.command("curvature-map")(new_curvature_map)


@makers.callback()
def _of_all_makers() -> None:
    """Write a file to start from; it works as it stands and marks what it assumes."""


@makers.command("line")
def new_line(
    stations: Annotated[Path, typer.Argument(help="Stations in order (CSV or TOML): name, tracks, km, ...")],
    out: Annotated[Path, typer.Argument(help="Line file (TOML) to write.")],
    polyline: Annotated[
        Path | None, typer.Option("--polyline", help="Track polyline (GeoJSON) to fit the axis to.")
    ] = None,
    stations_geometry: Annotated[
        Path | None, typer.Option("--stations-geometry", help="Stations of the same source (JSON).")
    ] = None,
    gradients: Annotated[
        Path | None, typer.Option("--gradients", help="CSV of from_km, to_km, permille.")
    ] = None,
    limits: Annotated[
        Path | None, typer.Option("--limits", help="CSV of from_km, to_km, speed_kmh, directions.")
    ] = None,
    crossings: Annotated[
        Path | None,
        typer.Option("--crossings", help="CSV of km, id, name, kind, width_m: level crossings by radio."),
    ] = None,
    max_speed: Annotated[
        float | None, typer.Option("--max-speed", help="Maximum speed, km/h; default 85, assumed.")
    ] = None,
    train_length: Annotated[
        float | None, typer.Option("--train-length", help="Longest train, m; default 40, assumed.")
    ] = None,
    line_id: Annotated[
        str | None, typer.Option("--id", help="Id of the line; default: the file's name.")
    ] = None,
    name: Annotated[str | None, typer.Option("--name", help="What people call the line.")] = None,
    name_ja: Annotated[str | None, typer.Option("--name-ja", help="The same in Japanese.")] = None,
    scenario: Annotated[
        Path | None,
        typer.Option(
            "--scenario", help="Also write a scenario that runs a few trains on it, and their timetable."
        ),
    ] = None,
) -> None:
    """Write a line file from a list of stations: sections, points, tags, limits, and what is assumed.

    Columns of the list, of which only a name is always needed: name, name_ja, id, km, tracks, track_names, kind,
    points, normal, side, spacing_m, offset_m, end. A kind is `station`, `halt` or `signal station` (no platforms).
    docs/make-a.md explains them.
    """
    from exchange.new_line import NewLineOptions, write_line
    from network.making.sample_day import sample_timetable, write_sample

    if scenario is not None:
        sample_timetable(out, scenario)
    asked = NewLineOptions(
        line_id,
        name,
        name_ja,
        max_speed,
        train_length,
        polyline,
        stations_geometry,
        gradients,
        limits,
        crossings,
    )
    made = write_line(stations, out, asked)
    for text in made.rows:
        print_aside(text)
    for text in made.remarks:
        print_aside(f"remark: {text}")
    print_aside(f"wrote {out}")
    if scenario is not None:
        for path in write_sample(made.line, out, scenario):
            print_aside(f"wrote {path}")
