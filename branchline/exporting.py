"""`branchline export`: what we have, in the forms of other programs. Each form is a module of its own, listed here."""

from __future__ import annotations

import typer

from branchline.gtfs import export_gtfs
from branchline.oudia import export_oudia

exporters = typer.Typer(help="Write lines, timetables and runs in the forms of other programs.")


@exporters.callback()
def _of_all_exports() -> None:
    """Write lines, timetables and runs in the forms of other programs."""


exporters.command("oudia")(export_oudia)
exporters.command("gtfs")(export_gtfs)
