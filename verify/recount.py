"""Recounting a certificate: its start, every successor of every member, the rules, and the ranks.

It makes every step of every party anew and composes them in a way of its own, by halves: what can come of the ground
and one train is made once for each such pair and joined with all the states that have it. It shares the parties' models
and what counts as one state with the search (`verify.parties` and what that imports), and nothing of how they are
composed, searched or judged.

What it shows: the set holds the start and all that follows from any member, no member breaks a rule, and from every
member an untroubled event leads to one of lower rank, down to where all trains have left and the line is free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from verify.certificate import FORMAT, Certificate, sources_digest
from verify.explored_line import UnwishedFor
from verify.halves import HELD_UNKNOWN, Halves
from verify.parties import ExploredParties, StepKind

Numbers = NDArray[np.int64]
ELSEWHERE: Final = "a step does not lead where it did"
NO_ROOM: Final = "two states may have one number: their parts have no room in it"
NOT_IN_TABLES: Final = "a state has parts that are not in the tables"
AT_ONCE: Final = 500_000
_RANK_MAX: Final = 1 << 16
_STATE_BITS: Final = 64


@dataclass(frozen=True)
class Recounted:
    """`refused`: why the certificate does not hold, empty where it does; how much was looked at."""

    refused: str
    states: int = 0
    successors: int = 0
    finished: int = 0
    rank_max: int = 0


def recount(
    certificate: Certificate,
    watch: Callable[[int], None] = lambda _: None,
    sources: str | None = None,
    processes: int = 1,
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
        except (IndexError, TypeError, ValueError):  # of what the steps before it did not lead to
            return Recounted(f"step {index}: {ELSEWHERE}")
        if len(parties.made) != index + 1:
            return Recounted(f"step {index} is named twice")
    if parties.digest() != certificate.locals:
        return Recounted(f"the local states have another digest: {ELSEWHERE}")
    return _summed(_Recount(certificate, parties), watch, processes)


def _as_made(of: Any) -> Any:  # noqa: ANN401 - numbers, and pairs of them
    return tuple(map(_as_made, cast("Sequence[Any]", of))) if isinstance(of, list | tuple) else of


_AT_HAND: list[_Recount] = []  # what forked processes work on


def _part(first: int) -> Recounted:
    return _AT_HAND[-1].members(first)


def _summed(check: _Recount, watch: Callable[[int], None], processes: int) -> Recounted:
    if check.refused:
        return Recounted(check.refused)
    firsts = range(0, len(check.states), AT_ONCE)
    if processes == 1:
        return _sum_of(map(check.members, firsts), watch)
    _AT_HAND.append(check)
    with get_context("fork").Pool(processes) as pool:
        found = _sum_of(pool.imap_unordered(_part, firsts), watch)
    _AT_HAND.pop()
    return found


def _sum_of(parts: Iterable[Recounted], watch: Callable[[int], None]) -> Recounted:
    states = successors = finished = rank_max = 0
    for part in parts:
        states, successors = states + part.states, successors + part.successors
        finished, rank_max = finished + part.finished, max(rank_max, part.rank_max)
        watch(states)
        if part.refused:
            return Recounted(part.refused, states, successors, finished, rank_max)
    return Recounted("", states, successors, finished, rank_max)


class _Recount:
    """One certificate at hand."""

    def __init__(self, certificate: Certificate, parties: ExploredParties) -> None:
        self._halves: Final = Halves(parties, certificate.grounds, certificate.cells)
        self._bits: Final = certificate.bits
        self.states: Final = np.frombuffer(certificate.states, ">u8").astype(np.uint64)
        self._ranks: Final = np.frombuffer(certificate.ranks, ">u2").astype(np.int64)
        self.refused: Final = self._at_once()

    def _at_once(self) -> str:
        """What is wrong before any member is looked at."""
        named = self._halves.grounds_named, *self._halves.cells_named
        if sum(self._bits) > _STATE_BITS or any(
            count > 1 << bits for bits, count in zip(self._bits, named, strict=True)
        ):
            return NO_ROOM
        if len(self._ranks) != len(self.states):
            return "not every state has a rank"
        if np.any(self.states[1:] <= self.states[:-1]):
            return "the states are not in order, or one is named twice"
        ground, cells = self._parts(self.states)
        sizes = len(self._halves.grounds), *map(len, self._halves.cells)
        parts = zip((ground, *cells), sizes, strict=True)
        if any(len(n) and not 0 <= int(n.min()) <= int(n.max()) < size for n, size in parts):
            return NOT_IN_TABLES
        start = self._key(*self._halves.start())
        return "" if self._among(start)[1].all() else "the start is not in it"

    def _parts(self, keys: NDArray[np.uint64]) -> tuple[Numbers, list[Numbers]]:
        rest, cells = keys.astype(np.int64), list[Numbers]()
        for bits in reversed(self._bits[1:]):
            cells.append(rest & (1 << bits) - 1)
            rest = rest >> bits
        return rest, cells[::-1]

    def _key(self, ground: Numbers, cells: Sequence[Numbers]) -> NDArray[np.uint64]:
        """States as the certificate writes them; the greatest number where a part is in none of its tables."""
        known = ground < self._halves.grounds_named
        key = ground
        for bits, numbers, named in zip(self._bits[1:], cells, self._halves.cells_named, strict=True):
            known = known & (numbers < named)
            key = key << bits | numbers
        return np.where(known, key, -1).astype(np.uint64)

    def _among(self, keys: NDArray[np.uint64]) -> tuple[Numbers, NDArray[np.bool_]]:
        at = np.minimum(np.searchsorted(self.states, keys), max(len(self.states) - 1, 0))
        return at, self.states[at] == keys if len(self.states) else np.zeros(len(keys), bool)

    def members(self, first: int) -> Recounted:
        """Some members: from `first` on."""
        keys, rank = self.states[first : first + AT_ONCE], self._ranks[first : first + AT_ONCE]
        ground, cells = self._parts(keys)
        for rule, breaks in self._broken(ground, cells):
            if breaks.any():
                return self._refused(keys, breaks, f"is not safe: {rule}")
        line = self._halves.of_grounds.column
        finished: NDArray[np.bool_] = np.logical_and.reduce(
            [
                line("defined")[ground] != 0,
                *(line(f"holds{unit}")[ground] == 0 for unit in range(len(cells))),
                *(f.column("finished")[c] != 0 for f, c in zip(self._halves.of_cells, cells, strict=True)),
            ]
        )
        best, count = np.full(len(keys), _RANK_MAX), 0
        for source, after_ground, after_cells, trouble in self._halves.following(ground, cells):
            at, there = self._among(self._key(after_ground, after_cells))
            if not there.all():
                out = np.zeros(len(keys), bool)
                out[source[~there]] = True
                return self._refused(keys, out, "leads out of the set")
            good = trouble == UnwishedFor.NONE
            np.minimum.at(best, source[good], self._ranks[at[good]])
            count += len(source)
        lowered = (rank == 0) & finished | (rank > 0) & (best < rank) & ~finished
        if not lowered.all():
            return self._refused(
                keys, ~lowered, f"has no event that leads to a rank below {rank[~lowered][0]}"
            )
        return Recounted("", len(keys), count, int(finished.sum()), int(rank.max()))

    def _refused(self, keys: NDArray[np.uint64], which: NDArray[np.bool_], why: str) -> Recounted:
        return Recounted(f"state {int(keys[which][0]):016x} {why}", len(keys))

    def _broken(self, ground: Numbers, cells: Sequence[Numbers]) -> Iterator[tuple[str, NDArray[np.bool_]]]:
        """The rules, and by which members each is broken."""
        of_ground, of_cells = self._halves.of_grounds, self._halves.of_cells
        stands = [facts.column("stands")[c] for facts, c in zip(of_cells, cells, strict=True)]
        held = [facts.column("held")[c] for facts, c in zip(of_cells, cells, strict=True)]
        known = [np.where(h == HELD_UNKNOWN, 0, h) for h in held]
        free = of_ground.column("defined")[ground] != 0
        on_sight = of_ground.column("on_sight")[ground]
        pairs = [(one, other) for one in range(len(cells)) for other in range(one)]
        for one, other in pairs:
            yield "two trains in one section", stands[one] & stands[other] != 0
            yield "two units hold one section", known[one] & known[other] != 0
        for unit, facts in enumerate(of_cells):
            yield (
                "a train stands in what its unit does not hold",
                (held[unit] != HELD_UNKNOWN) & (stands[unit] & ~held[unit] != 0),
            )
            mine = of_ground.column(f"holds{unit}")[ground]
            yield (
                "free in a defined register, and a train stands in it",
                free & (stands[unit] & ~mine & ~on_sight != 0),
            )
            for index in range(len(self._halves.parties.terminals)):
                need = facts.column(f"needs{index}")[cells[unit]]
                lies = of_ground.column(f"lies{index}")[ground]
                yield (
                    "points do not lie, or are not locked, as the train on them needs",
                    (need != 0) & (need != lies),
                )
        yield "granted while the line was not defined", of_ground.column("bad")[ground] != 0
