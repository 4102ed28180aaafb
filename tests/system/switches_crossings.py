"""Switches of level crossings: device and unit."""

import math
from typing import Any

import pytest
from msgspec.structs import replace

from onboard.crossings import ahead, talk
from onboard.crossings import machine as crossings
from onboard.crossings.machine import CrossingPhase, CrossingSeen, CrossingUnplaced, CrossingView
from onboard.duty.records import DutyState
from onboard.motion import UnitMotion
from radio.envelope import Received
from radio.messages import CrossingClear, CrossingOver, CrossingOverHeard
from simulation.roads_closed import RoadsClosedForNothing
from simulation.substitute import players
from simulation.world import crossing_equipment
from simulation.world.crossings import CrossingsOnTrack
from tests.system.switchboard import switch
from wayside import level_crossing
from wayside.actions import Send
from wayside.config import CrossingConfig
from wayside.crossing_said import CrossingContact
from wayside.level_crossing import ClosureAsked, CrossingDevice, CrossingLeft, CrossingMemory, CrossingState


@switch
def passes_unproven_crossings(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(talk, "may_pass", lambda *_: True)


@switch
def asks_no_crossing_in_time(patch: pytest.MonkeyPatch) -> None:
    """Announces itself when its front could be there at once."""
    patch.setattr(crossings.CrossingPlace, "due_s", property(lambda self: self.fastest_s - 10.0))


@switch
def leaves_unannounced(patch: pytest.MonkeyPatch) -> None:
    """A unit that takes every contact for one that has warned of its train."""
    patch.setattr(ahead, "no_contact_passed", lambda *_: False)


@switch
def leaves_before_the_road_is_ready(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(talk, "starts_too_soon", lambda *_: False)


@switch
def keeps_no_least_time(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(crossings, "KEEPS_LEAST_TIME", False)


@switch
def proves_lamps_alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(level_crossing, "_shuts", lambda device: device.detected.lamps)


@switch
def proves_what_it_commands(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(level_crossing, "_shuts", lambda _device: True)


@switch
def creeps_without_looking(patch: pytest.MonkeyPatch) -> None:
    """A driver with leave to creep, who does not see what stands on the road."""
    patch.setattr(CrossingsOnTrack, "is_blocked", lambda *_: False)


@switch
def is_not_seen_on_the_road(patch: pytest.MonkeyPatch) -> None:
    """A train for which no driver on the road stops."""
    patch.setattr(CrossingsOnTrack, "creeps_over", lambda *_: None)


@switch
def believes_one_person(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(level_crossing, "PERSONS", 1)


@switch
def strikes_off_at_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(level_crossing, "FREES_S", 0.0)


@switch
def looks_at_no_road(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(RoadsClosedForNothing, "for_nothing", lambda _self: ())


@switch
def stops_no_road(patch: pytest.MonkeyPatch) -> None:
    """Who guards a crossing gives his word, and has not stopped its road."""
    patch.setattr(CrossingsOnTrack, "stop_road", lambda *_: None)


@switch
def runs_over_crossings_by_hand(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(players, "STOPS_AT_CROSSINGS", False)


@switch
def feels_no_button(patch: pytest.MonkeyPatch) -> None:
    """A crossing whose button reaches nobody."""
    detection = crossing_equipment.detection
    patch.setattr(
        crossing_equipment, "detection", lambda equipment: replace(detection(equipment), button=False)
    )


@switch
def calls_every_road_clear(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        level_crossing,
        "_clear",
        lambda device, unit_id: Send(
            unit_id, CrossingClear(clear=True, valid_s=level_crossing.VALID_S), device.listening[unit_id]
        ),
    )


@switch
def counts_no_rear(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        level_crossing,
        "TABLE",
        {
            **level_crossing.TABLE,
            (CrossingState.CLOSED, CrossingContact): lambda device, _event, _now_s: (device, ()),
        },
    )


@switch
def counts_one_train_in_the_dark(patch: pytest.MonkeyPatch) -> None:
    """By contacts, one front at the most has come while the device was dark, and its rear opens the road."""
    start = level_crossing.start

    def counted(
        config: CrossingConfig, memory: CrossingMemory, *, lost: bool = False, again: bool = False
    ) -> CrossingDevice:
        more = int(again and config.contacts)
        return start(config, replace(memory, counted=memory.counted + more), lost=lost)

    patch.setattr(level_crossing, "start", counted)


@switch
def opens_in_silence(patch: pytest.MonkeyPatch) -> None:
    """Who has not been heard for a proof's time is not announced any more."""
    step = level_crossing.step
    heard_s: dict[str, float] = {}

    def stepped(
        device: CrossingDevice, event: level_crossing.CrossingEvent, now_s: float
    ) -> level_crossing.CrossingStep:
        if isinstance(event, ClosureAsked):
            heard_s[event.unit_id] = now_s
        silent = [unit_id for unit_id in device.approaches if now_s > heard_s.get(unit_id, now_s) + 12.0]
        actions: tuple[Any, ...] = ()
        for unit_id in silent:
            left = CrossingLeft(unit_id, 0, CrossingOver(passed=False))
            device, more = step(device, left, now_s)
            actions += more
        device, more = step(device, event, now_s)
        return device, (*actions, *more)

    patch.setattr(level_crossing, "step", stepped)
    patch.setattr(level_crossing, "wake_at_s", lambda _device: max(heard_s.values(), default=0.0) + 13.0)


@switch
def closes_once(patch: pytest.MonkeyPatch) -> None:
    """A device that does not close again once it has opened."""
    opened: list[float] = []
    leave, ask = (
        level_crossing.TABLE[CrossingState.CLOSED, CrossingLeft],
        level_crossing.TABLE[CrossingState.OPEN, ClosureAsked],
    )

    def left(device: CrossingDevice, event: CrossingLeft, now_s: float) -> level_crossing.CrossingStep:
        opened.append(now_s)
        return leave(device, event, now_s)

    def asked(device: CrossingDevice, event: ClosureAsked, now_s: float) -> level_crossing.CrossingStep:
        return (device, ()) if opened else ask(device, event, now_s)

    table = {
        **level_crossing.TABLE,
        (CrossingState.CLOSED, CrossingLeft): left,
        (CrossingState.OPEN, ClosureAsked): asked,
    }
    patch.setattr(level_crossing, "TABLE", table)


@switch
def gives_up_where_its_front_may_stand(patch: pytest.MonkeyPatch) -> None:
    """A unit that has booted and finds its train standing, with its front perhaps on the road."""
    at, look = (CrossingPhase.AHEAD, CrossingSeen), crossings.TABLE[CrossingPhase.AHEAD, CrossingSeen]

    def looked(view: CrossingView, event: CrossingSeen, now_s: float) -> crossings.CrossingStep:
        place = event.place
        stands = place is not None and place.stands and not place.under
        return (
            crossings._gives_up(view, now_s, passed=False)
            if view.forgot and stands
            else look(view, event, now_s)
        )

    patch.setattr(crossings, "TABLE", {**crossings.TABLE, at: looked})


@switch
def passes_by_having_been_on_it(patch: pytest.MonkeyPatch) -> None:
    """A unit that goes on taking its train to be on a crossing when it has lost its position there."""
    rows = {at: row for at, row in crossings.TABLE.items() if at[1] is not CrossingUnplaced}
    look = rows[CrossingPhase.PASSING, CrossingSeen]

    def looked(view: CrossingView, event: CrossingSeen, now_s: float) -> crossings.CrossingStep:
        after, said = look(replace(view, until_s=math.inf), event, now_s)
        return (replace(after, until_s=view.until_s) if after.phase is view.phase else after), said

    patch.setattr(crossings, "TABLE", {**rows, (CrossingPhase.PASSING, CrossingSeen): looked})


@switch
def proves_lamps_that_shine_again_at_once(patch: pytest.MonkeyPatch) -> None:
    """Where lamps alone close the road: while a unit may still go by the proof of before."""
    patch.setattr(level_crossing, "_proves_from_s", lambda device: device.lit_s + device.config.closing_s)


@switch
def guards_no_road_far_ahead(patch: pytest.MonkeyPatch) -> None:
    """A unit whose movement limit lies beyond a crossing that is still far, should it say no more."""
    patch.setattr(talk.CrossingTalk, "guarded", talk.CrossingTalk.held_before)


@switch
def asks_only_behind_its_last_stop(patch: pytest.MonkeyPatch) -> None:
    """A train counted as arrived short of its mark, which does not see that it has yet to come to a crossing."""
    runs = talk._as_it_runs

    def seen(place: crossings.CrossingPlace, state: DutyState, leaves_in_s: float) -> crossings.CrossingPlace:
        behind = replace(place, arrives_s=math.inf, proof_s=math.inf)
        return behind if state.at > place.stop else runs(place, state, leaves_in_s)

    patch.setattr(talk, "_as_it_runs", seen)


@switch
def waits_for_a_crossing_beyond_its_mark(patch: pytest.MonkeyPatch) -> None:
    """Without room by its bounds; its unit has booted, and does not hear that the crossing has heard it."""
    idle = UnitMotion._stands_idle
    patch.setattr(
        UnitMotion,
        "_stands_idle",
        lambda motion: [] if motion.command.crossings.before else idle(motion),
    )
    hear = talk.CrossingTalk.hear

    def hears(unit: talk.CrossingTalk, heard: Received, now_s: float) -> bool:
        to_nothing = isinstance(heard.message, CrossingOverHeard) and heard.correlation == talk.NEVER_ASKED
        return to_nothing or hear(unit, heard, now_s)

    patch.setattr(talk.CrossingTalk, "hear", hears)
