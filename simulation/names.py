"""Everything of a setup that a fault or a person may name."""

from __future__ import annotations

from network.graph import all_routes
from simulation.faults.cable import stretches_of
from simulation.faults.fault import Names
from simulation.setup import Setup
from wayside.config import MANAGER_ID


def names_in(setup: Setup, people: tuple[str, ...] = ()) -> Names:
    """Every name that a script of the setup may use; `people` are those who act in it."""
    line, timetable, as_before = setup.line, setup.timetable, setup.line_signals
    terminals = sorted({points.terminal_id for points in line.points.values()})
    crossings = tuple(crossing.id for crossing in line.crossings.values() if crossing.has_device)
    return Names(
        units=tuple(diagram.stock_id for diagram in timetable.diagrams),
        devices=(MANAGER_ID, *terminals, *crossings),
        crossings=crossings,
        trains=tuple(timetable.trains),
        people=people if as_before is None else (*people, *dict.fromkeys(act.who for act in as_before.act)),
        signals=() if as_before is None else tuple(signal.id for signal in as_before.signal),
        levers=() if as_before is None else tuple(lever.id for lever in as_before.lever),
        routes=tuple(route.id for route in all_routes(line)),
        cable=stretches_of(line),
        networks=setup.networks,
        chargers=() if setup.battery is None else tuple(line.chargers),
        on_battery=tuple(s for s, kind in setup.trains.items() if setup.battery and kind.battery is not None),
        tags=tuple(map(str, line.tags)),
        markers=tuple(map(str, line.markers)),
        points=tuple(line.points),
        sections=tuple(line.sections),
        stations=tuple(line.stations),
        pieces=tuple(line.pieces),
    )
