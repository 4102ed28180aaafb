"""Somebody else on the air of a run: whatever he sends must take no effect, and each telegram of it must be counted.

After EN 50159 he repeats, holds back, reorders, damages and inserts telegrams, and speaks as somebody else: without any
key, and with all keys of another party. He is heard wherever a telegram is delivered, right after it. No effect is:
the journal is that of the run without him, line by line, but for the telegrams that were dropped. What he takes off
the air is not among it (deletion: a telegram that is lost has an effect, which is looked at by chaos and exploration).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from enum import Enum
from types import MappingProxyType
from typing import Final, NamedTuple

import msgspec
import numpy as np

from host.local import LocalParties
from host.parties import Parties
from host.party import Advance
from radio.chance import generator
from radio.envelope import AGE_MAX_S, DropReason, Envelope, encode, header_of
from radio.keys import KEY_BYTES, KeyRing
from radio.messages import AnyMessage, HoldingReport, PointsProof
from radio.noted import TelegramDropped
from scenario.scenario import Scenario
from simulation.journal import encode_entry
from simulation.result import RunResult
from study.runner.run import CarrierKind, UnitsAt
from verify.evidence.watched import PartyState, WatchedParties, result_of
from wayside.config import MANAGER_ID

STRANGER: Final = "stranger"
HEARD_MAX: Final = 400  # telegrams that the intruder remembers of each receiver


class Attack(Enum):
    """What the intruder does."""

    REPETITION = "repetition"
    RESEQUENCING = "re-sequencing"
    DELAY = "delay"
    CORRUPTION = "corruption"
    INSERTION = "insertion"
    MISDIRECTION = "insertion of what was meant for another"
    MASQUERADE = "masquerade without keys"
    MASQUERADE_WITH_KEYS = "masquerade with the keys of another"


class _Overheard(NamedTuple):
    """A telegram that was delivered."""

    at_s: float
    data: bytes


class _Place(NamedTuple):
    """Where the intruder speaks: to whom, when, what was delivered there and elsewhere, and the keys that he has."""

    receiver: str
    now_s: float
    here: Sequence[_Overheard]
    elsewhere: Sequence[_Overheard]
    keys: KeyRing | None
    chance: np.random.Generator


def _one(place: _Place, telegrams: Sequence[_Overheard]) -> bytes | None:
    return telegrams[int(place.chance.integers(len(telegrams)))].data if telegrams else None


def _again(place: _Place) -> bytes | None:
    return place.here[-1].data if place.here else None


def _earlier(place: _Place) -> bytes | None:
    return _one(place, [one for one in place.here[:-1] if place.now_s - one.at_s < AGE_MAX_S / 2])


def _held_back(place: _Place) -> bytes | None:
    return _one(place, [one for one in place.here if place.now_s - one.at_s > AGE_MAX_S])


def _damaged(place: _Place) -> bytes | None:
    data = bytearray(_again(place) or b"")
    if not data:
        return None
    bit = int(place.chance.integers(8 * len(data)))
    data[bit // 8] ^= 1 << bit % 8
    return bytes(data)


def _inserted(place: _Place) -> bytes | None:
    return _sealed(place, STRANGER, place.chance.bytes(KEY_BYTES))


def _for_another(place: _Place) -> bytes | None:
    return _one(place, place.elsewhere)


def _as_another(place: _Place) -> bytes | None:
    source = _source(place)
    return None if source is None else _sealed(place, source, place.chance.bytes(KEY_BYTES))


def _as_another_with_keys(place: _Place) -> bytes | None:
    source, keys = _source(place), place.keys
    if source is None or keys is None or keys.owner == source or place.receiver not in keys.pairs:
        return None
    return _sealed(place, source, keys.pairs[place.receiver])


def _source(place: _Place) -> str | None:
    header = header_of(place.here[-1].data) if place.here else None
    return None if header is None else header.source


def _sealed(place: _Place, source: str, key: bytes) -> bytes:
    """What would do harm if it were believed: that a unit holds nothing, or that points lie otherwise."""
    message: AnyMessage = HoldingReport((), 1 << 62)
    if place.receiver != MANAGER_ID:
        message = PointsProof("P", None, True, True, 1 << 62)
    payload = msgspec.Raw(msgspec.msgpack.encode(message))
    header = Envelope(source, place.receiver, 1, 0, 1 << 30, place.now_s, None, 0, payload)
    return encode(key, header)


ATTACKS: Final[MappingProxyType[Attack, Callable[[_Place], bytes | None]]] = MappingProxyType(
    {
        Attack.REPETITION: _again,
        Attack.RESEQUENCING: _earlier,
        Attack.DELAY: _held_back,
        Attack.CORRUPTION: _damaged,
        Attack.INSERTION: _inserted,
        Attack.MISDIRECTION: _for_another,
        Attack.MASQUERADE: _as_another,
        Attack.MASQUERADE_WITH_KEYS: _as_another_with_keys,
    }
)


class IntrudedParties(WatchedParties):
    """Parties of a run among whose telegrams are those of an intruder."""

    def __init__(self, parties: Parties, attack: Attack, seed: int, sent: Counter[str]) -> None:
        super().__init__(parties, _look_away)
        assert isinstance(parties, LocalParties)
        self._specs: Final = parties.specs
        self._attack: Final = attack
        self._sent: Final = sent
        self._chance: Final = generator(seed, "intruder", attack.value)
        self._heard: Final[dict[str, list[_Overheard]]] = {}

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s` on its telegrams, and on one of the intruder after each."""
        given, heard = list[bytes](), self._heard.setdefault(party_id, [])
        for data in telegrams:
            given.append(data)
            heard.append(_Overheard(now_s, data))
            del heard[:-HEARD_MAX]
            forged = ATTACKS[self._attack](self._place(party_id, now_s, heard))
            if forged is not None:
                given.append(forged)
                self._sent[party_id] += 1
        return super().advance(party_id, now_s, given, told)

    def _place(self, party_id: str, now_s: float, heard: Sequence[_Overheard]) -> _Place:
        others = [one for other, known in self._heard.items() if other != party_id for one in known[-4:]]
        source = header_of(heard[-1].data)
        spoken = "" if source is None else source.source
        thieves = [
            s.keys for p, s in self._specs.items() if p not in (party_id, spoken) and party_id in s.keys.pairs
        ]
        keys = thieves[int(self._chance.integers(len(thieves)))] if thieves else None
        return _Place(party_id, now_s, heard, others, keys, self._chance)


def _look_away(_party_id: str, _state: PartyState) -> None:
    """Nobody looks at the parties."""


class Intruded(NamedTuple):
    """What came of an attack: telegrams sent, of those dropped by reason, and the first line that is another."""

    attack: Attack
    sent: int
    dropped: Counter[str]
    differs: str

    @property
    def held(self) -> bool:
        """Whether he was heard, had no effect, and each telegram was counted."""
        return bool(self.sent) and not self.differs and self.dropped.total() == self.sent


def intruded(scenario: Scenario, seed: int, attacks: Sequence[Attack]) -> list[Intruded]:
    """Run a scenario without an intruder, and once with each attack."""
    before = _run(scenario, None, seed, Counter())
    calm, dropped = _lines(before), _drops(before)
    found = list[Intruded]()
    for attack in attacks:
        sent = Counter[str]()
        result = _run(scenario, attack, seed, sent)
        lines = _lines(result)
        first = next((b for a, b in zip(calm, lines, strict=False) if a != b), b"")
        differs = first.decode() or (
            "" if len(calm) == len(lines) else f"{len(lines)} lines, not {len(calm)}"
        )
        found.append(Intruded(attack, sent.total(), _drops(result) - dropped, differs))
    return found


def _run(scenario: Scenario, attack: Attack | None, seed: int, sent: Counter[str]) -> RunResult:
    return result_of(
        scenario,
        CarrierKind.PLAIN,
        UnitsAt.PROCESSES,
        None if attack is None else lambda parties: IntrudedParties(parties, attack, seed, sent),
    )


def _lines(result: RunResult) -> list[bytes]:
    return [encode_entry(e) for e in result.journal.entries if not isinstance(e.event, TelegramDropped)]


def _drops(result: RunResult) -> Counter[str]:
    return Counter(e.event.why for e in result.journal.entries if isinstance(e.event, TelegramDropped))


class Threat(NamedTuple):
    """A threat of EN 50159: how it is met, by which reasons telegrams are then dropped, and what shows it."""

    name: str
    defence: str
    reasons: tuple[DropReason, ...]
    attacks: tuple[Attack, ...]
    tests: tuple[str, ...]


_ENVELOPE: Final = "tests/radio/test_envelope.py::test_"
THREATS: Final = (
    Threat(
        "repetition",
        "sequence numbers, and a window of those that came",
        (DropReason.REPEATED,),
        (Attack.REPETITION,),
        (f"{_ENVELOPE}repetition", f"{_ENVELOPE}each_telegram_takes_effect_at_most_once_and_in_order"),
    ),
    Threat(
        "deletion",
        "requests and commands are repeated until they are answered; silence frees nothing",
        (),
        (),
        (
            f"{_ENVELOPE}deletion_is_counted_and_answered_by_a_request_with_the_same_correlation",
            "tests/verify/test_explore.py::test_every_state_is_safe_and_alive",
        ),
    ),
    Threat(
        "insertion",
        "source and destination under a keyed code; boots of both ends",
        (DropReason.UNKNOWN_SOURCE, DropReason.WRONG_DESTINATION, DropReason.EARLIER_BOOT),
        (Attack.INSERTION, Attack.MISDIRECTION),
        (
            f"{_ENVELOPE}insertion_from_an_unknown_source_or_for_another",
            f"{_ENVELOPE}insertion_of_what_was_meant_for_an_earlier_boot",
        ),
    ),
    Threat(
        "re-sequencing",
        "only greater sequence numbers pass; boots only grow",
        (DropReason.OUT_OF_ORDER, DropReason.OLD_EPOCH, DropReason.REPEATED),
        (Attack.RESEQUENCING,),
        (f"{_ENVELOPE}resequencing_within_a_boot", f"{_ENVELOPE}resequencing_over_a_restart_of_the_source"),
    ),
    Threat(
        "corruption",
        "HMAC-SHA256, 128 bits, over all that is sent",
        (DropReason.CORRUPTED, DropReason.WRONG_DESTINATION, DropReason.UNKNOWN_SOURCE),
        (Attack.CORRUPTION,),
        (f"{_ENVELOPE}corruption_of_any_bit", f"{_ENVELOPE}noise_is_dropped_and_raises_nothing"),
    ),
    Threat(
        "delay",
        f"an age limit of {AGE_MAX_S:g} s by the receiver's own clock",
        (DropReason.STALE, DropReason.IMPLAUSIBLE_TIME),
        (Attack.DELAY,),
        (f"{_ENVELOPE}delay_beyond_the_age_limit", f"{_ENVELOPE}time_that_cannot_be"),
    ),
    Threat(
        "masquerade",
        "a key for each pair of parties; a unit whose own keys are stolen is barred by two persons",
        (DropReason.CORRUPTED,),
        (Attack.MASQUERADE, Attack.MASQUERADE_WITH_KEYS),
        (
            f"{_ENVELOPE}masquerade_with_the_keys_of_another_party",
            "tests/wayside/test_barring.py::test_a_terminal_obeys_a_barred_unit_no_more",
        ),
    ),
)
