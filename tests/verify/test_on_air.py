"""A queue that loses its head is what the envelope's check makes of a multiset with copies, in any order."""

from dataclasses import dataclass, field
from itertools import permutations, product

import msgspec

from radio.envelope import Envelope, Peer, check

SENT = 3


@dataclass
class Receiver:
    """Takes telegrams as they come, by the real check or whatever comes."""

    checks: bool = True
    peer: Peer = field(default_factory=Peer)
    took: tuple[int, ...] = ()

    def hear(self, sequence: int) -> None:
        envelope = Envelope("u1", "", 1, 0, sequence, 0.0, None, 0, msgspec.Raw(b""))
        self.peer, reason = check(self.peer, envelope, 1, 0.0, 5.0)
        if reason is None or not self.checks:
            self.took = (*self.took, sequence)


def taken_from_the_air(*, checks: bool = True) -> set[tuple[int, ...]]:
    """What takes effect of three telegrams, each lost, once or twice on the air, in any order."""
    found: set[tuple[int, ...]] = set()
    for copies in product((0, 1, 2), repeat=SENT):
        on_air = [sequence for sequence, count in enumerate(copies) for _ in range(count)]
        for order in set(permutations(on_air)):
            receiver = Receiver(checks)
            for sequence in order:
                receiver.hear(sequence)
            found.add(receiver.took)
    return found


def taken_from_a_queue() -> set[tuple[int, ...]]:
    """What takes effect of a queue, the head of which is heard or lost."""
    return {
        tuple(sequence for sequence, heard in enumerate(fates) if heard)
        for fates in product((False, True), repeat=SENT)
    }


def test_the_same_takes_effect_in_the_same_order() -> None:
    assert taken_from_the_air() == taken_from_a_queue()


def test_without_the_check_it_would_not() -> None:
    assert taken_from_the_air(checks=False) > taken_from_a_queue()
