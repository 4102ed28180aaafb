"""Behaviours of on-board units, their timers and crews that can be taken away."""

import math
from collections.abc import Collection, Sequence
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from network.model import Position
from onboard.authority import agreement, points, report, sign_on
from onboard.authority import records as sym
from onboard.authority.records import Authority
from onboard.authority.tables import Handler, Result
from onboard.driving import pattern
from onboard.duty import arrival, on_sight, shown
from onboard.duty import machine as duty_machine
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import (
    DrivingCommand,
    DutyPhase,
    OffTheLine,
    Person,
    PlaceInJoints,
    PointsSeen,
    PointsWrong,
    StopLimit,
)
from onboard.duty.stop_limit import stop_limit
from onboard.localisation import tags
from onboard.localisation.fix import Fix, RefusedFix, TakenFix, take_interval
from onboard.localisation.wheel_scale import WheelScale
from onboard.mission import Mission
from onboard.motion import UnitMotion
from onboard.notes import Claimed
from onboard.plan import DutyPlan, PointsNeeded
from onboard.records import EMERGENCY_INTERVENTION, PathData, UnitRow
from onboard.unit import OnboardUnit, Report, Telegram, UnitAnswer
from onboard.vehicle import VehicleInputs
from radio.messages import PointsCommand
from simulation.duties import Duties
from simulation.setup import Setup, behaviour_rows
from simulation.world.crew import Crew
from simulation.world.on_board import OnBoard
from simulation.world.roster import Duty
from simulation.world.trains import Trains
from tests.system.switchboard import ON_THE_POINTS_AFTER_S, switch, with_handlers
from verify.restored import RESTORED

# duty and timers ----------------------------------------------------------------------------------------------


@switch
def never_asks_again(patch: pytest.MonkeyPatch) -> None:
    def once(handler: Handler) -> Handler:
        def heard(state: Authority, event: sym.Event) -> Result:
            state, actions = handler(state, event)
            return state, tuple(sym.StopTimer(a.timer) if isinstance(a, sym.SetTimer) else a for a in actions)

        return heard

    with_handlers(patch, {sym.RefusalHeard: once})


@switch
def drops_its_timers(patch: pytest.MonkeyPatch) -> None:
    advance = OnboardUnit.advance

    def forgetful(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.state.authority.on_line:
            self._timers.clear()
            answer = msgspec.structs.replace(answer, wake_at_s=None)
        return answer

    patch.setattr(OnboardUnit, "advance", forgetful)


# on-board unit ------------------------------------------------------------------------------------------------


@switch
def releases_at_the_front(patch: pytest.MonkeyPatch) -> None:
    """What the front has surely passed counts as left by the rear, whatever tags say."""
    place = UnitMotion.place

    def at_front(self: UnitMotion) -> PlaceInJoints:
        here = place(self)
        passed = max(here.sure - 1, 0)
        return msgspec.structs.replace(here, clear=passed, clear_at_mark=passed)

    patch.setattr(UnitMotion, "place", at_front)
    patch.setattr(arrival, "arrived", lambda turn: turn.set(freed=len(turn.plan.spans)))


@switch
def releases_by_the_odometer(patch: pytest.MonkeyPatch) -> None:
    """As soon as the safe rear has left them, whatever tags say."""
    patch.setattr(arrival, "arrived", lambda turn: turn.set(freed=len(turn.plan.spans)))
    believes_any_tag(patch)


@switch
def keeps_what_is_of_no_use(patch: pytest.MonkeyPatch) -> None:
    """What the register gives it besides what it claims it holds until it comes there."""
    patch.setattr(arrival, "useless_ahead", lambda _turn: ())


@switch
def departs_before_the_driver_has_looked(patch: pytest.MonkeyPatch) -> None:
    """A train that its own bounds keep short of its mark takes that for its stop."""
    place = UnitMotion.place
    patch.setattr(UnitMotion, "place", lambda self: msgspec.structs.replace(place(self), unsure=False))


@switch
def waits_for_the_radio_without_a_position(patch: pytest.MonkeyPatch) -> None:
    """What could not be sent is sent where the radio reaches again, which a unit that is lost never sees."""
    say = DutyStep.say_what_waits
    patch.setattr(DutyStep, "say_what_waits", lambda self: say(self) if self.state.place.known else None)


@switch
def crews_enter_the_next_number_in_any_case(patch: pytest.MonkeyPatch) -> None:
    """Also where the unit, since a boot, has not finished its train again."""
    patch.setattr(Duties, "_is_yet_to_finish", lambda *_: False)


@switch
def asks_no_driver(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(shown, "to_confirm", lambda *_: False)
    patch.setattr(duty_machine, "to_confirm", lambda *_: False)


@switch
def does_not_hear_that_it_has_left(patch: pytest.MonkeyPatch) -> None:
    """A unit that has booted beyond the boundary goes on not knowing whether it is on the line."""
    heard = {at: what for at, what in duty_machine.TABLE.items() if at != (DutyPhase.OFF, OffTheLine)}
    patch.setattr(duty_machine, "TABLE", heard)


@switch
def silent_after_it_has_left(patch: pytest.MonkeyPatch) -> None:
    """A unit that has booted off the line says nothing to who speaks to its earlier boot."""
    with_handlers(patch, {sym.EarlierBootCalled: lambda _called: lambda state, _event: (state, ())})


@switch
def forgets_who_booted_as_it_left(patch: pytest.MonkeyPatch) -> None:
    """The manager shows nobody that a unit booted since it signed off says that it is outside."""
    for where, what, instead in RESTORED["booted-leaver-unheard"]():
        patch.setattr(where, what, instead)


@switch
def waits_where_it_is_held_up(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(duty_machine, "held_up", lambda _turn: None)


@switch
def keeps_the_emergency_latch(patch: pytest.MonkeyPatch) -> None:
    """A unit that has started again outside the line brakes, and nobody acknowledges it."""
    power_on = OnBoard.power_on

    def latched(self: OnBoard, slot: int) -> None:
        power_on(self, slot)
        self._trains.units[slot].intervention = EMERGENCY_INTERVENTION

    patch.setattr(OnBoard, "power_on", latched)
    patch.setattr(DutyStep, "await_release", lambda turn: turn.set(released=False))


@switch
def runs_on_in_a_contradiction(patch: pytest.MonkeyPatch) -> None:
    for module in (agreement, report):
        patch.setattr(module, "disagrees", lambda state, _why: (state, ()))


@switch
def does_not_wait_for_proof(patch: pytest.MonkeyPatch) -> None:
    def held_alone(
        plan: DutyPlan, state: Authority, _entered: Collection[str] = (), **how: bool
    ) -> StopLimit:
        bare = tuple(msgspec.structs.replace(span, points=()) for span in plan.spans)
        return stop_limit(msgspec.structs.replace(plan, spans=bare), state, **how)

    patch.setattr(duty_machine, "stop_limit", held_alone)


@switch
def ends_its_way_at_a_gap_behind(patch: pytest.MonkeyPatch) -> None:
    def from_the_first_held(
        plan: DutyPlan, state: Authority, *known: Collection[str], **how: int
    ) -> StopLimit:
        return stop_limit(plan, state, *known, **{**how, "left": 0})

    patch.setattr(duty_machine, "stop_limit", from_the_first_held)


@switch
def keeps_what_is_off_its_way(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(on_sight, "elsewhere", lambda _duty: ())


@switch
def runs_beyond_what_it_holds(patch: pytest.MonkeyPatch) -> None:
    def end_of_path(
        plan: DutyPlan, _state: Authority, _entered: Collection[str] = (), **_how: bool
    ) -> StopLimit:
        return StopLimit(len(plan.spans), None, "end of the path")

    patch.setattr(duty_machine, "stop_limit", end_of_path)


@switch
def ignores_a_withdrawn_proof(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(points, "_lost", lambda state, _event: (state, ()))


@switch
def claims_only_where_it_stands(patch: pytest.MonkeyPatch) -> None:
    def claim(_queried: Handler) -> Handler:
        def first(state: Authority, _event: sym.QueryHeard) -> Result:
            here = state.held[:1]
            return state, (sym.SendClaim(here), sym.Write(Claimed(section_ids=here, token=0)))

        return first

    with_handlers(patch, {sym.QueryHeard: claim})


@switch
def believes_any_tag(patch: pytest.MonkeyPatch) -> None:
    def take_any(row: UnitRow, fix: Fix, _span_m: tuple[float, float]) -> TakenFix | RefusedFix:
        row.position_known = 0  # so that nothing is compared
        return take_interval(row, fix)

    patch.setattr(tags, "missed_by_m", lambda *_: 0.0)
    patch.setattr(tags, "take_interval", take_any)
    patch.setattr(tags.TagDoubt, "believes", lambda *_: True)


@switch
def expects_no_tag(patch: pytest.MonkeyPatch) -> None:
    def expect(self: UnitMotion, _after_m: float | None = None) -> None:
        self.row.expected_tag_m = math.inf

    patch.setattr(UnitMotion, "_expect_tag", expect)


@switch
def bounds_do_not_grow(patch: pytest.MonkeyPatch) -> None:
    take_up, apply = UnitMotion._take_up, WheelScale.apply

    def certain(self: UnitMotion, *taken_up: Any) -> None:  # noqa: ANN401 - handed on
        take_up(self, *taken_up)
        self.row.bound_growth = 0.0

    def measured(self: WheelScale, scale: float) -> None:
        apply(self, scale)
        self._row.bound_growth = 0.0

    patch.setattr(UnitMotion, "_take_up", certain)
    patch.setattr(WheelScale, "apply", measured)


@switch
def knows_no_limits(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        pattern, "limit_for_length", lambda limit_mps, _length_m: np.full_like(limit_mps, limit_mps.max())
    )


@switch
def compares_no_axles(patch: pytest.MonkeyPatch) -> None:
    """The slide protection shows its unit no axle."""
    place = Trains.place

    def alone(self: Trains, slot: int, duty: Duty) -> None:
        place(self, slot, duty)
        self.stock["sensors"]["slide_protection"]["shows_axle"][slot] = 0

    patch.setattr(Trains, "place", alone)


@switch
def restarts_at_full_speed(patch: pytest.MonkeyPatch) -> None:
    obey = UnitMotion.obey

    def at_once(self: UnitMotion, command: DrivingCommand, now_s: float) -> None:
        obey(self, command, now_s)
        self.row.restricted_mps = math.inf

    patch.setattr(UnitMotion, "obey", at_once)


@switch
def service_brake_is_weak(patch: pytest.MonkeyPatch) -> None:
    """Given: the service brake gives a fifth of what automatic driving counts on; the emergency brake is sound."""
    place = Trains.place

    def worn(self: Trains, slot: int, duty: Duty) -> None:
        place(self, slot, duty)
        self._brake_factors[slot] = 0.2

    patch.setattr(Trains, "place", worn)


@switch
def supervision_trusts_any_brake(patch: pytest.MonkeyPatch) -> None:
    """Brakes taken for so strong that the curve before the stop limit leaves no room to stop."""

    def strong(setup: Setup, stocks: tuple[str, ...]) -> NDArray[np.void]:
        made = behaviour_rows(setup, stocks)
        made["service_guaranteed_mps2"] = made["emergency_guaranteed_mps2"] = 1e3
        made["service_reaction_s"] = made["emergency_reaction_s"] = 0.0
        return made

    patch.setattr("simulation.world.trains.behaviour_rows", strong)


@switch
def crew_does_not_look(patch: pytest.MonkeyPatch) -> None:
    stand = Crew.stand

    def nod(self: Crew, slot: int, now_s: float) -> list[Person]:
        return [PointsSeen(p.points) if isinstance(p, PointsWrong) else p for p in stand(self, slot, now_s)]

    patch.setattr(Crew, "stand", nod)


@switch
def crew_does_not_lock(patch: pytest.MonkeyPatch) -> None:
    """The crew only looks: what it has seen may change before its train has passed."""

    def looks(self: Crew, _slot: int, _mission: Mission, needed: PointsNeeded, _now_s: float) -> bool:
        machine = self._wayside.machines[needed.points_id]
        return machine.locked and machine.position is needed.position

    patch.setattr(Crew, "_locks", looks)


@switch
def commands_after_the_look(patch: pytest.MonkeyPatch) -> None:
    """Given: a unit commands P7 the other way, by its own token, when its train is on its way over it on sight."""
    advance, due_s = OnboardUnit.advance, list[float]()

    def rogue(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        answer = advance(self, now_s, telegrams, sensed)
        if any(isinstance(event, PointsSeen) for event in sensed.happened):
            due_s.append(now_s + ON_THE_POINTS_AFTER_S)
        if not due_s:
            return answer
        if now_s < due_s[0]:
            return msgspec.structs.replace(answer, wake_at_s=min(due_s[0], answer.wake_at_s or math.inf))
        due_s.clear()
        own = self._letters
        order = PointsCommand("P7", Position.REVERSE, "7", own.token, own._macs["7", "B-W"])
        data = self._endpoint.seal("B-W", order, now_s)
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, Telegram("B-W", data)))

    patch.setattr(OnboardUnit, "advance", rogue)


# durable state -------------------------------------------------------------------------------------------------


@switch
def forgets_that_it_was_on_the_line(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("host.unit._was_on_line", lambda _kept: False)


@switch
def goes_on_as_if_it_had_been_on(patch: pytest.MonkeyPatch) -> None:
    """A unit's readers do not learn that it was off."""
    switch_on = UnitMotion.switch_on

    def unnoticed(
        motion: UnitMotion, mission: Mission, path: PathData, odometer_m: float, speed_mps: float
    ) -> None:
        switch_on(motion, mission, path, odometer_m, speed_mps)
        motion.row.boots -= 1

    patch.setattr(UnitMotion, "switch_on", unnoticed)


@switch
def waits_where_no_radio_reaches(patch: pytest.MonkeyPatch) -> None:
    """A train that is halted there stands until it hears that it may go on."""
    patch.setattr(on_sight, "seek_radio", lambda _duty: None)
    patch.setattr(on_sight, "hears_nothing", lambda _duty: False)


@switch
def waits_for_units_to_end_trains(patch: pytest.MonkeyPatch) -> None:
    """By substitute working nobody turns a train whose unit, without a manager, does not end it."""
    patch.setattr(Duties, "is_to_turn", lambda *_: False)


@switch
def goes_by_proofs_of_before(patch: pytest.MonkeyPatch) -> None:
    """A unit that persons have spoken for goes by what its points showed it before."""
    patch.setattr(sign_on, "FORGETS_PROOFS", False)


@switch
def sees_no_vehicle(patch: pytest.MonkeyPatch) -> None:
    """Whatever is wrong with doors, brake or motors, the unit does not see it."""
    patch.setattr(VehicleInputs, "unfit", "")
