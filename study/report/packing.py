"""Numbers and text as the page carries them: whole numbers as differences, JSON, deflated, in base64.

`web/data.js` reads what is written here; both say the same things in the same order.
"""

from __future__ import annotations

import json
import math
import zlib
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Packed = dict[str, Any]


def packed_column(values: Iterable[float | None], per_unit: int) -> Packed:
    """A column: each value in `per_unit`ths of its unit, less the one before it; null where there is none.

    What comes back is within half a `per_unit`th of the value. What is not finite counts as none.
    """
    found: list[int | None] = []
    last = 0
    for value in values:
        if value is None or not math.isfinite(value):
            found.append(None)
            continue
        whole = round(value * per_unit)
        found.append(whole - last)
        last = whole
    return {"k": per_unit, "d": found}


def unpacked(column: Packed) -> list[float | None]:
    """What `packed` was given, to its precision."""
    found: list[float | None] = []
    last = 0
    for step in column["d"]:
        if step is None:
            found.append(None)
            continue
        last += step
        found.append(last / column["k"])
    return found


def places_in(values: Sequence[str | None]) -> tuple[list[str], list[int | None]]:
    """Distinct texts in order of appearance, and for each value its place among them."""
    order: dict[str, int] = {}
    places = [None if value is None else order.setdefault(value, len(order)) for value in values]
    return list(order), places


def deflated(payload: Mapping[str, Any]) -> str:
    """The payload as text for the page. The same payload gives the same text."""
    text = json.dumps(payload, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")
