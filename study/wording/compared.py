"""What a comparison of runs says: figures, headings and sentences. English words are the keys of the figures."""

from __future__ import annotations

from typing import Final

from study.wording.catalogue import phrase, phrase_or_name
from study.wording.phrase import Phrase

NOT_LATE: Final = phrase("not late (within {most})")
AT_MOST: Final = phrase("at most {most} late")
HEADING: Final = phrase("{what}: old")
AT_STATION: Final = phrase("{train} at {place}")
LATER: Final = phrase("{by_s:.1f} s later")
EARLIER: Final = phrase("{by_s:.1f} s earlier")
DID_NOT_RUN: Final = phrase("{trains} did not run in the {which} run")
AND: Final = phrase(" and ")

CHANGED: Final = phrase("What changed against {label}")
DIFFERENCES: Final = phrase("{count} differences, the patches of both runs carried out.")
ONE_DIFFERENCE: Final = phrase("1 difference, the patches of both runs carried out.")
ROWS: Final = phrase("{count} rows")
# the verdict
NOTHING_AT_ALL: Final = phrase("Nothing differs at all, {inputs}: the journals of both runs are the same.")
SAME_INPUTS: Final = phrase("from the same inputs")
OTHER_INPUTS: Final = phrase("though the inputs differ")
ONLY_IN: Final = phrase("Only in {where}: {trains}.")
TRAINS: Final = phrase("trains {shown}")
ONE_TRAIN: Final = phrase("train {shown}")
MORE_TRAINS: Final = phrase("trains {shown} and {rest} more")
CAME_ONCE: Final = phrase("{count} of trains that run in both came in one run only.")
BROKEN_ONLY: Final = phrase("Broken only in {where}: {texts}.")
NONE_COMPARED: Final = phrase("No arrival and no departure came in both runs: there is nothing to compare.")
NOTHING_MOVED: Final = phrase("Nothing moved by more than {over}: {both} compared, {largest}.")
MOVED: Final = phrase(
    "{count} of {both} moved by more than {over}, {later} later and {earlier} earlier, of {trains}; {largest}."
)
BOTH: Final = phrase("{count} arrivals and departures")
LARGEST: Final = phrase("the largest difference is {largest_s:.1f} s")
SECONDS: Final = phrase("{over_s:g} s")
NO_MEET: Final = phrase("No meet moved.")
MEETS: Final = phrase("{count} changed: {each}.")
_SPANS: Final = (5, 15, 60, 180, 300)


def span(seconds: int) -> Phrase:
    """So many seconds, as people say it."""
    return (
        phrase("{count} s").of(count=seconds)
        if seconds < 60
        else phrase("{count} min").of(count=seconds // 60)
    )


_WITHIN: Final = {
    name.en: name
    for seconds in _SPANS
    for name in (NOT_LATE.of(most=span(seconds)), AT_MOST.of(most=span(seconds)))
}


def compared_name(text: str) -> Phrase:
    """A figure's name, unit or heading; ids and labels as they are."""
    return _WITHIN.get(text) or phrase_or_name(text)
