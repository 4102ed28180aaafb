"""Which trains come to their portal later than planned, and how late; each train has a stream of its own."""

from __future__ import annotations

from network.timetable import AtPortal, TimetableTrain
from radio.chance import generator
from simulation.late.settings import EntryDelays, Late

STREAM = "late"  # the first name of every source of a late day


def entry_of(late: Late, train: TimetableTrain) -> tuple[str, EntryDelays] | None:
    """The first table that fits a train, with its name; None: it does not enter by a portal, or none fits."""
    if not isinstance(train.begins, AtPortal):
        return None
    portal = train.begins.section_id
    fits = (
        (name, table) for name, table in late.entry.items() if not table.portals or portal in table.portals
    )
    return next(fits, None)


def entry_late_s(late: Late, seed: int, today: tuple[str, ...], train: TimetableTrain) -> float:
    """How much later than planned a train comes to its portal, s; 0 where it is on time."""
    found = entry_of(late, train)
    if found is None or not found[1].on:
        return 0.0
    chance = generator(seed, STREAM, "entry", train.number, *today)
    comes_late = chance.random() < found[1].share
    return found[1].seconds.draw_s(chance) if comes_late else 0.0
