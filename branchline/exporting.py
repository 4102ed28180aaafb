"""`branchline export`: lines, timetables and runs for other programs. Each format is a module of its own."""

from __future__ import annotations

import typer

from branchline.displib import export_displib
from branchline.exporting_mcap import export_mcap
from branchline.exporting_sumo import export_sumo_command
from branchline.gtfs import export_gtfs
from branchline.oudia import export_oudia

exporters = typer.Typer(help="Write lines, timetables and runs for other programs.")
exporters.command("sumo")(export_sumo_command)


@exporters.callback()
def _of_all_exports() -> None:
    """Write lines, timetables and runs for other programs."""


exporters.command("oudia")(export_oudia)
exporters.command("gtfs")(export_gtfs)
exporters.command("displib")(export_displib)
exporters.command("mcap")(export_mcap)
