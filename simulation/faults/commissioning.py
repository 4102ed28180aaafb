"""What people know when they put a party into service again (再使用開始) whose durable state is lost.

Their own record of how often each was commissioned, so that its next boots count beyond all before; and for a point
terminal, from the block manager's screen, the last token under which each of its sections was given away, so that it
takes no command under an older one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import msgspec

from simulation.events import JournalEntry
from wayside.point_terminal import TerminalMemory
from wayside.said import Accepted, ConfirmedByHand, Freed, Granted


class _Given(NamedTuple):
    unit_id: str
    token: int


class ServiceRecord:
    """The record of one run; `sections` has those with points, by terminal."""

    def __init__(self, sections: Mapping[str, tuple[str, ...]]) -> None:
        self._sections = sections
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
                others = [s for s in section_ids if self._given.get(s, _Given("", 0)).unit_id != unit_id]
                self._given |= dict.fromkeys(others, _Given(unit_id, token))
            case Freed(section_ids=section_ids, by=str(by)) if by:
                for section_id in section_ids:  # its unit may yet come back and believe that it holds them
                    last = self._given.get(section_id, _Given("", 0)).token
                    self._given[section_id] = _Given("", last + 1)
            case _:
                pass

    def number(self, party_id: str) -> int:
        """How often the party has been commissioned, with this time."""
        self._again[party_id] += 1
        return 1 + self._again[party_id]

    def vital(self, party_id: str) -> bytes:
        """What the party must remember from now on: a terminal, below which token it takes no command."""
        sections = self._sections.get(party_id)
        if sections is None:
            return b""
        tokens = {s: self._given[s].token for s in sections if s in self._given}
        return msgspec.msgpack.encode(TerminalMemory(tokens, {}))
