"""How long trains have their resources, and which questions of order between two trains are one.

An *occupation* is all that a train does in one go with a resource: operations that follow one another. Two trains have
a question of order for each resource that both may occupy. Where both go from one resource to the next without letting
go of the first before they have the second, in the same or the opposite direction, who is first on one is first on the
other: else one would have to pass through the other, or both let go of what the other takes in the same instant, which
no order of events allows. So one answer serves along a whole single track, and a line of many sections has few
questions.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

from plan.dispatching.instance import Train, predecessors


@dataclass(frozen=True)
class ResourceOccupation:
    """Operations (indices, in order) over which a train has a resource in one go; `certain`: whatever path it takes."""

    train: int
    resource: str
    operations: tuple[int, ...]
    certain: bool


@dataclass(frozen=True)
class Pair:
    """Two trains' occupations of one resource; `question` is the same for pairs that have one answer."""

    first: ResourceOccupation
    second: ResourceOccupation
    question: int


@dataclass(frozen=True)
class Alike:
    """Two pairs that have one answer where all four occupations take place."""

    one: Pair
    other: Pair


def certain_operations(train: Train) -> frozenset[int]:
    """Operations that are on every path from the entry to the exit."""
    to_here, from_here = [0] * len(train), [0] * len(train)
    to_here[0] = from_here[-1] = 1
    for i, operation in enumerate(train):
        for successor in operation.successors:
            to_here[successor] += to_here[i]
    for i in range(len(train) - 2, -1, -1):
        from_here[i] = sum(from_here[successor] for successor in train[i].successors)
    return frozenset(i for i in range(len(train)) if to_here[i] * from_here[i] == to_here[-1])


def occupations_of(number: int, train: Train) -> Iterator[ResourceOccupation]:
    """A train's occupations, resource by resource in the order in which they come."""
    certain = certain_operations(train)
    using: dict[str, list[int]] = {}
    for i, operation in enumerate(train):
        for use in operation.resources:
            using.setdefault(use.resource, []).append(i)
    for resource, operations in using.items():
        for group in _in_one_go(train, operations):
            yield ResourceOccupation(number, resource, group, any(i in certain for i in group))


def _in_one_go(train: Train, operations: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Operations of one resource that follow one another; each alone where a path leaves them and comes back."""
    group_of = {i: i for i in operations}
    for i in operations:
        for successor in train[i].successors:
            if successor in group_of:
                old, new = group_of[successor], group_of[i]
                group_of.update({k: new for k, group in group_of.items() if group == old})
    groups: dict[int, list[int]] = defaultdict(list)
    for i in operations:
        groups[group_of[i]].append(i)
    for group in groups.values():
        if _comes_back(train, frozenset(group)):
            yield from ((i,) for i in group)
        else:
            yield tuple(group)


def _comes_back(train: Train, group: frozenset[int]) -> bool:
    """Whether a path leaves the group and enters it again."""
    left: set[int] = set()
    for i in range(min(group), max(group) + 1):
        if i in left and i in group:
            return True
        if i in left or i in group:
            left.update(successor for successor in train[i].successors if i in left or successor not in group)
    return False


def questions_of(
    trains: Sequence[Train], occupations: Sequence[Sequence[ResourceOccupation]]
) -> tuple[list[Pair], list[Alike]]:
    """All pairs, those that always have one answer with one question, and which others are alike."""
    pairs: list[Pair] = []
    alike: list[Alike] = []
    goes_on = [_goes_on(train, own) for train, own in zip(trains, occupations, strict=True)]
    for a, b in combinations(range(len(trains)), 2):
        between = _pairs_between(occupations[a], occupations[b], len(pairs))
        joined = [
            (one, (then_a, beside_b))
            for one in between
            for then_a in goes_on[a].then[one[0]]
            for beside_b in (*goes_on[b].then[one[1]], *goes_on[b].before[one[1]])
            if (then_a, beside_b) in between
        ]
        asked = _asked_once(between, joined)
        made = {key: Pair(key[0], key[1], question) for key, question in asked.items()}
        pairs += made.values()
        alike += [Alike(made[one], made[other]) for one, other in joined if asked[one] != asked[other]]
    return pairs, alike


_Both = tuple[ResourceOccupation, ResourceOccupation]


def _pairs_between(
    ones: Sequence[ResourceOccupation], others: Sequence[ResourceOccupation], begin: int
) -> dict[_Both, int]:
    """Pairs of two trains with a number of their own each."""
    by_resource: dict[str, list[ResourceOccupation]] = defaultdict(list)
    for other in others:
        by_resource[other.resource].append(other)
    both = ((one, other) for one in ones for other in by_resource[one.resource])
    return {pair: begin + i for i, pair in enumerate(both)}


def _asked_once(between: Mapping[_Both, int], joined: Sequence[tuple[_Both, _Both]]) -> dict[_Both, int]:
    """The question of each pair: one for what is joined and certain, and an uncertain one asks its neighbour's."""
    asked = dict(between)

    def certain(pair: _Both) -> bool:
        return pair[0].certain and pair[1].certain

    for one, other in joined:
        if certain(one) and certain(other):
            old, new = asked[other], asked[one]
            asked.update({pair: new for pair, question in asked.items() if question == old})
    lent: set[_Both] = set()
    for one, other in joined:
        for asker, neighbour in ((one, other), (other, one)):
            if certain(neighbour) and not certain(asker) and asker not in lent:
                asked[asker] = asked[neighbour]
                lent.add(asker)
    return asked


@dataclass(frozen=True)
class _Succession:
    """Occupations that a train begins no later than it ends another whenever it has both, and the same backwards."""

    then: defaultdict[ResourceOccupation, list[ResourceOccupation]]
    before: defaultdict[ResourceOccupation, list[ResourceOccupation]]


def _goes_on(train: Train, own: Sequence[ResourceOccupation]) -> _Succession:
    entered = predecessors(train)
    chain = _Succession(defaultdict(list), defaultdict(list))
    for one, other in product(own, own):
        if one.resource == other.resource or other.operations[0] < one.operations[0]:
            continue
        these, those = set(one.operations), set(other.operations)
        leaves = {successor for i in these for successor in train[i].successors} - these
        comes = {before for i in those for before in entered[i]} - those
        if (leaves and leaves <= those) or (comes and comes <= these):
            chain.then[one].append(other)
            chain.before[other].append(one)
    return chain
