"""How far from its mark a train may stand: what counts as a call there, and what is told."""

from __future__ import annotations

from typing import Final

CALLS_SHORT_M: Final = 6.0  # stood this far before the mark, a train calls there all the same
CALLS_BEYOND_M: Final = 40.0  # and this far beyond it, or on its track: no train sets back
# Further short of it a train calls that stands alongside its platform, with its whole length.
OFF_MARK_M: Final = 0.35  # a stop farther from its mark than this is told: doors no longer meet their places
