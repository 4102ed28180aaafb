"""The simulator's side of parties that are processes: one `host.serve` each, over Zenoh on a Unix socket, or one
`host.taking_part` on another machine, over TLS.

A shell: it starts and ends processes and waits on sockets, with limits. What the parties decide depends only
on what they are asked, never on how long it took; what may be taken from them `host.lockstep` decides. The
processes also end by themselves when this one is gone.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

import zenoh

from host.lockstep import Asker, PartyAnswer, Tagged, of_certificate, of_run
from host.order_solver import HANGS_S
from host.over_tls import FAR, FarProcess, PartyInvitation, PowerDeed, ToldFar
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
    said_key,
    session_json5,
    time_key,
)
from host.process import DURABLE_FILE, Commission, PartyProcess, last_words
from host.store import NotCommissioned

if TYPE_CHECKING:  # only who has certificates needs what reads them
    from host.elsewhere import Elsewhere

START_LIMIT_S: Final = 30.0
JOIN_LIMIT_S: Final = 600.0  # people start parties on other machines
ASK_AGAIN_S: Final = 2.5
INBOX_TELEGRAMS: Final = 4096
_SESSION_EVENTS: Final = 1024
_START_POLL_S: Final = 0.005
_ARRIVAL_POLL_S: Final = 0.0005
_DEATH_LIMIT_S: Final = 2.0
_OWN_SESSION: Final = "1"


def answer_limit_s(spec: PartySpec) -> float:
    """After how long without an answer a party hangs, s; a block manager may itself wait for the solver of orders."""
    return ANSWER_LIMIT_S + (HANGS_S if spec.asks_solver else 0.0)


@dataclass(frozen=True, slots=True)
class _Wires:
    """An open session, what is heard on its radio plane, and who joins it."""

    session: zenoh.Session
    inbox: zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]
    joined: zenoh.LinkEventsListener[zenoh.handlers.Handler[zenoh.LinkEvent]]


@dataclass(slots=True)
class _Hosted:
    spec: PartySpec
    state: Path
    wires: _Wires
    querier: zenoh.Querier
    asker: Asker
    far: FarProcess | None = None  # where it is on another machine, whether it has power or not
    process: PartyProcess | FarProcess | None = None
    commission: Commission | None = None  # what people have entered, before its next boot

    @property
    def durable(self) -> Path:
        """The file of its durable state, if it is on this machine."""
        return self.state / DURABLE_FILE

    @property
    def blank(self) -> bool:
        """Whether people must commission it before its next boot."""
        lost = not self.durable.exists() if self.far is None else self.far.lost
        return lost and self.commission is None


class ZenohParties:
    """`host.parties.Parties` with a process per party. State is kept in `directory`, one folder a party, but of those
    `elsewhere`, which keep it themselves.

    Entering the context is the first commissioning of those that have none there.

    Raises PartyError if a party does not start within 30 s (join within 10 min) or does not answer within
    `answer_limit_s`, with what it last wrote, and ForeignError as soon as anybody else is heard.
    """

    def __init__(
        self, line_id: str, specs: Iterable[PartySpec], directory: Path, elsewhere: Elsewhere | None = None
    ) -> None:
        self._line_id = line_id
        self._specs = tuple(specs)
        self._directory = directory
        self._elsewhere = elsewhere
        self._hosted: dict[str, _Hosted] = {}
        self._sessions: dict[str, str | None] = {}  # with the name that its certificate must have
        self._endpoint = ""
        self._folder = ExitStack()
        self._wires: list[_Wires] = []

    @property
    def endpoint(self) -> str:
        """Where the parties connect to; empty before the context is entered."""
        return self._endpoint

    def __enter__(self) -> Self:
        try:
            self._open()
            for hosted in self._hosted.values():
                if hosted.far is None and hosted.blank:
                    hosted.commission = Commission(1)
                self._spawn(hosted)
            for hosted in self._hosted.values():
                if hosted.far is None:
                    self._wait_ready(hosted, START_LIMIT_S)
            self._wait_joined([hosted for hosted in self._hosted.values() if hosted.far is not None])
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self._say_it_is_over()
        finally:
            self._close()

    def advance(self, party_id: str, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Let a party act at `now_s`: its telegrams, then the question, then its answer and telegrams."""
        hosted = self._hosted[party_id]
        if hosted.process is None:
            raise PartyBug(f"party {party_id} is down")
        if not hosted.process.alive():
            raise self._ended(hosted, hosted.process)
        if hosted.far is not None:
            told = FAR.encode(ToldFar(told=told))
        return self._advance(hosted, hosted.process, now_s, telegrams, told)

    def _advance(
        self,
        hosted: _Hosted,
        process: PartyProcess | FarProcess,
        now_s: float,
        telegrams: Sequence[bytes],
        told: bytes,
    ) -> Advance:
        question, tagged = hosted.asker.ask(now_s, telegrams, told)
        if len(question) > PAYLOAD_BYTES_MAX:
            called = hosted.spec.party_id
            raise PartyBug(f"a question of {len(question)} bytes to {called} is too long for its link")
        try:
            for telegram in tagged:
                hosted.wires.session.put(
                    radio_key(self._line_id, hosted.spec.party_id),
                    telegram.data,
                    attachment=telegram.tag,
                    congestion_control=zenoh.CongestionControl.BLOCK,
                    express=True,
                )
        except zenoh.ZError as error:
            raise PartyError(f"the endpoint of the run is lost: {error}") from error
        answer = self._ask(hosted, question)
        if answer is None:
            if process.ended_within(_DEATH_LIMIT_S):
                raise self._ended(hosted, process)
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
        if hosted.blank:
            raise NotCommissioned(hosted.spec.called)
        if hosted.far is not None:
            hosted.far.restart(hosted.commission)
            hosted.process, hosted.commission = hosted.far, None
            return
        self.kill(party_id)
        self._spawn(hosted)
        self._wait_ready(hosted, START_LIMIT_S)

    def lose(self, party_id: str) -> None:
        """The file of its durable state is gone."""
        hosted = self._hosted[party_id]
        if hosted.far is not None:
            hosted.far.lose()
        else:
            hosted.durable.unlink(missing_ok=True)

    def commission(self, party_id: str, number: int, vital: bytes) -> None:
        """People put it into service again: its next process writes that down."""
        self._hosted[party_id].commission = Commission(number, vital)

    def _open(self) -> None:
        party_ids = [spec.party_id for spec in self._specs]
        far_ids = frozenset[str]() if self._elsewhere is None else self._elsewhere.chosen(party_ids)
        folder = self._folder.enter_context(private_folder())
        self._endpoint = endpoint_of(folder)
        near = self._wired(self._endpoint, session_json5("listen", self._endpoint, _OWN_SESSION))
        (folder / SOCKET_NAME).chmod(0o600)
        far = near
        if self._elsewhere is not None:
            config = self._elsewhere.session_json5(self._line_id, far_ids, _OWN_SESSION)
            far = self._wired(self._elsewhere.endpoint, config)
        for spec in self._specs:
            wires = far if spec.party_id in far_ids else near
            querier = wires.session.declare_querier(
                time_key(self._line_id, spec.party_id),
                # All, so that a stranger who also answers cannot keep the question from the party.
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=ASK_AGAIN_S,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
            state = self._directory / spec.party_id
            hosted = _Hosted(spec, state, wires, querier, Asker(spec.party_id, b""))
            if spec.party_id in far_ids:
                hosted.far = FarProcess(partial(self._tell, hosted))
            self._hosted[spec.party_id] = hosted

    def _wired(self, endpoint: str, config: str) -> _Wires:
        """A session that listens."""
        try:
            session = zenoh.open(zenoh.Config.from_json5(config))
        except zenoh.ZError as error:
            raise PartyError(f"no endpoint can be opened at {endpoint}: {error}") from error
        joined = session.info.declare_link_events_listener(
            zenoh.handlers.FifoChannel(_SESSION_EVENTS), history=True
        )
        inbox = session.declare_subscriber(
            said_key(self._line_id),
            zenoh.handlers.FifoChannel(INBOX_TELEGRAMS),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        self._wires.append(_Wires(session, inbox, joined))
        return self._wires[-1]

    def _spawn(self, hosted: _Hosted) -> None:
        secrets = new_secrets(hosted.spec.keys)
        hosted.asker = Asker(hosted.spec.party_id, secrets.plane_key)
        # Sessions of killed boots stay known: their end may be heard of after the next one's beginning.
        if hosted.far is not None and self._elsewhere is not None:
            self._sessions[secrets.session_id] = hosted.spec.party_id
            self._elsewhere.invite(PartyInvitation(hosted.spec, secrets.plane_key, secrets.session_id))
            hosted.process = hosted.far
            return
        self._sessions[secrets.session_id] = None
        hosted.process = PartyProcess(hosted.spec, secrets, hosted.state, self._endpoint, hosted.commission)
        hosted.commission = None

    def _tell(self, hosted: _Hosted, deed: ToldFar) -> None:
        """Tell a party's machine what to do with it."""
        if hosted.far is not None:
            self._advance(hosted, hosted.far, 0.0, [], FAR.encode(deed))

    def _wait_joined(self, far: Sequence[_Hosted]) -> None:
        """Until people have started those that are on other machines."""
        if self._elsewhere is None or not far:
            return
        names = ", ".join(hosted.spec.party_id for hosted in far)
        what = f"waiting at {self._elsewhere.endpoint} for {names}; what each needs is in {self._elsewhere.folder}"
        with self._elsewhere.waiting(what):
            for hosted in far:
                self._wait_ready(hosted, JOIN_LIMIT_S)
                self._elsewhere.uninvite(hosted.spec.party_id)

    def _say_it_is_over(self) -> None:
        for hosted in self._hosted.values():
            if hosted.far is not None:
                with suppress(PartyError):  # who has left already knows
                    hosted.far.tell(ToldFar(PowerDeed.LEAVE))

    def _wait_ready(self, hosted: _Hosted, limit_s: float) -> None:
        """Until the party answered and its telegram reached us: then both planes stand."""
        patience = Patience(limit_s, gap_s_max=2.0 * ASK_AGAIN_S)
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
        raise PartyError(self._complaint(hosted, f"was not ready within {limit_s:g} s"))

    def _ask(self, hosted: _Hosted, question: bytes) -> PartyAnswer | None:
        """The answer; None if nobody is there, or no longer. PartyError if the party failed or hangs.

        A party that is slow is asked the same again. If this process was stopped, its own limit may have run out over
        an answer that is there: such a time is not counted.
        """
        limit_s = answer_limit_s(hosted.spec)
        patience = Patience(limit_s, gap_s_max=2.0 * ASK_AGAIN_S)
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
                raise PartyError(self._complaint(hosted, f"hangs for {limit_s:g} s"))
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
        inbox = hosted.wires.inbox
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
        """Whoever joined must be a session that was given to a party, with its certificate."""
        for wires in self._wires:
            while (event := wires.joined.try_recv()) is not None:
                session_id, shown = str(event.link.zid), event.link.auth_identifier
                proven = "" if shown is None else f" with the certificate of {shown}"
                if not of_run(session_id, self._sessions):
                    raise ForeignError(f"a foreign session has joined the run: {session_id}{proven}")
                expected = self._sessions.get(session_id)
                if not of_certificate(shown, expected):
                    raise ForeignError(f"the session of {expected} has joined the run{proven}")

    def _complaint(self, hosted: _Hosted, what: str) -> str:
        words = last_words(hosted.state)
        return f"{hosted.spec.called} {what}" + (f"; it wrote: {words}" if words else "")

    def _ended(self, hosted: _Hosted, process: PartyProcess | FarProcess, when: str = "") -> PartyError:
        """That its process has ended, which nobody asked for, and how."""
        kind = PartyBug if process.at_fault else PartyError
        return kind(self._complaint(hosted, process.ending + when))

    def _close(self) -> None:
        """All processes end, even if one of them or the session gives trouble."""
        processes = [hosted.process for hosted in self._hosted.values() if hosted.process is not None]
        for hosted in self._hosted.values():
            hosted.process = None
        for process in processes:
            process.terminate()
        for process in processes:
            process.end()
        if self._elsewhere is not None:
            for party_id, hosted in self._hosted.items():
                if hosted.far is not None:
                    self._elsewhere.uninvite(party_id)
        with self._folder, ExitStack() as sessions:
            while self._wires:
                sessions.enter_context(self._wires.pop().session)
