"""What people know when they put a party into service again (再使用開始) whose durable state is lost.

Their own record of how often each was commissioned, so that its next boots count beyond all before; and for a point
terminal, from the block manager's screen, the last token under which each of its sections was given away, so that it
takes no command under an older one, and to whom, who may rely on its points as they lay.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from simulation.events import JournalEntry
from wayside.point_terminal import Commitment, TerminalMemory
from wayside.said import Accepted, ConfirmedByHand, Freed, Granted


class _Given(NamedTuple):
    unit_id: str
    token: int
    taken: bool = False  # by persons' word: its unit may yet come back and believe that it holds it


class ServiceRecord:
    """The record of one run; `points` has the section of each, by terminal."""

    def __init__(self, points: Mapping[str, Mapping[str, str]]) -> None:
        self._points = points
        self._again: Counter[str] = Counter()
        self._given: dict[str, _Given] = {}

    def see(self, entry: JournalEntry) -> None:
        """What the block manager's screen shows of grants."""
        match entry.event:
            case Granted(unit_id=unit_id, section_ids=section_ids, token=token):
                self._given |= dict.fromkeys(section_ids, _Given(unit_id, token))
            case (
                Accepted(unit_id=unit_id, section_ids=section_ids, token=token)
                | ConfirmedByHand(unit_id=unit_id, section_ids=section_ids, token=token)
            ):
                # Who had them before goes on under the token that it knows.
                others = [s for s in section_ids if self._last(s)[::2] != (unit_id, False)]
                self._given |= dict.fromkeys(others, _Given(unit_id, token))
            case Freed(section_ids=section_ids, by=by):
                for section_id in section_ids:
                    last = self._last(section_id)
                    self._given[section_id] = last._replace(taken=True) if by else _Given("", last.token)
            case _:
                pass

    def number(self, party_id: str) -> int:
        """How often the party has been commissioned, with this time."""
        self._again[party_id] += 1
        return 1 + self._again[party_id]

    def vital(self, party_id: str) -> bytes:
        """What the party must remember from now on: a terminal, below which token it takes no command, and who may rely
        on its points.
        """
        if party_id not in self._points:
            return b""
        given = {p: (s, self._given[s]) for p, s in self._points[party_id].items() if s in self._given}
        tokens = {section_id: last.token + last.taken for section_id, last in given.values()}
        relied_on = {
            p: Commitment(last.unit_id, None, last.token) for p, (_, last) in given.items() if last.unit_id
        }
        return msgspec.msgpack.encode(TerminalMemory(tokens, relied_on))

    def _last(self, section_id: str) -> _Given:
        return self._given.get(section_id, _Given("", 0))
