"""What a run came to in words: rules broken, dangers, what is missing, how it ended, what a drill's verdict says."""

from __future__ import annotations

from typing import Final

from simulation.events import Unsafe
from simulation.judge.checkers import Violation
from study.wording.catalogue import phrase, phrase_or_name
from study.wording.phrase import Phrase

MISSING: Final = phrase("{count} trains did not arrive: {trains}")
ONE_MISSING: Final = phrase("{count} train did not arrive: {trains}")
NOT_HOME: Final = phrase("{unit} has not left the line and does not stand where its last duty ends")
ON_ITS_WAY: Final = phrase("{train} ({unit}) was on its way in {place}")
STANDS: Final = phrase("{train} ({unit}) stands in {place} and waits for {what}")
DANGER: Final = phrase("{unit} {how}")
CUT_SHORT: Final = phrase("the run was cut short: {why}")
SLIPPERY: Final = phrase(
    "{unit} had less adhesion than the design counts on {times} from {since} to {until}, at least {least:.2f} of the"
    " dry rail's"
)
ONCE: Final = phrase("once")
TIMES: Final = phrase("{count} times")
THE_END: Final = phrase("the end")
RULE: Final = phrase("{checker}: {text}")
OUTSIDE: Final = phrase("{at} {what}")
ALL_ARRIVED: Final = phrase("all arrived")
OTHERS_ARRIVED: Final = phrase("all arrived but what was cancelled: {trains}")
NONE_BROKEN: Final = phrase("none broken")
OUTSIDE_DESIGN: Final = phrase("outside the design: {what}")
OUTSIDE_LINE: Final = phrase("Outside the design: {what}")
EXPECTED: Final = phrase("Expected: {what}")
# of an event, or of a stretch of time
DID_NOT: Final = phrase("did not happen")
HAPPENED: Final = phrase("happened at {at}")
AT: Final = phrase("at {at}")
NEVER: Final = phrase("never happened")
TOO_LATE: Final = phrase("happened at {at}, outside the time given")
NO_STRETCH: Final = phrase("'{what}' never happened")
NOT_FROM: Final = phrase("'{what}' did not happen after {at}")
BACKWARDS: Final = phrase("the time given ends at {at}, before it begins")
OFF_LINE: Final = phrase("was not on the line")
AT_MOST: Final = phrase("at most {kmh:.1f} km/h")
NOT_ENTERED: Final = phrase("did not enter")
ENTERED: Final = phrase("entered at {at}")
# of a fault, and of the scores
LASTS: Final = phrase("lasts")
AT_ONCE: Final = phrase("at once")
NO_TRAIN: Final = phrase("No train arrived.")
LATEST: Final = phrase("Latest {late_s:.0f} s after plan.")
NO_NORMAL: Final = phrase("No time back to normal, because {why}.")
NORMAL: Final = phrase(
    "Back to normal {normal_s:.0f} s after the last heal at {healed}: from then on every departure was within"
    " {tolerance_s:.0f} s of plan."
)
NOTHING_DISTURBED: Final = phrase("nothing was disturbed")
FAULT_LASTS: Final = phrase("a fault lasts to the end")
SOME_MISSING: Final = phrase("not every train arrived")
PASSED: Final = phrase("passed: {count} met")
FAILED: Final = phrase("NOT passed: {count} of {all} expectations not met")
MET: Final = phrase("met")
NOT_MET: Final = phrase("NOT MET")
VERDICT: Final = phrase("{met}: {text}: {happened}")
UNMET: Final = phrase("{text}: {happened}")


def violation_text(violation: Violation) -> Phrase:
    """A broken rule without its name's colon: in Japanese the rule itself and whom it is about."""
    return Phrase(violation.text, violation.subject or violation.text)


def rule_text(violation: Violation) -> Phrase:
    """A broken rule by its name, and how."""
    return RULE.fill(checker=checker_name(violation.checker), text=violation_text(violation))


def checker_name(checker: str) -> Phrase:
    """A checker, or what else is outside the design."""
    return phrase_or_name(checker, "rule")


def unsafe_text(event: Unsafe) -> Phrase:
    """What happened to a train that must never happen, without whose it is."""
    return phrase(event.danger.value, "danger").fill(points=event.points_id)


def ending_text(ending: str) -> Phrase:
    """Why a run ended."""
    return phrase_or_name(ending, "ending")
