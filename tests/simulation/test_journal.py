from __future__ import annotations

import json
from hashlib import blake2b

from simulation.journal import Entry, Journal


def written() -> Journal:
    journal = Journal()
    journal.write(0.1, "V1", "holds", sections=("3",), token=7)
    journal.write(0.2, "world", "entered", text="駅")
    return journal


def test_one_json_object_a_line() -> None:
    lines = written().to_bytes().splitlines()
    assert [json.loads(line) for line in lines] == [
        {"t": 0.1, "who": "V1", "what": "holds", "sections": ["3"], "token": 7},
        {"t": 0.2, "who": "world", "what": "entered", "text": "駅"},
    ]


def test_the_digest_is_that_of_the_file() -> None:
    journal = written()
    assert journal.digest() == blake2b(journal.to_bytes(), digest_size=16).hexdigest()
    assert journal.digest() == written().digest()
    journal.add_to_digest(b"trajectory")
    assert journal.digest() != written().digest()


def test_watchers_see_every_further_entry_in_order() -> None:
    journal = Journal()
    journal.write(0.0, "V1", "before")
    seen: list[Entry] = []
    journal.watch(seen.append)
    journal.write(0.1, "V1", "one")
    journal.write(0.1, "V1", "two")
    assert [entry["what"] for entry in seen] == ["one", "two"]
    assert Journal().to_bytes() == b""
