"""What energy each stock took and gave, cut wherever it began to move or came to a stand (電力量).

Every joule that a plant counts on the line is in exactly one record: of a run between two places where the train was to
stop, of a stand there, of a stand elsewhere, of a layover, or of stock stabled after its last train. So is every joule
of the parts that it went into.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from simulation.result import COUNTED, EnergyPhase, EnergyRecord
from simulation.ride import NO_RIDE, taken
from simulation.setup import STEP_S, STEPS_PER_S
from simulation.world.roster import Duty
from simulation.world.trains import Trains


@dataclass(frozen=True, slots=True)
class Counters:
    """What a plant has counted since it was made: the way, m, and J at the wire or battery, by COUNTED."""

    travelled_m: float
    counted_j: Mapping[str, float]


@dataclass(slots=True)
class Account:
    """The open record of one stock, and those of the leg that it is on: its end is known on arrival alone."""

    duty: Duty
    phase: EnergyPhase
    at: int  # index of the target from which it left, or at which it stands
    since_step: int
    since: Counters
    leg: list[EnergyRecord] = field(default_factory=list[EnergyRecord])


class EnergyBook:
    """The energy records of one run, in the order in which they ended."""

    def __init__(self, trains: Trains) -> None:
        self.records: list[EnergyRecord] = []
        self._trains = trains
        self._accounts: dict[int, Account] = {}

    def begin(self, slot: int, duty: Duty, step: int) -> None:
        """A stock has taken up a train and stands at its first target."""
        phase = EnergyPhase.HELD if duty.mission.targets[0].station_id is None else EnergyPhase.LAYOVER
        self._accounts[slot] = Account(duty, phase, 0, step, self._counters(slot))
        taken(self._trains.rides[slot])  # whatever was before it is of no run

    def moves(self, slot: int, step: int) -> None:
        """A stock has moved in this step."""
        account = self._accounts.get(slot)
        if account is None or account.phase in (EnergyPhase.RUNNING, EnergyPhase.STABLED):
            return
        # No force does work on a train that stands: the step in which it began to move belongs to the run.
        since = account.since
        step_j = float(self._trains.bodies[slot].auxiliary_power_w) * STEP_S
        auxiliary_j = self._counters(slot).counted_j["auxiliary"] - step_j
        auxiliary_j = max(auxiliary_j, since.counted_j["auxiliary"])
        stood = replace(since, counted_j={**since.counted_j, "auxiliary": auxiliary_j})
        self._cut(slot, account, max(step - 1, account.since_step), stood)
        account.phase = EnergyPhase.RUNNING

    def stands(self, slot: int, step: int, at: int) -> None:
        """A stock has come to a stand; `at` is the index of the target at which it last called, perhaps here."""
        account = self._accounts.get(slot)
        if account is None or account.phase is EnergyPhase.STABLED:
            return
        arrived = at != account.at
        if not arrived and account.phase is not EnergyPhase.RUNNING:
            return
        self._cut(slot, account, step, self._counters(slot))
        targets = account.duty.mission.targets
        if not arrived:
            account.phase = EnergyPhase.HELD
            return
        self._arrive(account, at)
        ends = EnergyPhase.LAYOVER if at == len(targets) - 1 else EnergyPhase.AT_STOP
        account.phase = EnergyPhase.HELD if targets[at].station_id is None else ends

    def close(self, slot: int, step: int) -> None:
        """The stock's present train has ended, or the run."""
        account = self._accounts.pop(slot, None)
        if account is None:
            return
        self._cut(slot, account, step, self._counters(slot))
        self._arrive(account, min(account.at + 1, len(account.duty.mission.targets) - 1))

    def stable(self, slot: int, duty: Duty, step: int) -> None:
        """The stock stands after its last train; what is still switched on is counted apart."""
        self.close(slot, step)
        at = len(duty.mission.targets) - 1
        self._accounts[slot] = Account(duty, EnergyPhase.STABLED, at, step, self._counters(slot))

    def _cut(self, slot: int, account: Account, step: int, now: Counters) -> None:
        """End the open record; the next begins where it ends."""
        duty, since = account.duty, account.since
        targets = duty.mission.targets
        here = targets[account.at].place_id
        on_leg = account.phase in (EnergyPhase.RUNNING, EnergyPhase.HELD)
        record = EnergyRecord(
            self._trains.stock_ids[slot],
            duty.train.number,
            duty.train.revenue,
            account.phase,
            here,
            targets[min(account.at + 1, len(targets) - 1)].place_id if on_leg else here,
            account.since_step / STEPS_PER_S,
            step / STEPS_PER_S,
            now.travelled_m - since.travelled_m,
            {name: joules - since.counted_j[name] for name, joules in now.counted_j.items()},
            taken(self._trains.rides[slot]) if account.phase is EnergyPhase.RUNNING else NO_RIDE,
        )
        (account.leg if on_leg else self.records).append(record)
        account.since_step, account.since = step, now

    def _arrive(self, account: Account, at: int) -> None:
        """The leg ends at a target: perhaps beyond the next one, where the train has not called."""
        to_id = account.duty.mission.targets[at].place_id
        self.records += [replace(record, to_id=to_id) for record in account.leg]
        account.leg.clear()
        account.at = at

    def _counters(self, slot: int) -> Counters:
        plant = self._trains.plants[slot]
        return Counters(
            float(plant.travelled_m), {name: float(getattr(plant, f"energy_{name}_j")) for name in COUNTED}
        )
