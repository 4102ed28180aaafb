"""Giving sections back (閉そく解放): what lies behind, at the arrival tag (①), once (Sugiyama et al. 2017, section
2.2), or section by section at each tag that proves it, and what is of no use ahead.

Invariant: nothing is given back that neither a tag nor the driver's eye proves to be behind the whole train; the
odometer is a second condition to the tag, and never one by itself. Ahead, only what the train stands surely short of.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from onboard.authority.records import GiveBack, RequestKind
from onboard.duty.duty_step import DutyStep
from onboard.duty.entering import kept_until_stand
from onboard.duty.records import AT_A_MARK, AtMark, DutyPhase, DutyState, TagBelieved
from onboard.duty_parameters import ReleaseRule


def clear_behind(duty: DutyStep) -> None:
    """Give back what tags prove to be behind (`freed`: ①, once, or each), and the safe rear by the odometer has left.

    At a mark on a track every tag read so far counts; what none of them proves, the driver is asked to confirm. Where
    opposing trains may not come in at once, arrival points are kept until it stands (`onboard.duty.entering`).
    """
    state = duty.state
    arrived(duty)
    duty.give_back_behind(min(left_by(state), duty.state.freed, kept_until_stand(duty.plan, duty.state)))
    if useless := (*elsewhere(duty), *useless_ahead(duty)):
        duty.authority(GiveBack(useless))


def left_by(state: DutyState) -> int:
    """How many spans of the plan the whole train has surely left, at a mark by what its driver sees there."""
    at_mark = state.phase in AT_A_MARK or state.phase is DutyPhase.LEAVING
    return state.place.clear_at_mark if at_mark else state.place.clear


def releases_at_each(duty: DutyStep, event: TagBelieved) -> bool:
    """Whether this tag releases whatever it is for; not the one that alone tells a lost position, as it may lie."""
    return duty.parameters.release is ReleaseRule.SECTION and not event.found


def elsewhere(duty: DutyStep) -> tuple[str, ...]:
    """What it holds off its path, by the register's word after a false claim: it lies on its path as a whole."""
    on_path = {span.section_id for span in duty.plan.spans}
    return tuple(section for section in duty.state.authority.held if section not in on_path)


def useless_ahead(duty: DutyStep) -> tuple[str, ...]:
    """What a train holds ahead of its stand of a route that it does not hold whole: it would keep others from it, and
    asks for the route anew as a whole. No grant gives so much; the register does, after a boot or a false claim.
    At its last mark nothing is ahead: as it changes ends, its place is that on the way back.
    """
    place, held = duty.state.place, duty.state.authority.held
    sections = [span.section_id for span in duty.plan.spans]
    lacks = next((i for i in range(place.perhaps, len(sections)) if sections[i] not in held), None)
    if lacks is None or not place.stands or duty.state.phase not in (DutyPhase.STANDING, DutyPhase.RUNNING):
        return ()
    under = max(place.perhaps - 1, 0)
    request = duty.state.authority.open(RequestKind.ROUTE)
    if request is not None and (request.section_ids or ())[:1] == (sections[lacks],):
        return beyond_gap(sections, held, under)  # it has a part of its way, and waits for the rest
    waits_in = {section for leg in duty.plan.legs for section in (leg.from_section, leg.section_ids[-1])}
    last = next((i for i in reversed(range(under, lacks)) if sections[i] in waits_in), lacks)
    return tuple(section for section in sections[last + 1 :] if section in held)


def beyond_gap(sections: Sequence[str], held: Collection[str], front: int) -> tuple[str, ...]:
    """What is held beyond the first section of the path, ahead of that at index `front`, that is not."""
    lacks = next((i for i in range(front + 1, len(sections)) if sections[i] not in held), len(sections))
    return tuple(section for section in sections[lacks:] if section in held)


def arrived(duty: DutyStep) -> None:
    """At a mark on a track, what tags prove to be behind may be given back, whichever tags they are.

    So it is where the train is stopped because another claims what it holds.
    """
    state = duty.state
    if state.halted:
        duty.set(freed=max(state.freed, state.proved))
    if state.phase in AT_A_MARK:
        duty.set(freed=max(state.freed, min(state.proved, duty.stop(state.at).clear)))


def confirm(duty: DutyStep, event: AtMark) -> None:
    """The driver sees the whole train at its mark (到着確認): what is surely behind is given back."""
    if event.stop == duty.state.at:
        duty.give_back_behind(duty.stop(event.stop).clear)
