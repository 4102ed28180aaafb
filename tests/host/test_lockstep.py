"""The time plane is authenticated: each defence alone keeps something out, and without it that comes in."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import msgspec
import pytest

import host.lockstep
from host.lockstep import READY, READY_DESTINATION, Answerer, Asker, Tagged
from host.parties import ForeignError
from host.party import Advance

KEY: Final = b"k" * 32
OTHER_KEY: Final = b"o" * 32


@dataclass
class Echo:
    """A party that sends each telegram on to u1 and says what it was told."""

    asked: list[tuple[float, tuple[bytes, ...], bytes]] = field(default_factory=list)
    epoch: int = 1

    def advance(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        self.asked.append((now_s, tuple(telegrams), told))
        return Advance(tuple(("u1", data) for data in telegrams), told, now_s + 1.0)


class Pair:
    """Both ends of the plane, nothing between them."""

    def __init__(self, party_id: str = "t", key: bytes = KEY) -> None:
        self.party = Echo()
        self.asker = Asker(party_id, key)
        self.answerer = Answerer(party_id, key, self.party)

    def round(self, *telegrams: bytes, told: bytes = b"") -> Advance:
        sealed, tagged = self.asker.ask(5.0, telegrams, told)
        return self.close(*self.answerer.answer(self.answerer.question(sealed), tagged))

    def close(self, sealed: bytes, heard: Sequence[Tagged]) -> Advance:
        return self.asker.advance(self.asker.answer(sealed), heard)


def test_a_round_carries_everything_there_and_back() -> None:
    pair = Pair()
    for _ in range(3):
        done = pair.round(b"one", b"two", b"two", told=b"points")
        assert done == Advance((("u1", b"one"), ("u1", b"two"), ("u1", b"two")), b"points", 6.0)
    assert pair.party.asked == [(5.0, (b"one", b"two", b"two"), b"points")] * 3


def test_being_there_is_asked_as_often_as_needed_and_moves_nothing() -> None:
    pair = Pair()
    for _ in range(2):
        question = pair.answerer.question(pair.asker.ask_ready())
        assert question.round == READY
        done = pair.close(*pair.answerer.answer(question, ()))
        assert done.telegrams == ((READY_DESTINATION, b""),)
    assert pair.party.asked == []
    assert pair.round(b"one").telegrams == (("u1", b"one"),)


def test_a_failure_is_as_authentic_as_an_answer() -> None:
    pair = Pair()
    question = pair.answerer.question(pair.asker.ask(5.0, (), b"")[0])
    assert pair.asker.answer(pair.answerer.failure(question, "no points", bug=False)).failed == "no points"
    with pytest.raises(ForeignError):
        pair.asker.answer(Pair(key=OTHER_KEY).answerer.failure(question, "no points", bug=False))


# what each defence keeps out: it takes effect when the defence is off ---------------------------------------


def question_of_another_hand() -> None:
    """Someone without the key asks the terminal to see its points."""
    pair = Pair()
    sealed, _ = Asker("t", OTHER_KEY).ask(5.0, (), b"points")
    pair.answerer.answer(pair.answerer.question(sealed), ())
    assert pair.party.asked == [(5.0, (), b"points")]


def question_changed() -> None:
    """One bit of the time of a question is another."""
    pair = Pair()
    sealed = bytearray(pair.asker.ask(5.0, (), b"points")[0])
    sealed[sealed.index(msgspec.msgpack.encode(5.0)) + 1] ^= 1
    pair.answerer.answer(pair.answerer.question(bytes(sealed)), ())
    assert pair.party.asked[0][0] != 5.0


def answer_of_another_hand() -> None:
    """Someone without the key says that the motor is to run."""
    pair, other = Pair(), Pair(key=OTHER_KEY)
    pair.asker.ask(5.0, (), b"")
    question = other.answerer.question(other.asker.ask(5.0, (), b"run")[0])
    assert pair.close(*other.answerer.answer(question, ())).said == b"run"


def telegram_of_another_hand_to_the_party() -> None:
    pair, other = Pair(), Pair(key=OTHER_KEY)
    _, tagged = other.asker.ask(5.0, (b"stop",), b"")
    sealed, _ = pair.asker.ask(5.0, (b"go",), b"")
    pair.answerer.answer(pair.answerer.question(sealed), tagged)
    assert pair.party.asked[0][1] == (b"stop",)


def telegram_of_another_hand_from_the_party() -> None:
    pair, other = Pair(), Pair(key=OTHER_KEY)
    sealed, tagged = pair.asker.ask(5.0, (b"go",), b"")
    answer, _ = pair.answerer.answer(pair.answerer.question(sealed), tagged)
    strange = other.answerer.question(other.asker.ask(5.0, (b"stop",), b"")[0])
    _, heard = other.answerer.answer(strange, Pair(key=OTHER_KEY).asker.ask(5.0, (b"stop",), b"")[1])
    assert pair.close(answer, heard).telegrams == (("u1", b"stop"),)


def telegram_turned_to_another_destination() -> None:
    pair = Pair()
    sealed, tagged = pair.asker.ask(5.0, (b"go",), b"")
    answer, (heard,) = pair.answerer.answer(pair.answerer.question(sealed), tagged)
    turned = msgspec.structs.replace(heard, destination="u2")
    assert pair.close(answer, [turned]).telegrams == (("u2", b"go"),)


def telegram_of_the_party_sent_back_to_it() -> None:
    """What is said and what is heard have codes of their own, even under one key and one name."""
    pair = Pair("u1")
    _, heard = pair.answerer.answer(
        *reversed_question(pair, pair.asker.ask(5.0, (b"go",), b"")),
    )
    pair.answerer.answer(pair.answerer.question(pair.asker.ask(6.0, (b"on",), b"")[0]), renumbered(heard))
    assert pair.party.asked[1][1] == (b"go",)


def reversed_question(
    pair: Pair, asked: tuple[bytes, tuple[Tagged, ...]]
) -> tuple[host.lockstep.Question, tuple[Tagged, ...]]:
    sealed, tagged = asked
    return pair.answerer.question(sealed), tagged


def renumbered(heard: Sequence[Tagged]) -> tuple[Tagged, ...]:
    """Their tags with the number of the round after; the codes stay."""
    tags = [msgspec.msgpack.decode(telegram.tag, type=host.lockstep.RoundTag) for telegram in heard]
    return tuple(
        msgspec.structs.replace(
            telegram, tag=msgspec.msgpack.encode(host.lockstep.RoundTag(2, t.place, t.code))
        )
        for telegram, t in zip(heard, tags, strict=True)
    )


def question_for_another_party() -> None:
    pair = Pair()
    sealed, _ = Asker("other", KEY).ask(5.0, (), b"points")
    pair.answerer.answer(pair.answerer.question(sealed), ())
    assert pair.party.asked == [(5.0, (), b"points")]


def answer_of_another_party() -> None:
    pair, other = Pair(), Pair("other")
    pair.asker.ask(5.0, (), b"")
    question = other.answerer.question(other.asker.ask(5.0, (), b"run")[0])
    assert pair.close(*other.answerer.answer(question, ())).said == b"run"


def question_said_again() -> None:
    pair = Pair()
    sealed, _ = pair.asker.ask(5.0, (), b"points")
    for _ in range(2):
        pair.answerer.answer(pair.answerer.question(sealed), ())
    assert len(pair.party.asked) == 2


def answer_said_again() -> None:
    pair = Pair()
    sealed, _ = pair.asker.ask(5.0, (), b"run")
    answer, _ = pair.answerer.answer(pair.answerer.question(sealed), ())
    pair.asker.answer(answer)
    pair.asker.ask(6.0, (), b"halt")
    assert pair.close(answer, ()).said == b"run"


def telegram_said_again_in_the_next_round() -> None:
    pair = Pair()
    sealed, tagged = pair.asker.ask(5.0, (b"go",), b"")
    pair.answerer.answer(pair.answerer.question(sealed), tagged)
    sealed, _ = pair.asker.ask(6.0, (b"stop",), b"")
    pair.answerer.answer(pair.answerer.question(sealed), tagged)
    assert [telegrams for _, telegrams, _ in pair.party.asked] == [(b"go",), (b"go",)]


def telegram_twice_in_a_round() -> None:
    pair = Pair()
    sealed, tagged = pair.asker.ask(5.0, (b"go",), b"")
    pair.answerer.answer(pair.answerer.question(sealed), (*tagged, *tagged))
    assert pair.party.asked[0][1] == (b"go", b"go")


def telegrams_in_another_order() -> None:
    pair = Pair()
    sealed, tagged = pair.asker.ask(5.0, (b"one", b"two"), b"")
    pair.answerer.answer(pair.answerer.question(sealed), tagged[::-1])
    assert pair.party.asked[0][1] == (b"two", b"one")


ATTACKS: Final[list[tuple[str, Callable[[], None]]]] = [
    ("authentic", question_of_another_hand),
    ("authentic", question_changed),
    ("authentic", answer_of_another_hand),
    ("authentic", telegram_of_another_hand_to_the_party),
    ("authentic", telegram_of_another_hand_from_the_party),
    ("authentic", telegram_turned_to_another_destination),
    ("authentic", telegram_of_the_party_sent_back_to_it),
    ("of_party", question_for_another_party),
    ("of_party", answer_of_another_party),
    ("of_round", question_said_again),
    ("of_round", answer_said_again),
    ("of_round", telegram_said_again_in_the_next_round),
    ("of_place", telegram_twice_in_a_round),
    ("of_place", telegrams_in_another_order),
]
attacks = pytest.mark.parametrize(("defence", "attack"), ATTACKS, ids=[a.__name__ for _, a in ATTACKS])


@attacks
def test_what_is_not_ours_takes_no_effect_and_ends_the_run(defence: str, attack: Callable[[], None]) -> None:
    with pytest.raises(ForeignError, match=r"^a foreign (question|reply|telegram) to"):
        attack()


@attacks
def test_without_its_defence_it_takes_effect(
    defence: str, attack: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """So the test above holds by this defence and by no other."""
    monkeypatch.setattr(host.lockstep, defence, lambda _found, _expected: True)
    attack()


@pytest.mark.parametrize("data", [b"", b"\xc1", b"x" * 16, bytes(40)])
def test_noise_is_foreign_whatever_it_is(data: bytes) -> None:
    pair = Pair()
    sealed, _ = pair.asker.ask(5.0, (b"go",), b"")
    with pytest.raises(ForeignError, match="a foreign question to t"):
        pair.answerer.question(data)
    with pytest.raises(ForeignError, match="a foreign reply to the question to t"):
        pair.asker.answer(data)
    question = pair.answerer.question(sealed)
    with pytest.raises(ForeignError, match="a foreign telegram to t"):
        pair.answerer.answer(question, [Tagged("t", b"go", data)])
    assert pair.party.asked == []
