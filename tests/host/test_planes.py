"""Key expressions and configuration of the two planes."""

from __future__ import annotations

import msgspec
import pytest

from host.planes import Question, radio_key, round_tag, session_json5, time_key
from network.errors import InputError
from wayside.said import ConfirmOutside, PointsDetected


def test_keys() -> None:
    assert radio_key("karasuyama", "t1") == "branchline/karasuyama/radio/t1"
    assert radio_key("karasuyama", "*") == "branchline/karasuyama/radio/*"
    assert time_key("karasuyama", "t1") == "branchline/karasuyama/time/t1"


@pytest.mark.parametrize("name", ["", "a/b", "a*", "a b", "a?b", "$x", "#"])
def test_names_that_would_change_the_key_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="an id without"):
        time_key("line", name)


def test_rounds_are_told_apart() -> None:
    assert len({round_tag(number) for number in (0, 1, 256, 1 << 40)}) == 4


def test_a_session_scouts_for_nobody() -> None:
    config = msgspec.json.decode(session_json5("connect", "tcp/127.0.0.1:1"))
    assert config["scouting"] == {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    assert config["listen"] == {"endpoints": []}


def test_a_question_keeps_its_inputs() -> None:
    question = Question(3, 1.5, 2, (ConfirmOutside("u", "x"), PointsDetected("p", None, False)))
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(question), type=Question) == question
