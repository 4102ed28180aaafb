"""Invariant: nothing takes effect that was not made with the party's key of this boot, for this party, in the
round that is asked; whatever else is heard ends the run.

The time plane carries orders as powerful as telegrams (point detection, relay outputs, a person's inputs), so
it is as authentic as they are. A round is one question and its answer, each sealed with an HMAC cut to 128
bits; every telegram of the round has a tag: round, place in the round, and the code of both with its bytes.
Rounds grow by one, so nothing that was said before takes effect again; the last question, asked again, is answered as
before by `host.serve`, and moves nothing. Round `READY` asks whether the party is
there; its one telegram proves the radio plane. Both ends are here, without a socket, a clock or a process.

| what is heard                                       | refused by          |
|-----------------------------------------------------|---------------------|
| a question, an answer or a telegram by another hand | `authentic`         |
| an authentic one that was meant for another party   | `of_party`          |
| an authentic one of an earlier round, said again    | `of_round`          |
| a telegram of the round, twice or in another order  | `of_place`          |
| a session that was not given to a party             | `of_run`            |
| one that was, with the certificate of another       | `of_certificate`    |
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import Final

import msgspec

from host.parties import ForeignError
from host.party import Advance, Party
from radio.keys import MAC_BYTES, mac, mac_equal

READY: Final = 0
READY_DESTINATION: Final = "ready"


class Question(msgspec.Struct, frozen=True, array_like=True):
    """From the simulator: advance to `now_s`; `telegrams` of this round are on the radio plane."""

    party_id: str
    round: int
    now_s: float
    telegrams: int
    told: bytes = b""


class PartyAnswer(msgspec.Struct, frozen=True, array_like=True):
    """From the party: done, and `sent` telegrams of this round are on the radio plane; or why it failed.

    `bug`: its program is at fault, and no want of the machine.
    """

    party_id: str
    round: int
    sent: int
    wake_at_s: float | None = None
    said: bytes = b""
    failed: str = ""
    bug: bool = False


class RoundTag(msgspec.Struct, frozen=True, array_like=True):
    """What goes with a telegram on the radio plane: `place` counts the telegrams of a round from 0."""

    round: int
    place: int
    code: bytes


class Tagged(msgspec.Struct, frozen=True):
    """A telegram on the radio plane, with its tag as bytes."""

    destination: str
    data: bytes
    tag: bytes


def authentic(code: bytes, expected: bytes) -> bool:
    """Whether who made the code has the key."""
    return mac_equal(code, expected)


def of_party(found: str, expected: str) -> bool:
    """Whether it was meant for this party, or said by it."""
    return found == expected


def of_round(found: int, expected: int) -> bool:
    """Whether it belongs to the round that is asked."""
    return found == expected


def of_place(found: int, expected: int) -> bool:
    """Whether it is the next telegram of the round."""
    return found == expected


def of_run(session_id: str, given: Container[str]) -> bool:
    """Whether a session was given its name by this run."""
    return session_id in given


def of_certificate(shown: str | None, expected: str | None) -> bool:
    """Whether a session has the certificate of its party; on the socket nobody has one."""
    return shown == expected


_QUESTION: Final = msgspec.msgpack.Decoder(Question)
_ANSWER: Final = msgspec.msgpack.Decoder(PartyAnswer)
_TAG: Final = msgspec.msgpack.Decoder(RoundTag)
_ENCODER: Final = msgspec.msgpack.Encoder()


class Asker:
    """The simulator's end of the time plane of one boot of one party."""

    def __init__(self, party_id: str, key: bytes) -> None:
        self.party_id: Final = party_id
        self.round = READY
        self._key = key

    def ask_ready(self) -> bytes:
        """The question whether the party is there; may be asked until it is answered."""
        return _sealed(self._key, b"question", _ENCODER.encode(Question(self.party_id, READY, 0.0, 0)))

    def ask(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> tuple[bytes, tuple[Tagged, ...]]:
        """A new round: its question, and the telegrams to send before it."""
        self.round += 1
        pairs = [(self.party_id, data) for data in telegrams]
        question = Question(self.party_id, self.round, now_s, len(pairs), told)
        sealed = _sealed(self._key, b"question", _ENCODER.encode(question))
        return sealed, _tagged(self._key, b"to", self.round, pairs)

    def answer(self, data: bytes) -> PartyAnswer:
        """The answer to the last question. Raises ForeignError."""
        what = f"a foreign reply to the question to {self.party_id}"
        try:
            answer = _ANSWER.decode(_opened(self._key, b"answer", data, what))
        except msgspec.MsgspecError:
            raise ForeignError(f"{what}: no answer at all") from None
        _belongs(answer, self.party_id, self.round, what)
        return answer

    def advance(self, answer: PartyAnswer, heard: Sequence[Tagged]) -> Advance:
        """What the party did, given the telegrams of its answer. Raises ForeignError."""
        for place, telegram in enumerate(heard):
            _check_tag(self._key, b"from", self.round, place, telegram)
        telegrams = tuple((telegram.destination, telegram.data) for telegram in heard)
        return Advance(telegrams, answer.said, answer.wake_at_s)


class Answerer:
    """The party's end: it acts when it is asked, and then only on what was sealed for it."""

    def __init__(self, party_id: str, key: bytes, party: Party) -> None:
        self._party_id = party_id
        self._key = key
        self._party = party
        self._last_round = READY

    def question(self, data: bytes) -> Question:
        """The question in `data`. Raises ForeignError; then nothing has changed."""
        what = f"a foreign question to {self._party_id}"
        try:
            question = _QUESTION.decode(_opened(self._key, b"question", data, what))
        except msgspec.MsgspecError:
            raise ForeignError(f"{what}: no question at all") from None
        _belongs(question, self._party_id, READY if question.round == READY else self._last_round + 1, what)
        return question

    def answer(self, question: Question, heard: Sequence[Tagged]) -> tuple[bytes, tuple[Tagged, ...]]:
        """Act: the answer, and the telegrams to send before it. Raises ForeignError, and what the party
        raises.
        """
        if question.round == READY:
            answer, pairs = PartyAnswer(self._party_id, READY, 1), [(READY_DESTINATION, b"")]
        else:
            for place, telegram in enumerate(heard):
                _check_tag(self._key, b"to", question.round, place, telegram)
            self._last_round = question.round
            done = self._party.advance(question.now_s, [telegram.data for telegram in heard], question.told)
            pairs = list(done.telegrams)
            answer = PartyAnswer(self._party_id, question.round, len(pairs), done.wake_at_s, done.said)
        sealed = _sealed(self._key, b"answer", _ENCODER.encode(answer))
        return sealed, _tagged(self._key, b"from", question.round, pairs)

    def failure(self, question: Question, text: str, *, bug: bool) -> bytes:
        """The answer that says why there is none."""
        answer = PartyAnswer(self._party_id, question.round, 0, failed=text, bug=bug)
        return _sealed(self._key, b"answer", _ENCODER.encode(answer))


def _belongs(record: Question | PartyAnswer, party_id: str, number: int, what: str) -> None:
    if not of_party(record.party_id, party_id):
        raise ForeignError(f"{what}: it is for {record.party_id}")
    if not of_round(record.round, number):
        raise ForeignError(f"{what}: round {record.round} where {number} is due")


def _sealed(key: bytes, purpose: bytes, body: bytes) -> bytes:
    return body + mac(key, purpose + body)


def _opened(key: bytes, purpose: bytes, data: bytes, what: str) -> bytes:
    body, code = data[:-MAC_BYTES], data[-MAC_BYTES:]
    if not authentic(code, mac(key, purpose + body)):
        raise ForeignError(f"{what}: its code is not of this run")
    return body


def _tagged(
    key: bytes, purpose: bytes, number: int, pairs: Sequence[tuple[str, bytes]]
) -> tuple[Tagged, ...]:
    return tuple(
        Tagged(
            name,
            data,
            _ENCODER.encode(RoundTag(number, place, _code(key, purpose, number, place, name, data))),
        )
        for place, (name, data) in enumerate(pairs)
    )


def _check_tag(key: bytes, purpose: bytes, number: int, place: int, telegram: Tagged) -> None:
    what = f"a foreign telegram to {telegram.destination}"
    try:
        tag = _TAG.decode(telegram.tag)
    except msgspec.MsgspecError:
        raise ForeignError(f"{what}: it has no tag of this run") from None
    expected = _code(key, purpose, tag.round, tag.place, telegram.destination, telegram.data)
    if not authentic(tag.code, expected):
        raise ForeignError(f"{what}: its tag is not of this run")
    if not of_round(tag.round, number):
        raise ForeignError(f"{what}: of round {tag.round} where {number} is due")
    if not of_place(tag.place, place):
        raise ForeignError(f"{what}: telegram {tag.place} of its round where {place} is due")


def _code(key: bytes, purpose: bytes, number: int, place: int, destination: str, data: bytes) -> bytes:
    return mac(key, _ENCODER.encode((purpose, number, place, destination, data)))
