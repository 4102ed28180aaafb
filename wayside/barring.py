"""Invariant: what a barred unit says counts for nothing, in whatever boot and by whatever key; two different persons
bar it, two unbar it, and no restart forgets that.

For a unit that is mad, or whose key is stolen. What it held stays its own until people say where it is: barring frees
nothing. Block manager and point terminals each keep the bars that persons entered there, for the manager tells a
terminal nothing (table 2 of Sugiyama et al. 2017).
"""

from __future__ import annotations

import msgspec

from network.errors import InputError


class Bars(msgspec.Struct, frozen=True, array_like=True):
    """The barred units, and (unit, person) where one person alone has said that this must change. Durable."""

    barred: tuple[str, ...] = ()
    words: tuple[tuple[str, str], ...] = ()


NO_BARS = Bars()


def person_key(name: str) -> str:
    """Who it is, so that one person spelled in two ways is not two."""
    return " ".join(name.split()).casefold()


def bars_after_word(bars: Bars, unit_id: str, name: str, *, bar: bool) -> Bars:
    """After a person's word that the unit is to be barred, or not; what is so already takes their other word back."""
    word = unit_id, person_key(name)
    rest = tuple(other for other in bars.words if other != word)
    if (unit_id in bars.barred) is bar:
        return Bars(bars.barred, rest)
    if all(other != unit_id for other, _ in rest):
        return Bars(bars.barred, (*rest, word))
    barred = {*bars.barred, unit_id} if bar else {other for other in bars.barred if other != unit_id}
    return Bars(tuple(sorted(barred)), tuple(other for other in rest if other[0] != unit_id))


def bars_kept(kept: bytes) -> Bars:
    """What a device kept; nothing of one that never ran. InputError if it is damaged: it may have forgotten a bar."""
    try:
        return msgspec.msgpack.decode(kept, type=Bars) if kept else NO_BARS
    except msgspec.MsgspecError as error:
        raise InputError("durable", "bars", f"{len(kept)} bytes", f"barred units ({error})") from None
