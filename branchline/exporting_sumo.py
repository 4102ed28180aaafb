"""`branchline export sumo`: a scenario for plain SUMO, to be looked at in sumo-gui and netedit."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Final

import typer

from branchline.ending import print_json
from branchline.options import Json
from branchline.progress import tell
from study.outcome import Outcome

SAID_MAX: Final = 3  # of what cannot work


def export_sumo_command(
    source: Annotated[
        str, typer.Argument(help="A run directory, a shipped scenario, or a scenario file (.toml).")
    ],
    out: Annotated[Path, typer.Argument(help="Directory to write into.")],
    as_json: Json = False,
) -> None:
    """Write the net, its equipment and the trains for SUMO, with a .sumocfg; of a run directory, as they ran."""
    from study.feasibility.check import feasibility
    from study.plot.sumo_day import export_sumo, setup_as_run

    impossible: list[str] = []
    if Path(source).is_dir():
        from study.record.read_back import read_run

        run = read_run(Path(source))
        day = export_sumo(str(run.summary["scenario"]), setup_as_run(run), out)
    else:
        from scenario.scenario import load_scenario

        scenario = load_scenario(source)
        day = export_sumo(scenario.id, scenario.setup, out)
        impossible = [finding.sentence for finding in feasibility(scenario.setup).impossible]
    figures = {
        "config": str(day.config),
        "files": [str(path) for path in day.files],
        "vehicles": day.vehicles,
        "trains": day.trains,
        "stops": day.stops,
        "impossible": impossible,
    }
    for sentence in impossible[:SAID_MAX]:
        tell(f"cannot work, and will not in SUMO: {sentence}")
    if len(impossible) > SAID_MAX:
        tell(f"and {len(impossible) - SAID_MAX} more; branchline check has them all")
    if as_json:
        print_json(figures, Outcome.GOOD)
        return
    sys.stdout.write("".join(f"wrote {path}\n" for path in day.files))
    sys.stdout.write(f"{day.trains} trains as {day.vehicles} vehicles with {day.stops} stops\n")
    sys.stdout.write(f"look at it: sumo-gui -c {day.config}\n")
