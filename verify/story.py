"""The shortest way to a state, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from itertools import groupby, pairwise
from types import MappingProxyType
from typing import Final, cast

import numpy as np

from radio.messages import AnyMessage
from verify.composition import HEARS, Composition, Following, StateOfLine, TrainCell
from verify.expansion import Expansion
from verify.explored_line import TERMINALS
from verify.parties import ExploredParties
from verify.search import Keys, way_to
from wayside.config import MANAGER_ID

_UNSAID: Final = ("token", "capabilities", "mac", "unit_id", "terminal_id")
WORDS: Final = MappingProxyType(
    {
        "Begin": "has its train number entered",
        "SwitchedOn": "has its train number entered after the boot",
        "ChangeEnds": "has its driver change ends and enter the next train number",
        "Leave": "is to leave the line",
        "OffTheLine": "is told that its train has left",
        "WheelsTurning": "moves off",
        "Looked": "runs on by a third of a section",
        "Stopped": "stops",
        "TagBelieved": "reads a tag",
        "AtMark": "is told by its driver that it stands at its mark",
        "NotAtMark": "is told by its driver that it does not stand at its mark",
        "PointsSeen": "has its crew see that points lie as needed, and lock them by hand",
        "PointsWrong": "has its crew see that points do not lie as needed",
        "EndOfHeld": "is told where it stands, at the end of what it holds",
        "PositionLost": "loses its position",
        "SetBack": "has its crew set its route back",
    }
)


class StoryTeller:
    """Tells how the search came to a state."""

    def __init__(self, parties: ExploredParties, expansion: Expansion) -> None:
        self.composition: Final = Composition(parties)
        self._expansion: Final = expansion

    def line_state(self, key: int) -> StateOfLine:
        """A state of the search as the composition has it."""
        columns = self._expansion.columns(np.array([key], np.uint64))
        cells = tuple(
            TrainCell(*self._expansion.cells[unit].keys.things[int(numbers[0])])
            for unit, numbers in enumerate(columns.cells)
        )
        left = self._expansion.lefts.things[int(columns.left[0])]
        terminals = tuple(int(numbers[0]) for numbers in columns.terminals)
        return StateOfLine(int(columns.manager[0]), terminals, left, cells)

    def events(self, levels: Sequence[Keys], key: int) -> tuple[Following, ...]:
        """What happens on a shortest way to a state."""
        way = [self.line_state(k) for k in way_to(self._expansion, levels, key)]
        return tuple(
            next(f for f in self.composition.following(before) if f.state == after)
            for before, after in pairwise(way)
        )

    def story(self, events: Iterable[Following]) -> tuple[str, ...]:
        """Events in words, a line for each, or for the same ones after each other."""
        return tuple(
            f"{line} ({count} times)" if count > 1 else line
            for line, count in _runs(map(self._words, events))
        )

    def chart(self, events: Iterable[Following]) -> str:
        """The same as a sequence chart, in Mermaid: an arrow for what is heard, a crossed one for what is lost."""
        lines = [
            "sequenceDiagram",
            *(
                f"    participant {party}"
                for party in (*self.composition.parties.units, MANAGER_ID, *TERMINALS)
            ),
        ]
        for words, same in groupby(events, self._arrow):
            count = len(list(same))
            lines.append(f"    {words} ({count} times)" if count > 1 else f"    {words}")
        return "\n".join(lines) + "\n"

    def _arrow(self, found: Following) -> str:
        who = MANAGER_ID if found.who == "manager" else found.who
        if found.telegram < 0:
            return f"Note over {who}: {WORDS.get(found.what, found.what)}"
        said = telegram_words(self.composition.parties.telegrams.things[found.telegram].message)
        return f"{found.other}->>{who}: {said}" if found.what == HEARS else f"{who}-x{found.other}: {said}"

    def _words(self, found: Following) -> str:
        if found.telegram < 0:
            return f"{found.who} {WORDS.get(found.what, found.what)}"
        message = self.composition.parties.telegrams.things[found.telegram].message
        return f"{found.who} {found.what} {telegram_words(message)}"


def telegram_words(message: AnyMessage) -> str:
    """A telegram by its name and what it says, without numbers and codes."""
    fields = {name: getattr(message, name) for name in message.__struct_fields__ if name not in _UNSAID}
    said = [_field_words(value) for value in fields.values() if value not in ((), None)]
    unknown = ["does not know"] if fields.get("section_ids", ()) is None else []
    return " ".join((type(message).__name__, *unknown, *said))


def _field_words(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(str, cast("tuple[object, ...]", value)))
    return value.name.lower().replace("_", " ") if isinstance(value, Enum) else str(value)


def _runs(lines: Iterable[str]) -> Iterator[tuple[str, int]]:
    return ((line, len(list(same))) for line, same in groupby(lines))
