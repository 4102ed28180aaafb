"""Where every stock is in its day, as the block manager can know it: from what it granted and what is held.

Fixed data: the moves of each stock's day (`wayside.config.Journey`). What the register adds: how many of them were
granted. A move counts as made when it is granted, since its train can always run what it holds; one that is given back
is to be made again. A stock that asks for what is not in its day is astray until it asks for something that is: nothing
is known of where it goes, so nobody is held for it, and it is held for nobody.
"""

from __future__ import annotations

from wayside.journeys import LOST, Days, PlannedMove, Stands
from wayside.register import Register


def stands_of(register: Register, days: Days) -> Stands:
    """Where all stock is, from the register. What is astray holds nothing here: it is in its own way."""
    held = dict.fromkeys(days.unit_ids, 0)
    for section_id, unit_id in register.holders.items():
        if unit_id in held:
            held[unit_id] |= days.bits[section_id]
    at: list[int] = []
    holds: list[int] = []
    for index, unit_id in enumerate(days.unit_ids):
        done, mask = _place(register, days, index, held[unit_id])
        at.append(done)
        holds.append(mask)
    return Stands(tuple(at), tuple(holds))


def _place(register: Register, days: Days, index: int, held: int) -> tuple[int, int]:
    """How many moves a stock has made, and what it holds once it has run what it was granted."""
    unit_id, hops = days.unit_ids[index], days.hops[index]
    trip = register.trip(unit_id)
    if trip.astray:
        return len(hops), 0
    done = trip.done if trip.done != LOST else _by_time(register.now_s, hops, held)
    if not held:
        enters = next((i for i in range(done, len(hops)) if not hops[i].route_id), len(hops))
        waits = enters < len(hops) and trip.asked_s is not None
        return enters, days.queues[hops[enters].section_id] if waits else 0
    if days.parts and done < len(hops) and hops[done].move.needs & held:
        arrives = done > 0 and hops[done - 1].end & held
        if trip.part or not arrives:  # it has a part of its next move
            return done, held
    place = done
    while place and hops[place - 1].train == hops[done - 1].train:
        hop = hops[place - 1]
        if hop.end & held:
            return place, hop.move.keeps
        place -= 1
        if hop.move.needs & held:  # given back on the way: it asks for the same again
            break
    return place, held


def _by_time(now_s: float, hops: tuple[PlannedMove, ...], held: int) -> int:
    """The place in its day at which a stock with these sections should be about now; its end where there is none."""
    fits = [
        (abs(hop.departs_s - now_s), place)
        for place, hop in enumerate(hops)
        if (hop.start & held if hop.route_id else not held)
    ]
    if hops and hops[-1].end & held:
        fits.append((abs(hops[-1].arrives_s - now_s), len(hops)))
    if not fits:  # on its way, with the place that it left given back: with all of it, or a part
        fits = [(abs(hop.arrives_s - now_s), k + 1) for k, hop in enumerate(hops) if hop.end & held]
    if not fits:
        fits = [(abs(hop.departs_s - now_s), k) for k, hop in enumerate(hops) if hop.line & held]
    return min(fits)[1] if fits else len(hops)
