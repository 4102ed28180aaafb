"""Giving back what lies behind (閉そく解放): at the arrival tag (①), once (Sugiyama et al. 2017, section 2.2).

Invariant: nothing is given back that neither a tag nor the driver's eye proves to be behind the whole train; the
odometer is a second condition to the tag, and never one by itself.
"""

from __future__ import annotations

from onboard.authority.records import GiveBack
from onboard.duty.records import AtMark
from onboard.duty.shown import AT_A_MARK
from onboard.duty.turn import Turn


def clear_behind(turn: Turn) -> None:
    """Give back what tags prove to be behind (①, once), and the safe rear by the odometer has left, too.

    At a mark on a track every tag read so far counts; what none of them proves, the driver is asked to confirm.
    """
    state = turn.state
    place, at_mark = state.place, state.phase in AT_A_MARK
    arrived(turn)
    clear = place.clear_at_mark if at_mark else place.clear
    turn.give_back_behind(min(clear, turn.state.freed))
    on_path = {span.section_id for span in turn.plan.spans}
    elsewhere = tuple(s for s in state.authority.held if s not in on_path)
    if elsewhere:  # the train lies on its path as a whole, so it is not there and will not be
        turn.authority(GiveBack(elsewhere))


def arrived(turn: Turn) -> None:
    """At a mark on a track, what tags prove to be behind may be given back, whichever tags they are.

    So it is where the train is stopped because another claims what it holds.
    """
    state = turn.state
    if state.halted:
        turn.set(freed=max(state.freed, state.proved))
    if state.phase in AT_A_MARK:
        turn.set(freed=max(state.freed, min(state.proved, turn.stop(state.at).clear)))


def confirm(turn: Turn, event: AtMark) -> None:
    """The driver sees the whole train at its mark (到着確認): what is surely behind is given back."""
    if event.stop == turn.state.at:
        turn.give_back_behind(turn.stop(event.stop).clear)
