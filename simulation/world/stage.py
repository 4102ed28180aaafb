"""The world of one run as one piece: what moves, decides and fails in it is given this, and nothing is added later."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from host.parties import Parties
from host.units import Units
from simulation.agenda import Agenda
from simulation.carriers.carrier import Carrier
from simulation.carriers.road import Road
from simulation.faults.fault import InForce
from simulation.journal import Journal
from simulation.setup import Setup
from simulation.world.books import Books
from simulation.world.cable import Cable
from simulation.world.charging import Charging
from simulation.world.crossings import CrossingLookout
from simulation.world.on_board import OnBoard
from simulation.world.points import WaysideWorld
from simulation.world.radio import Radio
from simulation.world.roster import Duty
from simulation.world.signs import Signs
from simulation.world.trains import Trains


@dataclass(frozen=True, slots=True)
class World:
    """Its parts, in the order in which each is made of those before it."""

    setup: Setup
    drawn: Mapping[str, tuple[Duty, ...]]  # the duties of each stock
    journal: Journal
    agenda: Agenda
    in_force: InForce
    trains: Trains
    wayside: WaysideWorld
    books: Books
    charging: Charging | None  # None: all trains run from a wire
    on_board: OnBoard
    signs: Signs
    road: Road | None  # None: none is carried
    lookout: CrossingLookout


def world_of(
    setup: Setup,
    drawn: Mapping[str, tuple[Duty, ...]],
    journal: Journal,
    carrier: Carrier,
    parties: Parties,
    units: Units,
    road: Road | None = None,
) -> World:
    """The world before its day begins."""
    agenda, in_force, trains = Agenda(), InForce(), Trains(setup, carrier)
    cable, radio = Cable(setup.line, setup.operation), Radio(setup, trains.reached, in_force)
    wayside = WaysideWorld(setup.line, parties, radio, agenda, journal, cable, trains.place_m, road)
    books = Books(trains)
    charging = None if setup.battery is None else Charging(setup, setup.battery, trains, books, drawn)
    on_board = OnBoard(setup, trains, units, charging)
    signs = Signs(trains, books.next_target)
    lookout = CrossingLookout(setup.line, trains, journal, wayside.input)
    return World(
        setup,
        drawn,
        journal,
        agenda,
        in_force,
        trains,
        wayside,
        books,
        charging,
        on_board,
        signs,
        road,
        lookout,
    )
