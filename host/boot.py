"""What stands behind the door of each role: the one place of the host that names them all."""

from __future__ import annotations

from host.party import Party, PartySpec, Role
from host.store import PartyStore, commissioned


def boot(spec: PartySpec, store: PartyStore, file: str = "config.json") -> Party:
    """Start the party. Raises NotCommissioned if its store is blank, and InputError that names `file` where its
    configuration is not of this party.
    """
    commissioned(store, spec.called)
    match spec.role:
        # Imported here: a process loads its own role and nothing of the others.
        case Role.BLOCK_MANAGER | Role.POINT_TERMINAL | Role.LEVEL_CROSSING:
            from host.device import DeviceParty

            return DeviceParty(spec, store, file)
        case Role.UNIT:
            from host.unit import UnitParty

            return UnitParty(spec, store, file)
