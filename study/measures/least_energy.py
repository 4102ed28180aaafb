"""What each hop of a run could have cost at the least: the proven bound of a run in the same time (最小電力量).

The course is the train as it is, with the load that it carried, from mark to mark on the true line. Energy is traction
less what came back, at the wire, without auxiliaries, as `study.measures.driving` has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from network.profile import profile_of
from network.units import J_PER_KWH
from onboard.driving.pattern import limit_for_train, lowered_by
from simulation.result import RunResult
from simulation.setup import Setup
from study.measures.running_times import TrainHop, planned_hops
from study.record.driving import DrivenHop
from vehicle.optimum import Course, least_energy, least_time
from vehicle.optimum.bound import lower_bound_j
from vehicle.resistance import climb_m
from vehicle.train_file import RegenerationReceiver

JUST_POSSIBLE: Final = (
    1.005  # of the least time: faster trains count as this fast, which only lowers their bound
)
Key = tuple[str, str, str]  # train, from, to


@dataclass(frozen=True, slots=True)
class Allowed:
    """What a run may do: how far it stays below the limits, and how hard it brakes towards lower ones and the stop."""

    below_limit_mps: float
    deceleration_mps2: float

    @classmethod
    def as_units_drive(cls, setup: Setup) -> Allowed:
        """As far below the limits as units stay, and by their pattern: the problem that a plan of theirs solves."""
        return cls(setup.driving.driving_margin_mps, setup.driving.stop_deceleration_mps2)

    @classmethod
    def anything(cls, setup: Setup) -> Allowed:
        """Up to the limits, and by the strongest service brake of any train here."""
        rows = [kind.row[0] for kind in setup.trains.values()]
        strongest = max(float(row["brake_deceleration_mps2"][int(row["brake_notches"])]) for row in rows)
        return cls(0.0, strongest)


@dataclass(frozen=True, slots=True)
class HopLeast:
    """One hop: what it took, and what no run of its course within `time_s` can go below, kWh.

    `least_kwh` is the optimum that was found, `flat_out` that the hop was run as fast as its course can be.
    """

    train: str
    from_station: str
    to_station: str
    time_s: float
    running_kwh: float
    least_kwh: float
    bound_kwh: float
    flat_out: bool

    @property
    def key(self) -> Key:
        """What names the hop of the timetable."""
        return self.train, self.from_station, self.to_station


@dataclass(frozen=True, slots=True)
class LeastEnergy:
    """Hops together, kWh."""

    hops: int
    running_kwh: float
    least_kwh: float
    bound_kwh: float

    @classmethod
    def sum_of(cls, hops: Iterable[HopLeast]) -> LeastEnergy:
        """Their sums."""
        whole = tuple(hops)
        return cls(
            len(whole),
            sum(hop.running_kwh for hop in whole),
            sum(hop.least_kwh for hop in whole),
            sum(hop.bound_kwh for hop in whole),
        )

    @property
    def above_bound_percent(self) -> float:
        """How far what was taken lies above the bound, percent of the bound."""
        return 100.0 * (self.running_kwh / self.bound_kwh - 1.0)


def least_of_hops(
    setup: Setup,
    result: RunResult,
    driven: Iterable[DrivenHop],
    allowed: Allowed,
    time_s: Mapping[Key, float] | None = None,
) -> tuple[HopLeast, ...]:
    """Every hop of the timetable that was driven, beside the least for its running time, or for that of `time_s`."""
    loads = {(result.stock_ids[span.slot], span.number): span.load_share for span in result.spans}
    by_ends = {(hop.train, hop.from_station, hop.to_station): hop for hop in driven}
    found: list[HopLeast] = []
    for planned in planned_hops(setup):
        key = (planned.mission.number, planned.here.station_id or "", planned.there.station_id or "")
        hop = by_ends.get(key)
        if hop is None or (time_s is not None and key not in time_s):
            continue
        load = loads[planned.stock_id, planned.mission.number]
        course = course_of(setup, planned, load, allowed)
        found.append(_least(course, hop, hop.run_s if time_s is None else time_s[key]))
    return tuple(found)


def course_of(setup: Setup, hop: TrainHop, load_share: float, allowed: Allowed) -> Course:
    """The course of one hop, within what is allowed."""
    kind, way = setup.trains[hop.stock_id], hop.way(setup.line)
    train = kind.row.view(np.recarray)[0]
    profile = profile_of(way.line, way.path)
    limit_mps = limit_for_train(profile["limit_mps"], train)
    if allowed.below_limit_mps > 0.0:
        limit_mps = lowered_by(limit_mps, allowed.below_limit_mps)
    return Course(
        kind.row[0],
        load_share,
        np.ascontiguousarray(climb_m(train, profile["elevation_m"], profile["turn_rad"])),
        np.ascontiguousarray(limit_mps),
        way.from_m,
        way.to_m,
        allowed.deceleration_mps2,
        regeneration=0.0 if kind.regenerated_to is RegenerationReceiver.RESISTORS else 1.0,
    )


def _least(course: Course, hop: DrivenHop, time_s: float) -> HopLeast:
    """The least of a course in that time; in hardly more than its least time where it cannot be run faster."""
    just_s = float(least_time(course).time_s[-1]) * JUST_POSSIBLE
    flat_out, time_s = time_s < just_s, max(time_s, just_s)
    best = least_energy(course, time_s)
    return HopLeast(
        hop.train,
        hop.from_station,
        hop.to_station,
        time_s,
        hop.running_kwh,
        float(best.energy_j) / J_PER_KWH,
        float(lower_bound_j(course, best, time_s)) / J_PER_KWH,
        flat_out,
    )
