"""A run without its tables, and its parties, each of which somebody looks at after it has acted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, Self

from host.device import DeviceParty
from host.local import LocalParties
from host.parties import Parties
from host.party import Advance
from host.scratch import scratch
from host.unit import UnitParty
from onboard.duty.records import DutyState
from onboard.plan import DutyPlan
from scenario.scenario import Scenario
from simulation.journal import Journal
from simulation.result import RunResult
from study.runner.run import CarrierKind, RunOptions, UnitsAt, carrier_factory, run_to_end
from sumo_cfg.build import net_for
from sumo_cfg.truth_map import read_net
from wayside.point_terminal import Terminal
from wayside.register import Register

PartyState = Register | Terminal | tuple[DutyPlan, DutyState] | None  # None: without power
Look = Callable[[str, PartyState], None]


def result_of(
    scenario: Scenario,
    carrier: CarrierKind,
    units: UnitsAt = UnitsAt.SIMULATOR,
    watch: Callable[[Parties], Parties] | None = None,
    journal: Callable[[], Journal] = Journal,
) -> RunResult:
    """Run a scenario to its end, of which nothing stays. Raises Crashed for a bug."""
    with scratch("evidence-") as folder:
        net = net_for(scenario.setup.line, folder)
        make = carrier_factory(carrier, scenario.setup.line, net)
        options = RunOptions(make, read_net(net), folder, units=units, watch=watch, journal=journal)
        return run_to_end(scenario, options)[1]


class WatchedParties:
    """`host.parties.Parties` in this process, each state shown to `look` when it has acted, or lost its power."""

    def __init__(self, parties: Parties, look: Look) -> None:
        if not isinstance(parties, LocalParties):
            raise TypeError("only parties in this process can be looked at")
        self._parties: Final = parties
        self._look: Final = look

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Whoever entered the parties ends them."""

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s`."""
        done = self._parties.advance(party_id, now_s, telegrams, told)
        self._look(party_id, self._state(party_id))
        return done

    def alive(self, party_id: str) -> bool:
        """Whether the party runs."""
        return self._parties.alive(party_id)

    def kill(self, party_id: str) -> None:
        """Power cut."""
        self._parties.kill(party_id)
        self._look(party_id, None)

    def restart(self, party_id: str) -> None:
        """Power back."""
        self._parties.restart(party_id)
        self._look(party_id, self._state(party_id))

    def lose(self, party_id: str) -> None:
        """Its durable state is gone."""
        self._parties.lose(party_id)

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """People put it into service again."""
        self._parties.commission(party_id, number, vital)

    def _state(self, party_id: str) -> PartyState:
        match self._parties.running(party_id):
            case DeviceParty(state=(Register() | Terminal()) as state):
                return state
            case UnitParty() as unit:
                return unit.on_duty
            case _:
                return None
