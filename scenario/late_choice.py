"""What `[late]` names, checked against the line, the timetable and the kinds of faults."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Final

from network.errors import InputError
from network.files.toml_input import one_of
from network.model import SectionKind
from scenario.script_file import fault_of
from simulation.faults.fault import Fault, UnitFault
from simulation.faults.points import PointsFault
from simulation.faults.table import FAULTS
from simulation.late.settings import Failures
from simulation.names import names_in
from simulation.setup import Setup

_LINKS: Final = "a kind that aims at one thing, not at a link: dead_zones are for the radio"


def check_late(file: str, setup: Setup) -> None:
    """Portals, stations, kinds of faults and their targets exist, or InputError."""
    late, line = setup.late, setup.line
    portals = [section.id for section in line.sections.values() if section.kind is SectionKind.PORTAL]
    for name, entry in late.entry.items():
        for index, portal in enumerate(entry.portals):
            _exists(file, f"late.entry.{name}.portals[{index}]", portal, portals, "a portal")
    for name, dwell in late.dwell.items():
        for station_id in dwell.stations:
            key = f"late.dwell.{name}.stations.{station_id}"
            _exists(file, key, station_id, line.stations, "a station id")
    for name, table in late.failures.items():
        _check_failures(file, f"late.failures.{name}", table, setup)


def _exists(file: str, key: str, value: str, known: Collection[str], what: str) -> None:
    if value not in known:
        raise InputError(file, key, value, f"{what}: {one_of(known, value)}")


def _check_failures(file: str, key: str, table: Failures, setup: Setup) -> None:
    kind: type[Fault[Any]] | None = FAULTS.get(table.kind)
    if kind is None:
        raise InputError(file, f"{key}.kind", table.kind, one_of(FAULTS, table.kind))
    if kind.aims_at == "link":
        raise InputError(file, f"{key}.kind", table.kind, _LINKS)
    names = names_in(setup)
    targets = kind.targets(names)
    for index, target in enumerate(table.targets):
        _exists(file, f"{key}.targets[{index}]", target, targets, f"a {kind.aims_at}")
    if not targets:
        raise InputError(
            file, f"{key}.kind", table.kind, f"a kind with a target on this line, which has no {kind.aims_at}"
        )
    for target in table.targets or targets:
        fault_of(file, key, kind, {"target": target, **(table.model_extra or {})}, names)
        break
    _check_use(file, key, table, kind, setup)


def _check_use(file: str, key: str, table: Failures, kind: type[Fault[Any]], setup: Setup) -> None:
    """What is counted is there to be counted, and what lasts says how long."""
    units = {diagram.stock_id for diagram in setup.timetable.diagrams}
    of_units = issubclass(kind, UnitFault) or (bool(table.targets) and units.issuperset(table.targets))
    if table.mtbf_km is not None and not of_units:
        raise InputError(file, f"{key}.mtbf_km", table.mtbf_km, "mtbf_h: only units run kilometres")
    if table.mtbf_operations is not None and not issubclass(kind, PointsFault):
        raise InputError(
            file, f"{key}.mtbf_operations", table.mtbf_operations, "mtbf_h: only points are thrown"
        )
    if kind.momentary is (table.seconds is not None):
        expected = "no such key: it is over at once" if kind.momentary else "how long until it is repaired"
        raise InputError(file, f"{key}.seconds", None, f"{expected}, for {kind.kind}")
