"""Whether the batteries of the sets last by the plan: predicted hop by hop, charged where and as long as it has it.

The prediction is that of the units (`simulation.world.ways`), the battery is that of the run (`vehicle.battery`), and
what must be there before a set leaves is what its unit will ask for (`onboard.charge`). Faults are not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from network.clock import first_given
from network.units import J_PER_KWH
from onboard.charge import ChargeRules, commits_at
from onboard.mission import Target
from onboard.reach import BatteryHop, SetWays, charger_at, stands_s, to_next_charge
from simulation.battery_settings import BatterySettings, Departure
from simulation.setup import Setup
from simulation.world.charge_control import READY_S
from simulation.world.roster import Duty
from simulation.world.ways import ways_of
from study.feasibility.finding import Finding, FindingKind, Severity, length_of_time, minute, severity_of
from study.feasibility.planned import PlannedDay
from vehicle.battery import SHEDS_S, available_j, charge_to, soc_of, stand, window_j

STEP_S = 5.0
WAITS_S_MAX = 4.0 * 3600.0


@dataclass(slots=True)
class _SetCharge:
    """One set on its day: its battery as it would be."""

    setup: Setup
    settings: BatterySettings
    ways: SetWays
    battery: Any
    rules: ChargeRules
    auxiliary_w: float

    def run(self, energy_j: float, time_s: float) -> None:
        """Take what a run takes, auxiliaries among it, at its mean power; one that gives more than that charges."""
        finite_s = min(time_s, WAITS_S_MAX)  # who cannot climb takes for ever: another finding says so
        if finite_s > 0.0:
            stand(self.battery, energy_j / finite_s, 0.0, finite_s, STEP_S)

    def charge(self, power_w: float, time_s: float) -> None:
        if time_s > 0.0:
            stand(self.battery, self.auxiliary_w, power_w, time_s, STEP_S)

    def wait(self, time_s: float, keeps_j: float) -> float:
        """Stand without a charger; for how long of that what can wait is off, s."""
        shed_w = min(self.auxiliary_w, self.settings.shed_to_kw * 1e3)
        stood_s = shed_s = 0.0
        while stood_s < time_s:
            this_s = min(STEP_S, time_s - stood_s)
            sheds = stood_s >= SHEDS_S and available_j(self.battery) < keeps_j
            stand(self.battery, shed_w if sheds else self.auxiliary_w, 0.0, this_s, STEP_S)
            stood_s += this_s
            shed_s += this_s if sheds else 0.0
        return shed_s


def charge_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """What is wrong with the batteries of the day; nothing where trains run from a wire."""
    settings = setup.battery
    if settings is None or day.missing:
        return
    drawn = {stock_id: tuple(train.duty for train in trains) for stock_id, trains in day.trains.items()}
    ways = ways_of(setup, drawn)
    for stock_id, duties in drawn.items():
        kind = setup.trains[stock_id]
        if kind.battery is None or not duties:
            continue
        row = kind.battery[0].copy()
        share = settings.start_of.get(stock_id, settings.start_share)
        charge_to(row, share)
        rules = ChargeRules(
            settings.departure is Departure.WAIT,
            settings.reserve_share * float(window_j(row)),
            settings.prediction_share,
        )
        auxiliary_w = float(kind.row[0]["auxiliary_power_w"])
        yield from _day(_SetCharge(setup, settings, ways[stock_id], row, rules, auxiliary_w), duties)


def _day(one: _SetCharge, duties: tuple[Duty, ...]) -> Iterator[Finding]:
    """One set's day; it ends with the first thing that would keep it from going on."""
    left_s: float | None = None
    for duty, following in zip(duties, (*duties[1:], None), strict=True):
        if duty.enters and left_s is not None:
            _beyond(one, duties[duties.index(duty) - 1].train.number, duty.enter_s - left_s)
        found = list(_train(one, duty, following))
        yield from found
        if any(finding.short_s is None for finding in found):
            return
        ends = duty.mission.targets[-1]
        left_s = ends.arrival_s if ends.arrival_s is not None else duty.train.calls[-1].last_s


def _beyond(one: _SetCharge, number: str, away_s: float) -> None:
    beyond = one.settings.beyond_of(number)
    if beyond.takes_j > 0.0:  # all of it, however short the plan makes the time for it
        stand(one.battery, beyond.takes_j / beyond.runs_s, 0.0, beyond.runs_s, STEP_S)
        away_s -= beyond.runs_s
    charges_s = min(beyond.charge_min * 60.0, away_s)
    if charges_s > 0.0:
        stand(one.battery, 0.0, beyond.charge_kw * 1e3, charges_s, STEP_S)


def _train(one: _SetCharge, duty: Duty, following: Duty | None) -> Iterator[Finding]:
    """One train: at each stop charge and look whether it goes on, then the hop."""
    line, targets = one.setup.believed_line, duty.mission.targets
    dwell_s = one.setup.unit.duty.dwell_min_s
    hops = one.ways.ahead(duty.mission.number, 0)
    for at, target in enumerate(targets[:-1]):
        finding = _looks(one, duty, at, hops)
        if finding is not None:
            yield finding
            if finding.short_s is None:
                return
        one.run(hops[at].run_j, hops[at].run_s)
        there = targets[at + 1]
        last = at + 2 == len(targets)
        next_first = (
            following.mission.targets[0] if last and following is not None and not duty.leaves else None
        )
        keeps_j = one.rules.reserve_j
        if one.rules.waits and hops[at + 1 :]:
            keeps_j += one.rules.needed_j(to_next_charge(hops[at + 1 :], ()), commits=last)
        sheds_s = _stands(one, charger_at(line, there), stands_s(there, next_first, dwell_s), keeps_j)
        if sheds_s > 0.0 and available_j(one.battery) > 0.0:
            yield _sheds(duty, target, there, sheds_s, keeps_j)
        if available_j(one.battery) <= 0.0:
            text = f"{duty.train.number} would have an empty battery at {hops[at].to_place}"
            yield Finding(
                FindingKind.CHARGE,
                Severity.IMPOSSIBLE,
                (duty.train.number,),
                hops[at].from_place,
                first_given(target.departure_s, target.arrival_s, duty.enter_s),
                text,
                "more charging before that",
            )
            return


def _sheds(duty: Duty, target: Target, there: Target, sheds_s: float, keeps_j: float) -> Finding:
    """A stand without a charger that takes a set to what it is to keep."""
    text = (
        f"{duty.train.number} would come to what it keeps, {keeps_j / J_PER_KWH:.1f} kWh, as it stands at"
        f" {there.place_id}, and have heating and cooling off for {length_of_time(sheds_s)}"
    )
    time_s = first_given(there.arrival_s, target.departure_s, duty.enter_s)
    remedy = "a shorter stand, or a charger there"
    trains = (duty.train.number,)
    return Finding(FindingKind.CHARGE, Severity.TIGHT, trains, there.place_id, time_s, text, remedy, 0.0)


def _stands(one: _SetCharge, station_id: str, time_s: float, keeps_j: float) -> float:
    """A stand as planned: with the charger, if there is one and time for it; how long what can wait is off, s."""
    charger = one.setup.believed_line.chargers.get(station_id)
    connected_s = 0.0
    if charger is not None:
        connected_s = max(time_s - charger.connect_s - charger.disconnect_s - READY_S, 0.0)
        one.charge(charger.power_w, connected_s)
        one.charge(0.0, time_s - connected_s)
        return 0.0
    return one.wait(time_s, keeps_j)


def _looks(one: _SetCharge, duty: Duty, at: int, hops: Sequence[BatteryHop]) -> Finding | None:
    """Whether the set may leave a stop; it waits there for what it lacks, if there is a charger."""
    line, target = one.setup.believed_line, duty.mission.targets[at]
    reach = to_next_charge(hops[at:], ())
    commits = commits_at(line, duty.mission, at)
    needed_j = one.rules.needed_j(reach, commits=commits)
    has_j = float(available_j(one.battery))
    if not one.rules.waits or has_j >= needed_j:
        return None
    place = hops[at].from_place
    departs_s = first_given(target.departure_s, target.arrival_s, duty.enter_s)
    name = line.stations[place].name if place in line.stations else place
    where = f"to {reach.place}, where it can charge next" if reach.place else "to where its day ends"
    text = (
        f"{duty.train.number} would leave {name} at {minute(departs_s)} with {has_j / J_PER_KWH:.1f} kWh and needs"
        f" {needed_j / J_PER_KWH:.1f} kWh {where}"
    )
    charger = line.chargers.get(charger_at(line, target))
    waits_s = None if charger is None else _waits_s(one, charger.power_w, needed_j)
    trains = (duty.train.number,)
    if waits_s is None:
        remedy = _remedy(one, hops[at : at + reach.hops])
        if commits and has_j >= needed_j - one.rules.reserve_j:
            remedy += f"; a smaller reserve_share, as {one.rules.reserve_j / J_PER_KWH:.1f} kWh of that are kept back"
        return Finding(FindingKind.CHARGE, Severity.IMPOSSIBLE, trains, place, departs_s, text, remedy)
    text = f"{text}: it charges there for {length_of_time(waits_s)} longer"
    severity = severity_of(waits_s, target.departure_s)
    return Finding(
        FindingKind.CHARGE, severity, trains, place, departs_s, text, "more charging before that", waits_s
    )


def _remedy(one: _SetCharge, hops: Sequence[BatteryHop]) -> str:
    """What helps a set that never has enough for these hops: charging it is not, once it is full."""
    full = float(soc_of(one.battery)) >= float(one.battery["pack"]["soc_high"]) - 1e-6
    most_kwh = float(available_j(one.battery)) / J_PER_KWH
    parts = [
        f"a greater battery, as it has {most_kwh:.1f} kWh when full" if full else "more charging before that"
    ]
    saves_j = sum(hop.saves_j for hop in hops)
    if saves_j > 0.0:
        where = max(hops, key=lambda hop: hop.saves_j).to_place
        saves_kwh = (1.0 + one.rules.prediction_share) * saves_j / J_PER_KWH
        parts.append(
            f"a charger at {where} or a shorter stand there: {saves_kwh:.1f} kWh are for heating and cooling"
        )
    return "; ".join(parts)


def _waits_s(one: _SetCharge, power_w: float, needed_j: float) -> float | None:
    """How long a set must go on charging, s; None: it never has enough."""
    time_s = 0.0
    while float(available_j(one.battery)) < needed_j:
        if (
            time_s >= WAITS_S_MAX
            or float(soc_of(one.battery)) >= float(one.battery["pack"]["soc_high"]) - 1e-6
        ):
            return None
        one.charge(power_w, STEP_S)
        time_s += STEP_S
    return time_s
