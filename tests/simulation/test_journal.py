"""The journal: flat lines, and every type of event comes back from its line as it was."""

from __future__ import annotations

import json
from enum import Enum
from hashlib import blake2b
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.model import Position
from onboard.notes import Arrived, Departs, Holds, Moving, Proven
from simulation.events import EVENTS, WORLD, Collision, Entry, EventType, authors_of, unit_of, word_of
from simulation.journal import Journal, decode_entry, encode_entry, read_journal
from wayside.said import Granted, Refused

TOKEN_MAX = 2**63 - 1
LEAVES: dict[type, st.SearchStrategy[Any]] = {
    NoneType: st.none(),
    bool: st.booleans(),
    int: st.integers(0, TOKEN_MAX),
    float: st.floats(allow_nan=False, allow_infinity=False),
    str: st.text(st.characters(codec="utf-8")),
}


def values(hint: object) -> st.SearchStrategy[Any]:
    """Values of a field's type; KeyError for a type that no line could carry."""
    if get_origin(hint) in (Union, UnionType):
        return st.one_of(*map(values, get_args(hint)))
    if get_origin(hint) is tuple:
        return st.lists(values(get_args(hint)[0]), max_size=4).map(tuple)
    if get_origin(hint) is dict:
        return st.dictionaries(*map(values, get_args(hint)), max_size=3)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return st.sampled_from(hint)
    assert isinstance(hint, type)
    return LEAVES[hint]


def made(kind: EventType) -> st.SearchStrategy[Any]:
    hints = get_type_hints(kind)
    return st.fixed_dictionaries({name: values(hints[name]) for name in kind.__struct_fields__}).map(
        lambda data: kind(**data)
    )


def written() -> Journal:
    journal = Journal()
    journal.write(0.1, "V1", Holds(section_ids=("3",), token=7))
    journal.write(0.2, WORLD, Collision(text="駅"))
    return journal


def test_one_flat_json_object_a_line() -> None:
    lines = written().to_bytes().splitlines()
    found = [json.loads(line) for line in lines]
    assert found == [
        {"t": 0.1, "who": "V1", "what": "holds", "sections": ["3"], "token": 7},
        {"t": 0.2, "who": "world", "what": "collision", "text": "駅"},
    ]
    assert [list(entry)[:3] for entry in found] == [["t", "who", "what"]] * 2


def test_an_id_goes_by_the_word_for_the_thing_and_a_default_is_left_out() -> None:
    granted = Granted(unit_id="V1", section_ids=("3", "5"), token=9, route_id="r")
    assert json.loads(encode_entry(Entry(1.0, "block-manager", granted))) == {
        "t": 1.0,
        "who": "block-manager",
        "what": "granted",
        "unit": "V1",
        "sections": ["3", "5"],
        "token": 9,
        "route": "r",
    }
    line = encode_entry(Entry(1.0, "block-manager", Refused(why="HELD")))
    assert json.loads(line) == {"t": 1.0, "who": "block-manager", "what": "refused", "why": "HELD"}
    assert json.loads(encode_entry(Entry(1.0, "V1", Arrived(station="B", error_m=None))))["error_m"] is None


@pytest.mark.parametrize("word", EVENTS)
@given(data=st.data())
def test_every_event_comes_back_from_its_line(word: str, data: st.DataObject) -> None:
    event = data.draw(made(EVENTS[word]))
    entry = Entry(data.draw(LEAVES[float]), data.draw(LEAVES[str]), event)
    line = encode_entry(entry)
    again = decode_entry(line)
    assert again == entry
    assert type(again.event) is EVENTS[word]
    assert encode_entry(again) == line
    assert json.loads(line)["what"] == word


def test_every_event_has_a_word_of_its_own_an_author_and_a_meaning() -> None:
    kinds = list(EVENTS.values())
    assert len(set(kinds)) == len(kinds) > 70
    for word, kind in EVENTS.items():
        assert word_of(kind) == word
        assert authors_of(kind), word
        assert kind.__doc__, word
        assert not {"t", "who", "what"} & {field.encode_name for field in msgspec.structs.fields(kind)}


def test_an_event_is_frozen_and_no_two_types_are_equal() -> None:
    moving = Moving()
    with pytest.raises(AttributeError):
        Departs(station="B").station = "A"  # type: ignore[misc]
    assert moving == Moving()
    assert Departs(station="B") != Arrived(station="B", error_m=None)


def test_the_unit_of_an_entry_is_the_one_it_names_or_its_author() -> None:
    granted = Granted(unit_id="V1", section_ids=("3",), token=9, route_id="r")
    assert unit_of(Entry(1.0, "block-manager", granted)) == "V1"
    assert unit_of(Entry(1.0, "V2", Moving())) == "V2"


def test_a_file_is_read_back_and_a_line_that_is_none_is_named(tmp_path: Path) -> None:
    journal = written()
    file = tmp_path / "journal.jsonl"
    file.write_bytes(journal.to_bytes())
    assert read_journal(file) == journal.entries
    file.write_bytes(journal.to_bytes() + b'{"t":0.3,"who":"V1","what":"dances"}\n')
    with pytest.raises(InputError, match="line 3"):
        read_journal(file)
    with pytest.raises(InputError, match="can be read"):
        read_journal(tmp_path / "nothing")


def test_the_digest_is_that_of_the_file() -> None:
    journal = written()
    assert journal.digest() == blake2b(journal.to_bytes(), digest_size=16).hexdigest()
    assert journal.digest() == written().digest()
    journal.add_to_digest(b"trajectory")
    assert journal.digest() != written().digest()


def test_watchers_see_every_further_entry_in_order() -> None:
    journal = Journal()
    journal.write(0.0, "V1", Moving())
    seen: list[Entry] = []
    journal.watch(seen.append)
    departs, proven = Departs(station="B"), Proven(points_id="P7", position=Position.NORMAL, token=1)
    journal.write(0.1, "V1", departs)
    journal.write(0.1, "V1", proven)
    assert [entry.event for entry in seen] == [departs, proven]
    assert Journal().to_bytes() == b""
