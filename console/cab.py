"""What a driver sees in the cab: what the unit shows, and where the handle is."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from console.crossings_seen import CrossingsSeen
from console.protocol import CabShown, CrossingInCab
from console.session import Session
from network.model import LevelCrossing
from network.path import Path
from onboard.crossings.ahead import STOPS_SHORT_M
from onboard.driving.laws.by_hand import by_hand
from onboard.driving.laws.table import LAWS
from onboard.duty.records import DrivingCommand
from onboard.mission import Target
from study.wording.catalogue import phrases_of
from study.wording.phrase import Names, Phrase, joined_phrases, names_of
from study.wording.reasons import reason

LIMIT_BEFORE_ROAD_M: Final = STOPS_SHORT_M + 1.0


def cab_of(session: Session, unit: str, crossings: CrossingsSeen) -> CabShown:
    """The cab of a unit at present, which has heard this of level crossings; its speed is exact, what its unit has
    worked out up to 1 s old.
    """
    simulation = session.simulation
    trains = simulation.trains
    slot = trains.slot_of[unit]
    duty, kind, laws = trains.duties[slot], trains.kinds[slot], trains.laws[slot]
    command = simulation.on_board.shown_to_driver(slot)
    on_line = slot in trains.active()
    motion = session.motion(slot) if on_line else None
    sample = simulation.sample_at(slot, session.step) if on_line else None
    row = trains.units[slot]
    known = motion is not None and bool(row.position_known) and not command.on_sight
    off_m = 0.0 if sample is None else float(sample["estimate_error_m"])
    at_m = motion.position_m + off_m if motion is not None and known else None
    target = None if duty is None else _next_stop(command, duty.mission.targets)
    stands = target if command.stands_at is None or duty is None else duty.mission.targets[command.stands_at]
    handed = LAWS[int(laws.number)].name == by_hand.__name__
    line, path = session.scenario.setup.line, trains.true_path(slot) if on_line else None
    waits = wait_text(simulation.waits_for(slot), names_of(line))
    ahead = None
    if motion is not None and path is not None:
        roads = line.crossings.values()
        heard = (one for one in roads if one.tells_units and simulation.on_board.asks_crossing(slot, one.id))
        ahead = _next_crossing(heard, path, motion.position_m + off_m)
    limit_m = float(row.stop_limit_m)
    # Where the limit is that which the unit keeps before a crossing, that is why it ends there.
    at_road = (
        ahead is not None
        and command.crossings.guarded == ahead[0].id
        and ahead[1] - limit_m < LIMIT_BEFORE_ROAD_M
    )
    why = f"level crossing {command.crossings.guarded} to be proved closed" if at_road else command.limit.why
    return CabShown(
        unit=unit,
        train="" if duty is None else duty.train.number,
        powered=slot not in simulation.on_board.unpowered,
        speed_mps=0.0 if motion is None else motion.speed_mps,
        permitted_mps=None if sample is None else _finite(float(sample["permitted_mps"])),
        target_mps=0.0 if sample is None else _finite(float(sample["target_mps"])) or 0.0,
        notch=-float(kind.brake_notches) if sample is None else float(sample["notch"]),
        by_hand=handed,
        handle=float(laws.by_hand.notch) if handed else 0.0,  # type: ignore[attr-defined]
        power_notches=int(kind.power_notches),
        brake_notches=int(kind.brake_notches),
        intervention=0 if sample is None else int(sample["intervention"]),
        may_drive=command.drive,
        on_sight=command.on_sight or command.sweeps or command.crossings.creeps,
        authority_m=None if at_m is None else _finite(limit_m - at_m),
        why=why,
        why_ja=reason(why).in_("ja") if why else "",
        next_stop="" if target is None else target.place_id,
        next_stop_m=None if at_m is None or target is None else target.mark_m - at_m,
        arrives_s=None if target is None else target.arrival_s,
        departs_s=None if stands is None else stands.departure_s,
        held=command.held,
        waits_for=waits.en,
        waits_for_ja=waits.in_("ja"),
        crossing=None if ahead is None else _crossing_shown(crossings, unit, *ahead, at_m),
    )


def _next_crossing(
    heard: Iterable[LevelCrossing], path: Path, front_m: float
) -> tuple[LevelCrossing, float] | None:
    """The first of these crossings, which its unit hears, before the front, and where its road begins, m."""
    on_path = (one for one in heard if one.piece_id in path)
    ahead = [(one, road_m) for one in on_path if (road_m := path.to_road_m(one)) > front_m]
    return min(ahead, key=lambda found: found[1], default=None)


def _crossing_shown(
    crossings: CrossingsSeen, unit: str, crossing: LevelCrossing, road_m: float, at_m: float | None
) -> CrossingInCab:
    known = next(one for one in crossings.heard_by(unit) if one.id == crossing.id)
    ahead_m = None if at_m is None else road_m - at_m
    return CrossingInCab(name=crossing.name, ahead_m=ahead_m, state=known.state, creeps=bool(known.creeps))


def wait_text(waits_for: str, names: Names) -> Phrase:
    """What a train waits for, in words, with the names of stations."""
    known = phrases_of("cause").get(waits_for)
    return known or joined_phrases((reason(one, names) for one in waits_for.split("; ")), "; ")


def _next_stop(command: DrivingCommand, targets: tuple[Target, ...]) -> Target | None:
    following = command.at + 1 if command.target is None else command.target
    return targets[following] if following < len(targets) else None


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
