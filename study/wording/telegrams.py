"""What telegrams are called (電文)."""

from __future__ import annotations

from study.wording.catalogue import phrase_or_name
from study.wording.phrase import Phrase


def telegram(kind: str) -> Phrase:
    """A kind of telegram in words."""
    return phrase_or_name(kind, "telegram")
