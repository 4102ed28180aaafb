"""The second opinion on energy: what is compared, whose figures they are, what is comparable, what it means."""

from __future__ import annotations

from typing import Final

from study.wording.catalogue import phrase, phrases_of
from study.wording.forms import found
from study.wording.phrase import Phrase

MORE: Final = phrase("more")
LESS: Final = phrase("less")
TRACTION: Final = phrase(
    "With the train file's resistance the day takes {kwh:,.0f} kWh ({percent:.1f} %) {more} traction than with the"
    " other formula: the day's traction is known no better than that."
)
WITHIN: Final = phrase(
    "{ours:.2f} kWh per train-km lies within the bound of {theirs:.2f}; a bound shows no more than that."
)
ABOVE_BOUND: Final = phrase(
    "{ours:.2f} kWh per train-km lies ABOVE the bound of {theirs:.2f}: something is wrong here."
)
BELOW: Final = phrase("below")
ABOVE: Final = phrase("above")
PER_CAR: Final = phrase(
    "Per car-km we lie {percent:.0f} % {which} {figure}: the order of magnitude agrees; with other trains, spe"
    "eds, loads"
    " and losses more cannot be said."
)
NONE: Final = phrase("No public figure stands beside a day on which not every train arrived.")


def opinion(text: str) -> Phrase:
    """A text of the table of opinions in both languages."""
    return found(phrases_of("opinion").values(), text, Phrase) or Phrase(text)
