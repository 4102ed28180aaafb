"""`branchline serve-party`: a party of a run on another machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.extras import needing_extra


def serve_party(
    folder: Annotated[
        Path,
        typer.Argument(
            help="Certificate and invitation of a party: what `run --listen` names, carried here."
        ),
    ],
    connect: Annotated[str, typer.Option("--connect", help="Where the run waits: tls/ADDRESS:PORT.")],
) -> None:
    """Host one party of a run that another machine simulates, until that run is over."""
    with needing_extra("tls", "serve-party"):
        from host.taking_part import take_part

    take_part(folder.resolve(), connect)
