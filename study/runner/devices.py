"""The wayside devices of a run, and by what ids its parties are known."""

from __future__ import annotations

from host.devices import device_specs
from host.party import PartySpec
from network.graph import all_routes
from radio.keys import KEY_BYTES
from simulation.setup import Setup
from study.runner.journeys import dispatch_of
from wayside.config import crossing_configs, manager_config, terminal_configs


def specs_of(setup: Setup, master_key: bytes) -> tuple[PartySpec, ...]:
    """What is needed to start the wayside devices of a run."""
    line = setup.line
    unit_ids = tuple(diagram.stock_id for diagram in setup.timetable.diagrams)
    reentry, dispatch = setup.operation.reentry, dispatch_of(setup)
    manager = manager_config(line, all_routes(line), unit_ids, reentry=reentry, dispatch=dispatch)
    return device_specs(manager, terminal_configs(line), master_key, crossing_configs(line))


def party_ids_of(setup: Setup) -> tuple[str, ...]:
    """Ids of all that may be processes in a run: devices and units."""
    units = (diagram.stock_id for diagram in setup.timetable.diagrams)
    return (*(spec.party_id for spec in specs_of(setup, bytes(KEY_BYTES))), *units)
