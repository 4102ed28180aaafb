"""A run as an MCAP file, for viewers of recorded data: its journal, a channel each event, and where trains were, one
each unit. Messages are JSON, their schemas those of the types that wrote them; times are since midnight.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from heapq import merge
from pathlib import Path
from typing import IO, Any, Final, NamedTuple

import msgspec
from mcap.writer import Writer

from network.files.json_input import writing_aside
from network.files.text_input import existing_file
from simulation.events import EVENTS, EventType, JournalEntry, word_of
from simulation.journal import encode_entry, read_journal
from study.record.calls import TracePoint
from study.record.directory import JOURNAL_FILE
from study.record.read_back import RunRead

NS_PER_S: Final = 1_000_000_000
DAY_NS: Final = 86_400 * NS_PER_S
JSON: Final = "json"
SCHEMA: Final = "jsonschema"
MAGIC: Final = b"\x89MCAP"  # that every such file begins with


class McapCounts(NamedTuple):
    """What was written."""

    events: int
    samples: int


def write_mcap(read: RunRead, file: Path) -> McapCounts:
    """Write a run that was read; a run without its journal has the trains alone."""
    journal = read.directory / JOURNAL_FILE
    entries = read_journal(journal) if existing_file(journal) else []
    frame = read.tables.trajectory.sort("t_s")
    with writing_aside(file, MAGIC) as stream:
        writer = _Channels(stream)
        events = ((round(e.t_s * NS_PER_S), writer.of_event(e), encode_entry(e)) for e in entries)
        samples = (
            (round(row["t_s"] * NS_PER_S), writer.of_unit(row["unit"]), json.dumps(row).encode())
            for row in frame.iter_rows(named=True)
        )
        writer.write(merge(events, samples, key=lambda one: one[0]))
    return McapCounts(len(entries), frame.height)


class _Channels:
    """The file, with its channels as they come to be needed."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._writer = Writer(stream)
        self._writer.start(profile="", library="branchline")
        self._channels: dict[str, int] = {}
        self._sampled: int | None = None

    def of_event(self, entry: JournalEntry) -> int:
        """The channel of an event, by its word."""
        word = word_of(type(entry.event))
        topic = f"/journal/{word}"
        if topic not in self._channels:
            self._channels[topic] = self._channel(topic, self._schema(word, event_schema(EVENTS[word])))
        return self._channels[topic]

    def of_unit(self, unit: str) -> int:
        """The channel of a unit's samples."""
        topic = f"/units/{unit}"
        if topic not in self._channels:
            if self._sampled is None:
                self._sampled = self._schema(TracePoint.__name__, schema_of(TracePoint))
            self._channels[topic] = self._channel(topic, self._sampled)
        return self._channels[topic]

    def write(self, messages: Iterator[tuple[int, int, bytes]]) -> None:
        """All messages, in order of time: from midnight, or from the one before if the run begins before midnight."""
        ahead_ns = 0  # MCAP has no negative times
        for number, (since_ns, channel, data) in enumerate(messages):
            ahead_ns = max(ahead_ns, -(since_ns // DAY_NS) * DAY_NS)
            at_ns = since_ns + ahead_ns
            self._writer.add_message(channel, log_time=at_ns, publish_time=at_ns, sequence=number, data=data)
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves this one without types

    def _schema(self, name: str, schema: dict[str, Any]) -> int:
        return int(
            self._writer.register_schema(
                name=f"branchline.{name}", encoding=SCHEMA, data=json.dumps(schema).encode()
            )
        )

    def _channel(self, topic: str, schema: int) -> int:
        return int(self._writer.register_channel(topic=topic, message_encoding=JSON, schema_id=schema))


def event_schema(kind: EventType) -> dict[str, Any]:
    """JSON Schema of a line of the journal with this event: its own keys, time and author."""
    own = schema_of(kind)
    head = {"t": {"type": "number", "description": "s since midnight"}, "who": {"type": "string"}}
    return {**own, "properties": {**head, **own["properties"]}}


def schema_of(kind: type) -> dict[str, Any]:
    """JSON Schema of a type, itself an object, with what it names beside it: viewers want no reference at its top."""
    (schema,), parts = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
    own = parts.pop(kind.__name__) if "$ref" in schema else schema
    return own | ({"$defs": parts} if parts else {})
