"""Runs on plain track, which take two thirds of the time: that SUMO carries the same run is `test_carriers`' to say."""

from pathlib import Path

from scenario.scenario import Scenario, load_scenario
from study.drilling.drill import Drill, find_drill, run_drill
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute


def carrier_of(scenario: Scenario) -> CarrierKind:
    """Plain track, but SUMO where there is a road, which it alone carries."""
    return CarrierKind.SUMO if scenario.setup.roads else CarrierKind.PLAIN


def run_on_plain(scenario: Scenario | str | Path) -> FinishedRun:
    """`execute` of a scenario or its file."""
    loaded = scenario if isinstance(scenario, Scenario) else load_scenario(str(scenario))
    return execute(loaded, PartyLink.SIMULATED, carrier=carrier_of(loaded))


def drill_on_plain(name: str | Path) -> Drill:
    """`run_drill` of a drill or its file."""
    carrier = carrier_of(load_scenario(find_drill(str(name))))
    return run_drill(str(name), PartyLink.SIMULATED, carrier=carrier)


def drill_of(folder: Path, text: str) -> Drill:
    """`run_drill` of a drill with this text, which is written into the folder."""
    file = folder / "drill.toml"
    file.write_text(text, "utf-8")
    return drill_on_plain(file)
