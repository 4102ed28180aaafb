"""Recounting a certificate: its start, every successor of every member, the rules, and the ranks, one state at a time.

It makes every step of every party anew and composes them by `verify.composition`; it shares nothing with the search.
What it shows: the set holds the start and all that follows from any member, no member breaks a rule, and from every
member an untroubled event leads to one of lower rank, down to a state in which all trains have finished.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

from verify.certificate import FORMAT, Certificate, sources_digest
from verify.composition import Composition, StateOfLine, TrainCell
from verify.explored_line import UnwishedFor
from verify.parties import ExploredParties, StepKind

ELSEWHERE: Final = "a step does not lead where it did"
_STATE_BYTES: Final = 8
_RANK_BYTES: Final = 2
LOOKS_EVERY: Final = 10_000  # states, after each of which who watches is told


@dataclass(frozen=True)
class Recounted:
    """`refused`: why the certificate does not hold, empty where it does; how much was looked at."""

    refused: str
    states: int = 0
    successors: int = 0
    finished: int = 0
    rank_max: int = 0


def recount(
    certificate: Certificate, watch: Callable[[int], None] = lambda _: None, sources: str | None = None
) -> Recounted:
    """Whether the certificate holds. `sources`: the digest of the steps that run; None: that of the files."""
    if certificate.format != FORMAT:
        return Recounted(f"format {certificate.format}; this checker knows {FORMAT}")
    if certificate.sources != (sources_digest() if sources is None else sources):
        return Recounted("the steps are not those it was made from: their sources have another digest")
    parties = ExploredParties(certificate.line)
    for index, (kind, *of) in enumerate(certificate.made):
        try:
            parties.make(StepKind(kind), *(_as_made(number) for number in of))
        except (
            IndexError,
            TypeError,
            ValueError,
        ):  # of a state or telegram that the steps before it did not lead to
            return Recounted(f"step {index}: {ELSEWHERE}")
        if len(parties.made) != index + 1:
            return Recounted(f"step {index} is named twice")
    if parties.digest() != certificate.locals:
        return Recounted(f"the local states have another digest: {ELSEWHERE}")
    return _Recount(certificate, Composition(parties)).all(watch)


def _as_made(of: Any) -> Any:  # noqa: ANN401 - numbers, and pairs of them
    return tuple(map(_as_made, cast("Sequence[Any]", of))) if isinstance(of, list | tuple) else of


class _Recount:
    def __init__(self, certificate: Certificate, composition: Composition) -> None:
        self._composition: Final = composition
        self._certificate: Final = certificate
        self._grounds: Final = [(parts, left) for parts, left in certificate.grounds]
        self._ground_index: Final = {ground: index for index, ground in enumerate(self._grounds)}
        self._cells: Final = [[TrainCell(*cell) for cell in cells] for cells in certificate.cells]
        self._cell_index: Final = [{cell: i for i, cell in enumerate(cells)} for cells in self._cells]
        self._ranks: Final = dict(self._members())

    def _members(self) -> Iterator[tuple[int, int]]:
        states, ranks = self._certificate.states, self._certificate.ranks
        for index in range(len(states) // _STATE_BYTES):
            key = int.from_bytes(states[index * _STATE_BYTES : (index + 1) * _STATE_BYTES])
            yield key, int.from_bytes(ranks[index * _RANK_BYTES : (index + 1) * _RANK_BYTES])

    def all(self, watch: Callable[[int], None]) -> Recounted:
        """Every member in turn."""
        if len(self._ranks) * _STATE_BYTES != len(self._certificate.states):
            return Recounted("a state is named twice")
        if self._key(self._composition.start()) not in self._ranks:
            return Recounted("the start is not in it")
        successors = finished = 0
        for count, (key, rank) in enumerate(self._ranks.items(), start=1):
            wrong, found, done = self._member(key, rank)
            successors, finished = successors + found, finished + done
            if wrong:
                return Recounted(f"state {key:016x} {wrong}", count, successors)
            if count % LOOKS_EVERY == 0:
                watch(count)
        return Recounted("", len(self._ranks), successors, finished, max(self._ranks.values()))

    def _member(self, key: int, rank: int) -> tuple[str, int, bool]:
        """What is wrong with a member, how many states follow from it, and whether all trains have finished in it."""
        state = self._state(key)
        if state is None:
            return "has parts that are not in the tables", 0, False
        if broken := self._composition.broken(state):
            return f"is not safe: {broken}", 0, False
        best, found, missing = self._look(state)
        done = self._composition.finished(state)
        if missing:
            return f"leads out of the set: {missing}", found, done
        lowered = done if rank == 0 else best < rank and not done
        return "" if lowered else f"has no event that leads to a rank below {rank}", found, done

    def _look(self, state: StateOfLine) -> tuple[int, int, str]:
        """The lowest rank that an untroubled event leads to, how many follow, and what leads out of the set."""
        best, count = 1 << 8 * _RANK_BYTES, 0
        for after in self._composition.following(state):
            count += 1
            rank = self._ranks.get(self._key(after.state))
            if rank is None:
                return best, count, f"{after.who} {after.what}"
            if after.trouble is UnwishedFor.NONE:
                best = min(best, rank)
        return best, count, ""

    def _key(self, state: StateOfLine) -> int:
        """A state as the certificate writes it; -1 where its parts are in no table."""
        ground = self._ground_index.get(((state.manager, *state.terminals), state.left))
        cells = [index.get(cell) for index, cell in zip(self._cell_index, state.cells, strict=True)]
        if ground is None or None in cells:
            return -1
        key = ground
        for bits, number in zip(self._certificate.bits[1:], cells, strict=True):
            key = key << bits | (number or 0)
        return key

    def _state(self, key: int) -> StateOfLine | None:
        rest, cells = key, list[TrainCell]()
        for bits, table in zip(reversed(self._certificate.bits[1:]), reversed(self._cells), strict=True):
            number, rest = rest & (1 << bits) - 1, rest >> bits
            if number >= len(table):
                return None
            cells.append(table[number])
        if rest >= len(self._grounds):
            return None
        (manager, *terminals), left = self._grounds[rest]
        return StateOfLine(manager, tuple(terminals), left, tuple(reversed(cells)))
