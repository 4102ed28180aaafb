"""The journal: flat lines, and every type of event comes back from its line as it was."""

import errno
import json
import subprocess
import sys
import tracemalloc
from collections.abc import Iterable
from enum import Enum
from hashlib import blake2b
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, Union, get_args, get_origin

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.model import Position
from onboard.notes import Arrived, Departs, Holds, Moving, Proven
from simulation.events import EVENTS, WORLD, Collision, JournalEntry, authors_of, unit_of, word_of
from simulation.journal import SPILL_BYTES, Journal, decode_entry, encode_entry, last_time_s, read_journal
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
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return made(hint)
    assert isinstance(hint, type)
    return LEAVES[hint]


def made(kind: type[msgspec.Struct]) -> st.SearchStrategy[Any]:
    fields = {field.name: values(field.type) for field in msgspec.structs.fields(kind)}
    return st.fixed_dictionaries(fields).map(lambda data: kind(**data))


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
    assert json.loads(encode_entry(JournalEntry(1.0, "block-manager", granted))) == {
        "t": 1.0,
        "who": "block-manager",
        "what": "granted",
        "unit": "V1",
        "sections": ["3", "5"],
        "token": 9,
        "route": "r",
    }
    line = encode_entry(JournalEntry(1.0, "block-manager", Refused(why="HELD")))
    assert json.loads(line) == {"t": 1.0, "who": "block-manager", "what": "refused", "why": "HELD"}
    assert (
        json.loads(encode_entry(JournalEntry(1.0, "V1", Arrived(station="B", error_m=None))))["error_m"]
        is None
    )


@pytest.mark.parametrize("word", EVENTS)
@given(data=st.data())
def test_every_event_comes_back_from_its_line(word: str, data: st.DataObject) -> None:
    event = data.draw(made(EVENTS[word]))
    entry = JournalEntry(data.draw(LEAVES[float]), data.draw(LEAVES[str]), event)
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
    assert unit_of(JournalEntry(1.0, "block-manager", granted)) == "V1"
    assert unit_of(JournalEntry(1.0, "V2", Moving())) == "V2"


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
    seen: list[JournalEntry] = []
    journal.watch(seen.append)
    departs, proven = Departs(station="B"), Proven(points_id="P7", position=Position.NORMAL, token=1)
    journal.write(0.1, "V1", departs)
    journal.write(0.1, "V1", proven)
    assert [entry.event for entry in seen] == [departs, proven]
    assert Journal().to_bytes() == b""


# in a file ------------------------------------------------------------------------------------------------------


def course(length: int) -> list[JournalEntry]:
    """Entries of many lengths."""
    return [
        JournalEntry(0.1 * n, f"V{n % 7}", Holds(section_ids=("駅",) * (n % 23), token=n))
        for n in range(length)
    ]


def grown(journal: Journal, entries: Iterable[JournalEntry]) -> Journal:
    for entry in entries:
        journal.write(entry.t_s, entry.who, entry.event)
    return journal


@pytest.mark.parametrize("length", [0, 1, 40, 2000])
def test_it_is_the_same_in_a_file(tmp_path: Path, length: int) -> None:
    """Digest, bytes and entries; read in the middle of it, and when it is whole; under another name, too."""
    entries = course(length)
    file = tmp_path / "journal.jsonl"
    here, there = grown(Journal(), entries), Journal(file)
    for number, entry in enumerate(entries):
        there.write(entry.t_s, entry.who, entry.event)
        if number % 500 == 250:
            assert list(there.entries) == entries[: number + 1]
    assert there.digest() == here.digest()
    assert there.to_bytes() == here.to_bytes()
    assert list(there.entries) == entries == here.entries
    there.spill()
    assert file.read_bytes() == here.to_bytes()
    there.moved(file.rename(tmp_path / "put"))
    assert list(there.entries) == entries
    assert len(there.entries) == length
    if entries:
        assert (there.entries[-1], there.entries[:1]) == (entries[-1], entries[:1])
        assert last_time_s(tmp_path / "put") == entries[-1].t_s
    else:
        assert last_time_s(tmp_path / "put") is None


def test_what_is_in_the_file_is_not_in_memory(tmp_path: Path) -> None:
    """What a journal takes does not grow with the day."""
    held = []
    for length in (3000, 12_000):
        entries = course(length)
        tracemalloc.start()
        before, _ = tracemalloc.get_traced_memory()
        journal = grown(Journal(tmp_path / str(length)), entries)
        after, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert (tmp_path / str(length)).stat().st_size > 4 * SPILL_BYTES
        held.append(after - before)
        assert journal.entries
    assert max(held) < 8 * SPILL_BYTES


WRITER: Final = """
import resource, sys
from pathlib import Path
from onboard.notes import Holds
from simulation.journal import Journal
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
journal = Journal(Path(sys.argv[1]))
try:
    for n in range(20_000):
        journal.write(0.1 * n, "V1", Holds(section_ids=("3",) * (n % 23), token=n))
except OSError as error:
    print(error.errno, error.filename, n + 1, len(journal.entries))
"""


@pytest.mark.parametrize("room_bytes", [0, 10, 40_000, 123_457])
def test_where_the_disk_is_full_it_ends_with_a_whole_line(tmp_path: Path, room_bytes: int) -> None:
    """A limit of the size of files stands for the disk; what is not in the file is still in memory."""
    file = tmp_path / "journal.jsonl"
    done = subprocess.run(
        [sys.executable, "-c", WRITER, str(file), str(room_bytes)], capture_output=True, text=True, check=True
    )
    number, name, written, held = done.stdout.split()
    assert (int(number), name) == (errno.EFBIG, str(file))
    assert written == held
    kept = read_journal(file)  # no half line
    assert [entry.event for entry in kept] == [
        Holds(section_ids=("3",) * (n % 23), token=n) for n in range(len(kept))
    ]
    assert room_bytes - 200 < file.stat().st_size <= room_bytes or room_bytes < 200
