"""A wait as one sentence, in English or Japanese (なぜ待っているか)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from network.clock import clock
from study.record.wait import AwaitedRequest, Cause, Wait
from study.wording.catalogue import phrase
from study.wording.phrase import NOTHING, Names, Phrase
from study.wording.reasons import reason
from wayside.config import MANAGER_ID

_ASKED: Final[Mapping[AwaitedRequest, Phrase]] = {
    AwaitedRequest.NOTHING: phrase("its command"),
    AwaitedRequest.SIGN_ON: phrase("its sign-on"),
    AwaitedRequest.SIGN_OFF: phrase("its sign-off"),
    AwaitedRequest.ROUTE: phrase("its request for a route"),
    AwaitedRequest.REPORT: phrase("its report of what it holds"),
}
_STATION: Final = phrase("station").ja  # stands once behind the name of each
_AT: Final = phrase("at {place}")
# Clauses that take up the reason of a wait otherwise than as a text after a colon.
_REASONS: Final[Mapping[str, Phrase]] = {
    "asks again": phrase(", which it repeats: nobody holds it up any more"),
    "clock": phrase(" by its own clock, which is wrong"),
    "operational": phrase(", without passengers"),
}
# Whoever and whatever may be missing has its own clause (`since`, `until`, `why`), which is then empty.
_SENTENCES: Final[Mapping[Cause, Phrase]] = {
    Cause.RUNS: phrase("{train} is running."),
    Cause.STOP_LIMIT: phrase(
        "{train} runs slower towards its stop limit before section {section} ({place}){why}."
    ),
    Cause.OUTSIDE: phrase("{train} is not on the line yet; it is due at section {section}{until}."),
    Cause.LEFT: phrase("{unit} has left the line after {train}."),
    Cause.LATE: phrase("{train} comes late to section {section}{until}."),
    Cause.QUEUE: phrase("{train} waits outside section {section} behind another train that is to enter."),
    Cause.PORTAL: phrase("{train} waits outside: a train still stands in section {section}."),
    Cause.DEPARTURE_TIME: phrase("{train} stands {place} until its departure time, {until_at}{why}."),
    Cause.DWELL: phrase("{train} stands {place} for its passengers{until}."),
    Cause.ROUTE_HELD: phrase(
        "{train} waits {place} for its way: section {section} is held by {party}{since}{until}."
    ),
    Cause.NO_WAY_ON: phrase(
        "{train} waits {place} for {party} to come to section {section}: if it went now, not all trains"
        " could still finish."
    ),
    Cause.NOT_ITS_TURN: phrase(
        "{train} waits {place} for {party}, which goes first, to come to section {section}."
    ),
    Cause.OVERLAP: phrase(
        "{train} waits {place} until {party} stands, or is out of the way: one of them could overrun into section"
        " {section}, where the other goes."
    ),
    Cause.REFUSED: phrase("{train} waits {place}: the block manager has refused {asked}{why}."),
    Cause.ANSWER: phrase("{train} waits {place} for the block manager's answer to {asked}{since}{why}."),
    Cause.COVERAGE: phrase(
        "{train} waits {place}: the radio does not reach there, and {asked} cannot be sent."
    ),
    Cause.SET_BACK: phrase(
        "{train} waits {place}: its crew has set back its route and asks for none for a while."
    ),
    Cause.POINTS_MOVE: phrase("{train} waits {place} while points {points} are thrown{since}."),
    Cause.POINTS_REFUSED: phrase("{train} waits {place}: terminal {party} has refused points {points}{why}."),
    Cause.POINTS_PROOF: phrase(
        "{train} waits {place} for terminal {party} to prove points {points}{since}{why}."
    ),
    Cause.POINTS_BY_EYE: phrase(
        "{train} waits {place} on sight until its crew sees points {points} lie as needed."
    ),
    Cause.LEVEL_CROSSING: phrase(
        "{train} waits {place} for level crossing {party} to be closed long enough, or for leave to creep over"
        " it{since}{why}."
    ),
    Cause.VEHICLE: phrase("{train} waits {place}: {reason}."),
    Cause.UNABLE: phrase("{train} stays {place}: it could not reach its next stop for want of {reason}."),
    Cause.EMERGENCY: phrase(
        "{train} waits {place} after an emergency stop, which its driver is to acknowledge."
    ),
    Cause.CONTRADICTION: phrase("{train} waits {place}: register and unit contradict each other{why}."),
    Cause.ON_SIGHT: phrase(
        "{train} stands {place} on sight until its crew sees that it can go on: its position is unknown."
    ),
    Cause.UNIT_OFF: phrase("{train} waits {place}: its on-board unit has no power."),
    Cause.BY_HAND: phrase(
        "{train} waits {place} for people or a signal to let it go: its on-board unit is cut out."
    ),
    Cause.UNIT_FROZEN: phrase("{train} waits {place}: its on-board unit does nothing (frozen)."),
    Cause.ARRIVAL_BY_EYE: phrase(
        "{train} waits {place} for its driver to confirm that the whole train has arrived."
    ),
    Cause.TURN_BACK: phrase("{train} stands {place} while its driver changes ends for {reason}."),
    Cause.NEXT_TRAIN: phrase("{train} stands {place} while its crew takes up {reason}."),
    Cause.NUMBER: phrase("{train} waits {place} for its crew to enter the train number."),
    Cause.ENTRY: phrase("{train} waits {place} for its crew to take it in: it is signed on."),
    Cause.SIGN_OFF: phrase("{train} waits {place} for its crew to sign off."),
    Cause.LEAVING: phrase("{train} is signed off {place} and is about to leave the line."),
    Cause.STARTING: phrase("{train} is about to start {place}: the way is free and the brakes release."),
    Cause.STABLED: phrase("{unit} is stabled {place} after {train}, its last train."),
}
_LIMITED_BY: Final[Mapping[str, Phrase]] = {  # causes, where one holds the stop limit back
    Cause.ROUTE_HELD.value: phrase("held by {party}{since}{until}"),
    Cause.NO_WAY_ON.value: phrase("it waits for {party} to come to its section"),
    Cause.NOT_ITS_TURN.value: phrase("{party} goes first"),
    Cause.OVERLAP.value: phrase("{party} comes in first"),
    Cause.POINTS_MOVE.value: phrase("points {points} are being thrown"),
    Cause.POINTS_PROOF.value: phrase("points {points} are not proven"),
    Cause.POINTS_REFUSED.value: phrase("points {points} were refused"),
    Cause.REFUSED.value: phrase("the block manager has refused its route"),
    Cause.ANSWER.value: phrase("the block manager has not answered yet"),
    Cause.COVERAGE.value: phrase("the radio does not reach there"),
    Cause.SET_BACK.value: phrase("its crew has set back its route"),
}


def at_time(time_s: float) -> str:
    """A time of day as people write it: HH:MM where it is a whole minute, else HH:MM:SS."""
    text = clock(time_s)
    return text.removesuffix(":00")


def text_of(wait: Wait, names: Names | None = None) -> Phrase:
    """The wait in one sentence; `names` of stations by id, without which the ids stand in it."""
    return _SENTENCES[wait.cause].fill(**_parts(wait, names or {}))


def _parts(wait: Wait, names: Names) -> dict[str, object]:
    # Beside the cause in Japanese: within its sentence, or in brackets after it.
    apart = "" if wait.cause in (Cause.ROUTE_HELD, Cause.STOP_LIMIT) else "apart"
    since = phrase(" since {at}", apart)
    until = phrase(" until {at}", apart)
    if wait.cause is Cause.ANSWER:
        since = phrase(", asked at {at}")
    elif wait.cause is Cause.OUTSIDE:
        until = phrase(" at {at}")
    parts: dict[str, object] = {
        "unit": wait.unit,
        "train": wait.train or wait.unit,
        "place": _place(wait, names),
        "section": wait.section,
        "points": wait.points,
        "party": f"{wait.party_train} ({wait.party})" if wait.party_train else wait.party or MANAGER_ID,
        "since": NOTHING if wait.since_s is None else since.fill(at=at_time(wait.since_s)),
        "until": NOTHING if wait.until_s is None else until.fill(at=at_time(wait.until_s)),
        "until_at": "" if wait.until_s is None else at_time(wait.until_s),
        "asked": _ASKED[wait.asked],
        "reason": reason(wait.reason),
    }
    return parts | {"why": _why(wait, parts)}


def _place(wait: Wait, names: Names) -> Phrase:
    if wait.place in names:
        name = names[wait.place]
        return _AT.fill(place=Phrase(name.en, name.in_("ja").removesuffix(_STATION) + _STATION))
    if wait.place:
        return _AT.fill(place=wait.place)
    if wait.at_m is not None:
        where = phrase("km {km}", "place").fill(km=f"{wait.at_m / 1000.0:.3f}")
        return where if wait.cause is Cause.STOP_LIMIT else _AT.fill(place=where)
    return phrase("outside section {section}").fill(section=wait.section)


def _why(wait: Wait, parts: Mapping[str, object]) -> Phrase:
    """The clause that begins where the sentence could end."""
    if wait.reason in _REASONS:
        return _REASONS[wait.reason]
    limited = _LIMITED_BY.get(wait.reason)
    why = reason(wait.reason) if limited is None else limited.fill(**parts)
    return phrase(": {said}").fill(said=why) if why.en else NOTHING
