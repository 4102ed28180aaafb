"""Who works the line of a run past the units: by substitute working, or by line signals; most runs have nobody."""

from __future__ import annotations

from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.line_signals.working import LineSignalWorking
from simulation.substitute.players import SubstitutePlayers
from simulation.world.stage import World


def worked_by_people(
    world: World, cabs: Cabs, duties: Duties
) -> SubstitutePlayers | LineSignalWorking | None:
    """Those of a run; None: trains run under authority, come what may."""
    if world.setup.line_signals is not None:
        return LineSignalWorking(world, cabs, duties, world.setup.line_signals)
    if world.setup.substitute is not None:
        return SubstitutePlayers(world, cabs, duties, world.setup.substitute)
    return None
