"""`branchline report`: the report of a run that is over, made again of its directory."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer


def report(
    run: Annotated[Path, typer.Argument(help="Run directory; its journal and tables stay as they are.")],
) -> None:
    """Write the report of a finished run again.

    For one that a full disk prevented, or that an older version wrote.
    """
    from study.record.read_back import read_run
    from study.report.report import report_again

    sys.stdout.write(f"report: {report_again(read_run(run), run)}\n")
