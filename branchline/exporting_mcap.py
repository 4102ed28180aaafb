"""`branchline export mcap`: a finished run as a recording that viewers of such open."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from branchline.extras import needing_extra


def export_mcap(
    run: Annotated[Path, typer.Argument(help="Directory of a finished run.")],
    out: Annotated[Path, typer.Argument(help="File to write (.mcap).")],
) -> None:
    """Write journal and trajectories of a run as MCAP, each message with its JSON Schema."""
    from study.record.read_back import read_run

    with needing_extra("mcap", "export mcap"):
        from study.record.as_mcap import write_mcap
    counts = write_mcap(read_run(run), out)
    sys.stdout.write(f"wrote {out}: {counts.events} events, {counts.samples} samples of trains\n")
