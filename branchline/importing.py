"""`branchline import`: line and timetable data from outside sources."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.displib import import_displib
from branchline.gtfs import import_gtfs
from branchline.importing_layout import import_osm_command, import_railml_command, import_sumo_command
from branchline.importing_timetables import import_mini_tokyo
from branchline.options import FragmentOut
from branchline.oudia import import_oudia
from branchline.progress import print_aside

importers = typer.Typer(help="Read timetables and tracks of other programs.")
importers.command("railml")(import_railml_command)
importers.command("osm")(import_osm_command)
importers.command("sumo")(import_sumo_command)


@importers.command("geometry")
def import_geometry_command(
    polyline: Annotated[Path, typer.Argument(help="Track polyline (GeoJSON, longitude and latitude).")],
    stations: Annotated[Path, typer.Argument(help="Stations of the line (JSON of the same source).")],
    out: FragmentOut,
) -> None:
    """Fit straights, transitions, curves and kilometrage to a track polyline."""
    from exchange.geometry import import_geometry

    import_geometry(polyline, stations, out)
    print_aside(f"wrote {out}")


importers.command("mini-tokyo")(import_mini_tokyo)
importers.command("gtfs")(import_gtfs)
importers.command("oudia")(import_oudia)
importers.command("displib")(import_displib)
