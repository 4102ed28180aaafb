"""`branchline import`: line and timetable data from outside sources."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.importing_layout import import_osm_command, import_railml_command, import_sumo_command
from branchline.progress import tell

importers = typer.Typer(help="Make line and timetable data from outside sources.")
importers.command("railml")(import_railml_command)
importers.command("osm")(import_osm_command)
importers.command("sumo")(import_sumo_command)


@importers.command("geometry")
def import_geometry_command(
    polyline: Annotated[Path, typer.Argument(help="Track polyline (GeoJSON, longitude and latitude).")],
    stations: Annotated[Path, typer.Argument(help="Stations of the line (JSON of the same source).")],
    out: Annotated[Path, typer.Argument(help="TOML fragment to write.")],
) -> None:
    """Fit kilometrage, straights, transitions and curves to a track polyline."""
    from network.exchange.geometry import import_geometry

    import_geometry(polyline, stations, out)
    tell(f"wrote {out}")


@importers.command("timetable")
def import_timetable_command(
    source: Annotated[Path, typer.Argument(help="Timetable in the form of mini-tokyo-3d (JSON).")],
    out: Annotated[Path, typer.Argument(help="Timetable file (TOML) to write.")],
    calendar: Annotated[str, typer.Option("--calendar", help="Weekday or SaturdayHoliday.")] = "Weekday",
) -> None:
    """Make a timetable file of the Karasuyama line from published times."""
    from network.exchange.mini_tokyo import import_timetable

    import_timetable(source, out, calendar)
    tell(f"wrote {out}")
