"""The process of one wayside device over Zenoh: `python -m host.serve block-manager|point-terminal ...`.

It acts only when asked on the time plane (see `host.planes`), so no clock is read here. It ends with its
parent (end of stdin, or another parent) and on SIGTERM, at any moment: the durable state is always whole.
SIGINT is the parent's business.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Final

import msgspec
import zenoh

from host.device import DeviceHost
from host.devices import Role
from host.planes import (
    ANSWER_LIMIT_S,
    READY_ROUND,
    Answer,
    Question,
    radio_key,
    round_tag,
    session_json5,
    time_key,
)
from host.store import FileStore
from network.errors import InputError
from radio.keys import KeyRing
from wayside.config import ManagerConfig, decode_config

CONFIG_FILE: Final = "config.json"
DURABLE_FILE: Final = "durable"
_PARENT_CHECK_S: Final = 1.0
_log = logging.getLogger("host.serve")


def _end_with_parent() -> None:
    """Leave at once when stdin ends or the parent changes; a daemon thread waits for it."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            readable, _, _ = select.select([sys.stdin], [], [], _PARENT_CHECK_S)
            if readable and not os.read(sys.stdin.fileno(), 4096):
                break
        os._exit(0)

    threading.Thread(target=watch, daemon=True).start()


class _Server:
    """One device on the two planes."""

    def __init__(self, session: zenoh.Session, host: DeviceHost, line_id: str, device_id: str) -> None:
        self._session = session
        self._host = host
        self._line_id = line_id
        self._time_key = time_key(line_id, device_id)
        self._last_round = READY_ROUND
        self._inbox: SimpleQueue[tuple[bytes, bytes]] = SimpleQueue()
        # The subscriber is declared before the queryable: who finds the second can send to the first.
        self._subscriber = session.declare_subscriber(radio_key(line_id, device_id), self._take)
        self._queries = session.declare_queryable(self._time_key)

    def _take(self, sample: zenoh.Sample) -> None:
        attachment = sample.attachment
        self._inbox.put((b"" if attachment is None else attachment.to_bytes(), sample.payload.to_bytes()))

    def run(self) -> None:
        """Answer questions until the process ends."""
        for query in self._queries:
            with query:
                try:
                    payload = query.payload
                    question = msgspec.msgpack.decode(
                        b"" if payload is None else payload.to_bytes(), type=Question
                    )
                    answer = self._answer(question)
                except (
                    msgspec.MsgspecError,
                    InputError,
                    TimeoutError,
                    ValueError,
                    KeyError,
                    OSError,
                ) as error:
                    _log.exception("question failed")
                    query.reply_err(f"{type(error).__name__}: {error}")
                else:
                    query.reply(self._time_key, msgspec.msgpack.encode(answer))

    def _answer(self, question: Question) -> Answer:
        if question.round == READY_ROUND:
            self._put("ready", READY_ROUND, b"")
            return Answer(READY_ROUND, 1)
        if question.round <= self._last_round:
            raise ValueError(f"round {question.round} comes after {self._last_round}")
        self._last_round = question.round
        telegrams = self._collect(question.round, question.telegrams)
        advance = self._host.advance(question.now_s, telegrams, question.inputs)
        for destination, data in advance.telegrams:
            self._put(destination, question.round, data)
        return Answer(
            question.round, len(advance.telegrams), advance.wake_at_s, advance.outputs, advance.notes
        )

    def _collect(self, number: int, expected: int) -> list[bytes]:
        tag, telegrams = round_tag(number), list[bytes]()
        while len(telegrams) < expected:
            try:
                found, data = self._inbox.get(timeout=ANSWER_LIMIT_S / 2)
            except Empty:
                raise TimeoutError(f"{len(telegrams)} of {expected} telegrams came") from None
            if found == tag:
                telegrams.append(data)
        return telegrams

    def _put(self, destination: str, number: int, data: bytes) -> None:
        self._session.put(
            radio_key(self._line_id, destination),
            data,
            attachment=round_tag(number),
            congestion_control=zenoh.CongestionControl.BLOCK,
            express=True,
        )


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m host.serve", description="Host one wayside device over Zenoh."
    )
    parser.add_argument("role", choices=[role.value for role in Role])
    parser.add_argument("--line", required=True, help="id of the line")
    parser.add_argument("--device", required=True, help="id of the device")
    parser.add_argument(
        "--state", required=True, type=Path, help="directory with config.json and durable state"
    )
    parser.add_argument("--key-file", required=True, type=Path, help="the device's keys, JSON")
    parser.add_argument("--connect", required=True, help="endpoint of the simulator, e.g. tcp/127.0.0.1:7447")
    return parser.parse_args(arguments)


def _host(options: argparse.Namespace) -> DeviceHost:
    file = options.state / CONFIG_FILE
    try:
        config = decode_config(file.read_bytes(), str(file))
        keys = msgspec.json.decode(options.key_file.read_bytes(), type=KeyRing)
    except OSError as error:
        raise InputError(str(error.filename), "", None, f"a readable file ({error.strerror})") from None
    except msgspec.MsgspecError as error:
        raise InputError(str(options.key_file), "", None, f"the keys of a device ({error})") from None
    role = Role.BLOCK_MANAGER if isinstance(config, ManagerConfig) else Role.POINT_TERMINAL
    given = (options.role, options.line, options.device)
    if given != (role.value, config.line_id, config.device_id):
        expected = f"{role.value} {config.device_id} of line {config.line_id}, as on the command line"
        raise InputError(str(file), "device", " ".join(given), expected)
    return DeviceHost(config, keys, FileStore(options.state / DURABLE_FILE))


def main(arguments: Sequence[str] | None = None) -> int:
    """Host one device until the parent ends. 2: bad input."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    options = _arguments(arguments)
    try:
        host = _host(options)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    _end_with_parent()
    with zenoh.open(zenoh.Config.from_json5(session_json5("connect", options.connect))) as session:
        _Server(session, host, options.line, options.device).run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
