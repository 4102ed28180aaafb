"""How each hop of each train was driven: running energy, notches, jerk, coasting, and how it came to its stop.

A hop is a leg of the energy's records: from a place where the train stops to the next. What the kernel counted in every
step (`simulation.world.ride`) is cut with the energy, so both are of the same run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

from network.units import J_PER_KWH
from simulation.result import EnergyRecord, Phase
from simulation.world.ride import BRAKES, COASTS, CRUISES, Ride, together
from vehicle.train_file import Receiver

Ends = tuple[str, str, str]  # train, from, to


@dataclass(frozen=True, slots=True)
class Stock:
    """What the table says of a stock: the law that drives it, and who takes what it gives back."""

    law: str
    regenerated_to: Receiver


@dataclass(frozen=True, slots=True)
class DrivenHop:
    """One hop as driven. `running_kwh` is traction less what came back, without auxiliaries.

    Shares are of the time in which the train moved and of the way. `late_s` counts from the latest arrival that keeps
    the plan, negative when early; it and `stop_error_m` are None where nothing was planned or the train did not come.
    """

    unit: str
    train: str
    revenue: bool
    law: str
    from_station: str
    to_station: str
    begin_s: float
    run_s: float
    distance_m: float
    traction_kwh: float
    regenerated_kwh: float
    running_kwh: float
    power_changes: int
    brake_changes: int
    jerk_max_mps3: float
    jerk_rms_mps3: float
    jolt_mps2: float
    coasting_time_percent: float
    coasting_way_percent: float
    cruising_time_percent: float
    cruising_way_percent: float
    braking_time_percent: float
    braking_way_percent: float
    late_s: float | None
    stop_error_m: float | None


@dataclass(frozen=True, slots=True)
class Driven:
    """Hops together: sums of energy, means over the hops, shares of all time and way; `early_s` is mean earliness."""

    hops: int
    traction_kwh: float
    regenerated_kwh: float
    running_kwh: float
    power_changes: float
    brake_changes: float
    jerk_max_mps3: float
    jerk_rms_mps3: float
    jolt_mps2: float
    coasting_time_percent: float
    coasting_way_percent: float
    cruising_time_percent: float
    cruising_way_percent: float
    braking_time_percent: float
    braking_way_percent: float
    early_s: float | None
    late_hops: int


def driven_hops(
    records: Iterable[EnergyRecord],
    stocks: Mapping[str, Stock],
    late_s: Mapping[Ends, float | None],
    stop_error_m: Mapping[tuple[str, str], float | None],
) -> tuple[DrivenHop, ...]:
    """Every hop that a train moved on, in the order in which they ended."""
    runs: dict[tuple[str, Ends], list[EnergyRecord]] = {}
    for record in records:
        if record.phase is Phase.RUNNING:
            ends = (record.number, record.from_id, record.to_id)
            runs.setdefault((record.stock_id, ends), []).append(record)
    return tuple(
        _hop(run, stocks[stock_id], late_s.get(ends), stop_error_m.get((ends[0], ends[2])))
        for (stock_id, ends), run in runs.items()
    )


def _hop(
    run: Sequence[EnergyRecord], stock: Stock, late_s: float | None, stop_error_m: float | None
) -> DrivenHop:
    first, ride = run[0], together(record.ride for record in run)
    traction_kwh = sum(record.traction_j for record in run) / J_PER_KWH
    regenerated_kwh = sum(record.regenerated_j for record in run) / J_PER_KWH
    back_kwh = 0.0 if stock.regenerated_to is Receiver.RESISTORS else regenerated_kwh
    return DrivenHop(
        first.stock_id,
        first.number,
        first.revenue,
        stock.law,
        first.from_id,
        first.to_id,
        first.begin_s,
        sum(record.end_s - record.begin_s for record in run),
        sum(record.distance_m for record in run),
        traction_kwh,
        regenerated_kwh,
        traction_kwh - back_kwh,
        ride.power_changes,
        ride.brake_changes,
        ride.jerk_max_mps3,
        ride.jerk_rms_mps3,
        ride.jolt_mps2,
        **_shares(ride),
        late_s=late_s,
        stop_error_m=stop_error_m,
    )


def _shares(ride: Ride) -> dict[str, float]:
    """Coasting, cruising and braking, each of the time and of the way, percent: the fields of a hop by name."""
    return {
        f"{name}_{of}_percent": 100.0 * part[manner] / whole if whole > 0.0 else 0.0
        for name, manner in (("coasting", COASTS), ("cruising", CRUISES), ("braking", BRAKES))
        for of, part, whole in (("time", ride.time_s, ride.moving_s), ("way", ride.way_m, ride.moved_m))
    }


def driven(hops: Sequence[DrivenHop]) -> Driven | None:
    """Hops together; None of none. The jerk's mean square is over all their time."""
    if not hops:
        return None
    run_s = sum(hop.run_s for hop in hops)
    late = [hop.late_s for hop in hops if hop.late_s is not None]

    def share(name: str) -> float:
        weights = [hop.run_s if name.endswith("time_percent") else hop.distance_m for hop in hops]
        weighed = sum(getattr(hop, name) * weight for hop, weight in zip(hops, weights, strict=True))
        return weighed / sum(weights) if sum(weights) > 0.0 else 0.0

    return Driven(
        len(hops),
        sum(hop.traction_kwh for hop in hops),
        sum(hop.regenerated_kwh for hop in hops),
        sum(hop.running_kwh for hop in hops),
        fmean(hop.power_changes for hop in hops),
        fmean(hop.brake_changes for hop in hops),
        max(hop.jerk_max_mps3 for hop in hops),
        (sum(hop.jerk_rms_mps3**2 * hop.run_s for hop in hops) / run_s) ** 0.5 if run_s > 0.0 else 0.0,
        max(hop.jolt_mps2 for hop in hops),
        share("coasting_time_percent"),
        share("coasting_way_percent"),
        share("cruising_time_percent"),
        share("cruising_way_percent"),
        share("braking_time_percent"),
        share("braking_way_percent"),
        -fmean(late) if late else None,
        sum(time_s > 0.0 for time_s in late),
    )
