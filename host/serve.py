"""The process of one party over Zenoh: `python -P -m host.serve block-manager|point-terminal ...`.

It acts only when asked on the time plane (see `host.lockstep`), so no clock is read here but to give up waiting.
It ends with its parent (end of stdin, or another parent) and on SIGTERM, at any moment: the durable state is
always whole. SIGINT and SIGHUP are the parent's business.
"""

from __future__ import annotations

import argparse
import logging
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import msgspec
import zenoh

from host.boot import boot
from host.lockstep import Answerer, Question, Tagged
from host.parties import ForeignError
from host.party import PartySpec, Role
from host.patience import Patience
from host.planes import (
    ANSWER_LIMIT_S,
    PAYLOAD_BYTES_MAX,
    Secrets,
    radio_key,
    said_key,
    session_json5,
    time_key,
)
from host.process import CONFIG_FILE, DURABLE_FILE, WANTING_CODE
from host.store import FileStore, commission
from network.errors import InputError, is_want_of_resources

INBOX_TELEGRAMS: Final = 4096
SECRETS_READ_BYTES: Final = 65_536
_PARENT_CHECK_S: Final = 1.0
_ARRIVAL_POLL_S: Final = 0.0005
_FAILURES: Final = (InputError, ForeignError, TimeoutError, ValueError, KeyError, OSError)
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


class PartyServer:
    """One party on the two planes."""

    def __init__(self, session: zenoh.Session, answerer: Answerer, line_id: str, party_id: str) -> None:
        self._session = session
        self._answerer = answerer
        self._line_id = line_id
        self._party_id = party_id
        self._time_key = time_key(line_id, party_id)
        # The subscriber is declared before the queryable: who finds the second can send to the first.
        self._inbox = session.declare_subscriber(
            radio_key(line_id, party_id), zenoh.handlers.FifoChannel(INBOX_TELEGRAMS)
        )
        self._questions = session.declare_queryable(self._time_key)
        self._asked, self._answered = b"", b""  # the last question as it came, and what was said to it

    def run(self, over: Callable[[], bool] = lambda: False) -> None:
        """Answer questions until the process ends, or one was the last."""
        for query in self._questions:
            with query:
                data = b"" if query.payload is None else query.payload.to_bytes()
                if data and data == self._asked:  # the simulator slept over the answer
                    query.reply(self._time_key, self._answered)
                    continue
                try:
                    question = self._answerer.question(data)
                except ForeignError as error:
                    _log.exception("not our question")
                    query.reply_err(str(error))
                    continue
                self._asked, self._answered = data, self._answer(question)
                query.reply(self._time_key, self._answered)
            if over():
                return

    def _answer(self, question: Question) -> bytes:
        try:
            sealed, telegrams = self._answerer.answer(question, self._collect(question.telegrams))
            if len(sealed) > PAYLOAD_BYTES_MAX:
                raise ValueError(f"an answer of {len(sealed)} bytes is too long for the link")
        except _FAILURES as error:
            _log.exception("question failed")
            bug = not (is_want_of_resources(error) or isinstance(error, ForeignError | TimeoutError))
            return self._answerer.failure(question, f"{type(error).__name__}: {error}", bug=bug)
        for telegram in telegrams:
            self._session.put(
                said_key(self._line_id, self._party_id, telegram.destination),
                telegram.data,
                attachment=telegram.tag,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
        return sealed

    def _collect(self, expected: int) -> list[Tagged]:
        """All telegrams that are there: those of the question came before it, on the same link."""
        heard: list[Tagged] = []
        patience = Patience(ANSWER_LIMIT_S / 2)
        while True:
            sample = self._inbox.try_recv()
            if sample is not None:
                tag = b"" if sample.attachment is None else sample.attachment.to_bytes()
                heard.append(Tagged(self._party_id, sample.payload.to_bytes(), tag))
            elif len(heard) >= expected:
                return heard
            elif patience.is_over():
                raise TimeoutError(f"{len(heard)} of {expected} telegrams came")
            else:
                time.sleep(_ARRIVAL_POLL_S)


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -P -m host.serve", description="Host one party over Zenoh, by secrets from stdin."
    )
    parser.add_argument("role", choices=[role.value for role in Role])
    parser.add_argument("--line", required=True, help="id of the line")
    parser.add_argument("--party", required=True, help="id of the party")
    parser.add_argument(
        "--state", required=True, type=Path, help="directory with config.json and durable state"
    )
    parser.add_argument("--connect", required=True, help="endpoint of the simulator, unixsock-stream/<path>")
    parser.add_argument(
        "--commission", type=int, help="how often people have put it into service, this time included"
    )
    parser.add_argument("--vital", type=bytes.fromhex, default=b"", help="what they have it remember, hex")
    return parser.parse_args(arguments)


def _secrets() -> Secrets:
    """What this boot is given in secret: the first line of stdin, in JSON. The parent says no more there."""
    line = b""
    while not line.endswith(b"\n") and (more := os.read(sys.stdin.fileno(), SECRETS_READ_BYTES)):
        line += more
    try:
        return msgspec.json.decode(line, type=Secrets)
    except msgspec.MsgspecError as error:
        raise InputError("stdin", "", None, f"the secrets of a party, a line of JSON ({error})") from None


def _answerer(options: argparse.Namespace, secrets: Secrets) -> Answerer:
    file = options.state / CONFIG_FILE
    try:
        config = file.read_bytes()
    except OSError as error:
        raise InputError(str(file), "", None, f"a readable file ({error.strerror})") from None
    spec = PartySpec(options.line, options.party, Role(options.role), config, secrets.keys)
    store = FileStore(options.state / DURABLE_FILE)
    if options.commission is not None:
        commission(store, options.commission, options.vital)
    party = boot(spec, store, str(file))
    return Answerer(options.party, secrets.plane_key, party)


def main(arguments: Sequence[str] | None = None) -> int:
    """Host one party until the parent ends. 2: bad input; 3: the machine lacks something, or the endpoint is gone."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    options = _arguments(arguments)
    try:
        secrets = _secrets()
        answerer = _answerer(options, secrets)
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    except OSError as error:
        if not is_want_of_resources(error):
            raise
        sys.stderr.write(f"{error}\n")
        return WANTING_CODE
    _end_with_parent()
    config = zenoh.Config.from_json5(session_json5("connect", options.connect, secrets.session_id))
    try:
        session = zenoh.open(config)
    except zenoh.ZError as error:
        sys.stderr.write(f"{options.connect} cannot be reached: {error}\n")
        return WANTING_CODE
    with session:
        PartyServer(session, answerer, options.line, options.party).run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
