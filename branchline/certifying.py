"""`branchline certificates`: what a run and its parties on other machines show one another."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from branchline.extras import needing_extra
from branchline.options import ScenarioName


def certificates(
    scenario: ScenarioName,
    folder: Annotated[Path, typer.Argument(help="A new folder, which its owner alone can enter.")],
    address: Annotated[
        str, typer.Option("--address", help="Name or number by which other machines reach this one.")
    ],
    hours: Annotated[int, typer.Option("--hours", min=1, max=24 * 30, help="How long they count.")] = 24,
) -> None:
    """Make certificates for the simulator and each party of a scenario, for `run --listen`."""
    with needing_extra("tls", "certificates"):
        from host.certificates import PARTIES_FOLDER, make_certificates
    from scenario.scenario import load_scenario
    from study.runner.devices import party_ids_of

    names = party_ids_of(load_scenario(scenario).setup)
    make_certificates(folder.resolve(), names, address, hours)
    sys.stdout.write(
        f"{folder}: for {len(names)} parties, {hours} h; {folder / PARTIES_FOLDER} has what each needs\n"
    )
