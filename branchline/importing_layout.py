"""`branchline import railml`, `osm` and `sumo`: track layouts from outside sources."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json, StationListOut
from branchline.progress import print_aside
from study.outcome import Outcome

if TYPE_CHECKING:
    from exchange.layout import ForeignLayout


def import_railml_command(
    file: Annotated[Path, typer.Argument(help="A railML file of version 2.4 or 3.2.")],
    out: StationListOut = None,
    as_json: Json = False,
) -> None:
    """Read tracks, points, stations and signals from a railML infrastructure file."""
    from exchange.railml import read_railml

    _report(read_railml(file), out, as_json=as_json)


def import_osm_command(
    file: Annotated[
        Path, typer.Argument(help="OpenStreetMap XML (.osm) with the rails of a line or a station.")
    ],
    out: StationListOut = None,
    net: Annotated[
        Path | None, typer.Option("--net", help="SUMO net to write (.net.xml); needs the extra net.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Read tracks, points, stations, signals and milestones from an OpenStreetMap file."""
    from exchange.osm import read_osm

    layout = read_osm(file)
    if net is not None:
        from sumo_cfg.layout_net import write_layout_net

        write_layout_net(layout, net)
        print_aside(f"wrote {net}")
    _report(layout, out, as_json=as_json)


def import_sumo_command(
    net: Annotated[Path, typer.Argument(help="A SUMO net (.net.xml or .net.xml.gz).")],
    out: StationListOut = None,
    additional: Annotated[
        Path | None, typer.Option("--additional", help="Additional file of the net, for its train stops.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Read tracks, points and stations from a SUMO net."""
    from exchange.sumo_net import read_sumo_net

    _report(read_sumo_net(net, additional), out, as_json=as_json)


def _report(layout: ForeignLayout, out: Path | None, *, as_json: bool) -> None:
    """Write the list, then say what was taken, assumed and left."""
    from exchange.layout_text import as_dict, obstacles, station_list_toml
    from network.files.json_input import write_aside

    if out is not None:
        write_aside(out, station_list_toml(layout))
        print_aside(f"wrote {out}")
    if as_json:
        print_json(as_dict(layout), Outcome.GOOD)
        return
    lines = [f"{layout.source}: {layout.name}"]
    for word, sentences in (("taken", layout.used), ("assumed", layout.assumed), ("left", layout.left)):
        lines += [f"{word}: {sentence}" for sentence in sentences]
    for station in layout.stations:
        where = "no kilometrage" if station.position_m is None else f"km {station.position_m / 1000:.3f}"
        count = len(station.track_ids)
        lines.append(f"station: {station.name}, {where}, {count} track{'' if count == 1 else 's'}")
    lines += [f"in the way of a line file: {sentence}" for sentence in obstacles(layout)]
    sys.stdout.write("\n".join(lines) + "\n")
