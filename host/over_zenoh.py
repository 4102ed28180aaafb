"""The simulator's side of parties that are processes: one `host.serve` each, over Zenoh on a Unix socket.

A shell: it starts and ends processes and waits on sockets, with limits. What the parties decide depends only
on what they are asked, never on how long it took; what may be taken from them `host.lockstep` decides. The
processes also end by themselves when this one is gone.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import zenoh

from host.lockstep import Asker, PartyAnswer, Tagged, of_run
from host.parties import ForeignError, PartyBug, PartyError
from host.party import Advance, PartySpec
from host.patience import Patience
from host.planes import (
    ANSWER_LIMIT_S,
    PAYLOAD_BYTES_MAX,
    SOCKET_NAME,
    endpoint_of,
    new_secrets,
    private_folder,
    radio_key,
    session_json5,
    time_key,
)
from host.process import DURABLE_FILE, Commission, PartyProcess, last_words
from host.store import NotCommissioned

START_LIMIT_S: Final = 30.0
ASK_AGAIN_S: Final = 2.5
INBOX_TELEGRAMS: Final = 4096
_SESSION_EVENTS: Final = 1024
_START_POLL_S: Final = 0.005
_ARRIVAL_POLL_S: Final = 0.0005
_DEATH_LIMIT_S: Final = 2.0
_OWN_SESSION: Final = "1"


@dataclass(frozen=True, slots=True)
class _Wires:
    """The open session, what is heard on the radio plane, and who joins."""

    session: zenoh.Session
    inbox: zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]
    joined: zenoh.TransportEventsListener[zenoh.handlers.Handler[zenoh.TransportEvent]]


@dataclass(slots=True)
class _Hosted:
    spec: PartySpec
    state: Path
    querier: zenoh.Querier
    asker: Asker
    session_id: str = ""
    process: PartyProcess | None = None
    commission: Commission | None = None  # what people have entered, before its next boot

    @property
    def durable(self) -> Path:
        """The file of its durable state."""
        return self.state / DURABLE_FILE


class ZenohParties:
    """`host.parties.Parties` with a process per party. State is kept in `directory`, one folder a party.

    Entering the context is the first commissioning of those that have none there.

    Raises PartyError if a party does not start within 30 s or does not answer within 10 s, with what it last
    wrote, and ForeignError as soon as anybody else is heard.
    """

    def __init__(self, line_id: str, specs: Iterable[PartySpec], directory: Path) -> None:
        self._line_id = line_id
        self._specs = tuple(specs)
        self._directory = directory
        self._hosted: dict[str, _Hosted] = {}
        self._sessions: set[str] = set()
        self._endpoint = ""
        self._folder = ExitStack()
        self._open_wires: _Wires | None = None

    @property
    def endpoint(self) -> str:
        """Where the parties connect to; empty before the context is entered."""
        return self._endpoint

    def __enter__(self) -> Self:
        try:
            self._open()
            for hosted in self._hosted.values():
                if not hosted.durable.exists():
                    hosted.commission = Commission(1)
                self._spawn(hosted)
            for hosted in self._hosted.values():
                self._wait_ready(hosted)
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s`: its telegrams, then the question, then its answer and telegrams."""
        hosted = self._hosted[party_id]
        if hosted.process is None:
            raise PartyBug(f"party {party_id} is down")
        if not hosted.process.alive():
            raise self._ended(hosted, hosted.process)
        question, tagged = hosted.asker.ask(now_s, telegrams, told)
        if len(question) > PAYLOAD_BYTES_MAX:
            raise PartyBug(f"a question of {len(question)} bytes to {party_id} is too long for its link")
        session = self._wires.session
        try:
            for telegram in tagged:
                session.put(
                    radio_key(self._line_id, party_id),
                    telegram.data,
                    attachment=telegram.tag,
                    congestion_control=zenoh.CongestionControl.BLOCK,
                    express=True,
                )
        except zenoh.ZError as error:
            raise PartyError(f"the endpoint of the run is lost: {error}") from error
        answer = self._ask(hosted, question)
        if answer is None:
            if hosted.process.ended_within(_DEATH_LIMIT_S):
                raise self._ended(hosted, hosted.process)
            raise PartyError(self._complaint(hosted, "gave no answer"))
        done = hosted.asker.advance(answer, self._collect(hosted, answer.sent))
        self._look_for_strangers()
        return done

    def alive(self, party_id: str) -> bool:
        """Whether the party's process runs."""
        process = self._hosted[party_id].process
        return process is not None and process.alive()

    def kill(self, party_id: str) -> None:
        """Power cut: SIGKILL."""
        hosted = self._hosted[party_id]
        process, hosted.process = hosted.process, None
        if process is not None:
            process.kill()

    def restart(self, party_id: str) -> None:
        """Power back: a new process with new secrets on the same durable state.

        PartyError if it runs, NotCommissioned if its durable state is lost.
        """
        hosted = self._hosted[party_id]
        if self.alive(party_id):
            raise PartyError(f"party {party_id} runs already")
        if hosted.commission is None and not hosted.durable.exists():
            raise NotCommissioned(hosted.spec.called)
        self.kill(party_id)
        self._spawn(hosted)
        self._wait_ready(hosted)

    def lose(self, party_id: str) -> None:
        """The file of its durable state is gone."""
        self._hosted[party_id].durable.unlink(missing_ok=True)

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """People put it into service again: its next process writes that down."""
        self._hosted[party_id].commission = Commission(number, vital)

    def _open(self) -> None:
        folder = self._folder.enter_context(private_folder())
        self._endpoint = endpoint_of(folder)
        config = zenoh.Config.from_json5(session_json5("listen", self._endpoint, _OWN_SESSION))
        try:
            session = zenoh.open(config)
        except zenoh.ZError as error:
            raise PartyError(f"no endpoint can be opened at {self._endpoint}: {error}") from error
        (folder / SOCKET_NAME).chmod(0o600)
        joined = session.info.declare_transport_events_listener(
            zenoh.handlers.FifoChannel(_SESSION_EVENTS), history=True
        )
        inbox = session.declare_subscriber(
            radio_key(self._line_id, "*"),
            zenoh.handlers.FifoChannel(INBOX_TELEGRAMS),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        self._open_wires = _Wires(session, inbox, joined)
        for spec in self._specs:
            querier = session.declare_querier(
                time_key(self._line_id, spec.party_id),
                # All, so that a stranger who also answers cannot keep the question from the party.
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=ASK_AGAIN_S,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
            state = self._directory / spec.party_id
            self._hosted[spec.party_id] = _Hosted(spec, state, querier, Asker(spec.party_id, b""))

    def _spawn(self, hosted: _Hosted) -> None:
        secrets = new_secrets(hosted.spec.keys)
        hosted.asker = Asker(hosted.spec.party_id, secrets.plane_key)
        # Sessions of killed boots stay known: their end may be heard of after the next one's beginning.
        self._sessions.add(secrets.session_id)
        hosted.process = PartyProcess(hosted.spec, secrets, hosted.state, self._endpoint, hosted.commission)
        hosted.commission = None

    def _wait_ready(self, hosted: _Hosted) -> None:
        """Until the party answered and its telegram reached us: then both planes stand."""
        patience = Patience(START_LIMIT_S, gap_s_max=2.0 * ASK_AGAIN_S)
        while not patience.is_over():
            if hosted.process is not None and not hosted.process.alive():
                raise self._ended(hosted, hosted.process, " while it started")
            # Matching changes when the party's declaration arrives; asking before that finds nobody.
            if hosted.querier.matching_status:
                answer = self._ask(hosted, hosted.asker.ask_ready())
                if answer is not None:
                    hosted.asker.advance(answer, self._collect(hosted, answer.sent))
                    return
            self._look_for_strangers()
            time.sleep(_START_POLL_S)
        raise PartyError(self._complaint(hosted, f"was not ready within {START_LIMIT_S:g} s"))

    def _ask(self, hosted: _Hosted, question: bytes) -> PartyAnswer | None:
        """The answer; None if nobody is there, or no longer. PartyError if the party failed or hangs.

        A party that is slow is asked the same again. If this process was stopped, its own limit may have run out over
        an answer that is there: such a time is not counted.
        """
        patience = Patience(ANSWER_LIMIT_S, gap_s_max=2.0 * ASK_AGAIN_S)
        while True:
            try:
                reply = hosted.querier.get(payload=question).recv()
            except zenoh.ZError:  # the channel closed without a reply
                return None
            if (sample := reply.ok) is not None:
                break
            self._look_for_strangers()
            # Zenoh's own word that time is up names the session asked, but nothing in it that answers.
            if reply.replier_id is not None and reply.replier_id.eid != 0:
                text = "" if reply.err is None else reply.err.payload.to_string()
                raise ForeignError(f"a foreign reply to the question to {hosted.spec.party_id}: {text}")
            if patience.is_over():
                raise PartyError(self._complaint(hosted, f"hangs for {ANSWER_LIMIT_S:g} s"))
        try:
            answer = hosted.asker.answer(sample.payload.to_bytes())
        except ForeignError:
            self._look_for_strangers()
            raise
        if answer.failed:
            kind = PartyBug if answer.bug else PartyError
            raise kind(self._complaint(hosted, f"failed: {answer.failed}"))
        return answer

    def _collect(self, hosted: _Hosted, expected: int) -> list[Tagged]:
        """All telegrams that are there: the party's came before its answer, on the same link."""
        heard: list[Tagged] = []
        inbox = self._wires.inbox
        patience = Patience(ANSWER_LIMIT_S)
        while True:
            sample = inbox.try_recv()
            if sample is not None:
                tag = b"" if sample.attachment is None else sample.attachment.to_bytes()
                destination = str(sample.key_expr).rpartition("/")[2]
                heard.append(Tagged(destination, sample.payload.to_bytes(), tag))
            elif len(heard) >= expected:
                return heard
            elif patience.is_over():
                what = f"sent {expected} telegrams, {len(heard)} came"
                raise PartyError(self._complaint(hosted, what))
            else:
                time.sleep(_ARRIVAL_POLL_S)

    def _look_for_strangers(self) -> None:
        """Whoever joined must be a session that was given to a party."""
        while (event := self._wires.joined.try_recv()) is not None:
            session_id = str(event.transport.zid)
            if not of_run(session_id, self._sessions):
                raise ForeignError(f"a foreign session has joined the run: {session_id}")

    def _complaint(self, hosted: _Hosted, what: str) -> str:
        words = last_words(hosted.state)
        return f"{hosted.spec.called} {what}" + (f"; it wrote: {words}" if words else "")

    def _ended(self, hosted: _Hosted, process: PartyProcess, when: str = "") -> PartyError:
        """That its process has ended, which nobody asked for, and how."""
        kind = PartyBug if process.at_fault else PartyError
        return kind(self._complaint(hosted, process.ending + when))

    @property
    def _wires(self) -> _Wires:
        if self._open_wires is None:
            raise PartyError("the parties are not there: use them as a context manager")
        return self._open_wires

    def _close(self) -> None:
        """All processes end, even if one of them or the session gives trouble."""
        processes = [hosted.process for hosted in self._hosted.values() if hosted.process is not None]
        for hosted in self._hosted.values():
            hosted.process = None
        for process in processes:
            process.terminate()
        for process in processes:
            process.end()
        wires, self._open_wires = self._open_wires, None
        try:
            if wires is not None:
                wires.session.close()  # type: ignore[no-untyped-call, unused-ignore]
        finally:
            self._folder.close()
