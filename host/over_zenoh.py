"""The simulator's side of a fleet of processes: one `host.serve` per device, over Zenoh on the loopback.

A shell: it starts and ends processes and waits on sockets, with limits. What the devices decide depends
only on what they are asked, never on how long it took. The processes also end by themselves when this one
is gone.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Final, Self

import msgspec
import zenoh

from host.devices import Advance, DeviceSpec, FleetError
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
from wayside.said import Input

START_LIMIT_S: Final = 30.0
_PORT_TRIES: Final = 5
_LISTEN_POLL_S: Final = 0.01
_ALIVE_POLL_S: Final = 0.5
_END_LIMIT_S: Final = 2.0
_LOG_TAIL_BYTES: Final = 2000


@dataclass(slots=True)
class _Device:
    spec: DeviceSpec
    state: Path
    querier: zenoh.Querier
    process: subprocess.Popen[bytes] | None = None


class ZenohFleet:
    """`host.devices.Fleet` with a process per device. State is kept in `directory`, one folder a device.

    Raises FleetError if a device does not start within 30 s or does not answer within 10 s, with what it
    last wrote.
    """

    def __init__(self, line_id: str, specs: Iterable[DeviceSpec], directory: Path) -> None:
        self._line_id = line_id
        self._specs = tuple(specs)
        self._directory = directory
        self._devices: dict[str, _Device] = {}
        self._endpoint = ""
        self._session: zenoh.Session | None = None
        self._round = READY_ROUND
        self._inbox: SimpleQueue[tuple[bytes, str, bytes]] = SimpleQueue()

    def __enter__(self) -> Self:
        try:
            self._open()
            for device in self._devices.values():
                self._spawn(device)
            for device in self._devices.values():
                self._wait_ready(device)
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()

    def advance(
        self, device_id: str, now_s: float, telegrams: Sequence[bytes], inputs: Sequence[Input] = ()
    ) -> Advance:
        """Let a device act at `now_s`: its telegrams, then the question, then its answer and telegrams."""
        device = self._devices[device_id]
        if not self.alive(device_id):
            raise FleetError(f"device {device_id} is down")
        self._round += 1
        tag, session = round_tag(self._round), self._running()
        for data in telegrams:
            session.put(
                radio_key(self._line_id, device_id),
                data,
                attachment=tag,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
        answer = self._ask(device, Question(self._round, now_s, len(telegrams), tuple(inputs)))
        if answer is None or answer.round != self._round:
            raise FleetError(self._complaint(device, "gave no answer"))
        return Advance(
            self._collect(device, tag, answer.sent), answer.outputs, answer.wake_at_s, answer.notes
        )

    def alive(self, device_id: str) -> bool:
        """Whether the device's process runs."""
        process = self._devices[device_id].process
        return process is not None and process.poll() is None

    def kill(self, device_id: str) -> None:
        """Power cut: SIGKILL."""
        self._end(self._devices[device_id], at_once=True)

    def restart(self, device_id: str) -> None:
        """Power back: a new process on the same durable state. FleetError if it runs."""
        if self.alive(device_id):
            raise FleetError(f"device {device_id} runs already")
        self._end(self._devices[device_id], at_once=True)
        self._spawn(self._devices[device_id])
        self._wait_ready(self._devices[device_id])

    def _open(self) -> None:
        for attempt in range(_PORT_TRIES):
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", 0))
                port = probe.getsockname()[1]
            self._endpoint = f"tcp/127.0.0.1:{port}"
            try:
                self._session = zenoh.open(zenoh.Config.from_json5(session_json5("listen", self._endpoint)))
                break
            except zenoh.ZError as error:
                # Another program took the port between the probe and the opening.
                if attempt == _PORT_TRIES - 1:
                    raise FleetError(f"no free port on the loopback: {error}") from error
        session = self._running()
        session.declare_subscriber(
            radio_key(self._line_id, "*"), self._take, allowed_origin=zenoh.Locality.REMOTE
        )
        for spec in self._specs:
            querier = session.declare_querier(
                time_key(self._line_id, spec.device_id),
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=ANSWER_LIMIT_S,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
            state = self._directory / spec.device_id
            state.mkdir(parents=True, exist_ok=True)
            self._devices[spec.device_id] = _Device(spec, state, querier)

    def _take(self, sample: zenoh.Sample) -> None:
        attachment = sample.attachment
        tag = b"" if attachment is None else attachment.to_bytes()
        destination = str(sample.key_expr).rpartition("/")[2]
        self._inbox.put((tag, destination, sample.payload.to_bytes()))

    def _spawn(self, device: _Device) -> None:
        spec, state = device.spec, device.state
        (state / "config.json").write_bytes(spec.config_json)
        key_file = state / "keys.json"
        key_file.touch(mode=0o600)
        key_file.write_bytes(msgspec.json.encode(spec.keys))
        command = [sys.executable, "-m", "host.serve", spec.role.value]
        command += ["--line", self._line_id, "--device", spec.device_id, "--state", str(state)]
        command += ["--key-file", str(key_file), "--connect", self._endpoint]
        with (state / "stderr.log").open("ab") as log:
            device.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=log
            )

    def _wait_ready(self, device: _Device) -> None:
        """Until the device answered, and its telegrams reach us: then both planes stand."""
        limit_s = time.monotonic() + START_LIMIT_S
        tag = round_tag(READY_ROUND)
        while time.monotonic() < limit_s:
            if not self.alive(device.spec.device_id):
                raise FleetError(self._complaint(device, "ended while it started"))
            # Matching changes when the device's declaration arrives; asking before that finds nobody.
            if not device.querier.matching_status:
                time.sleep(_LISTEN_POLL_S)
                continue
            if self._ask(device, Question(READY_ROUND, 0.0, 0)) is not None:
                try:
                    while self._inbox.get(timeout=_ALIVE_POLL_S)[0] != tag:
                        pass
                except Empty:
                    continue
                return
        raise FleetError(self._complaint(device, f"was not ready within {START_LIMIT_S:g} s"))

    def _ask(self, device: _Device, question: Question) -> Answer | None:
        """The answer; None if there was nobody to answer. FleetError if the device failed, died or hangs."""
        replies: SimpleQueue[zenoh.Reply | None] = SimpleQueue()
        handler = zenoh.handlers.Callback(replies.put, lambda: replies.put(None))
        device.querier.get(handler, payload=msgspec.msgpack.encode(question))
        limit_s = time.monotonic() + ANSWER_LIMIT_S
        while True:
            try:
                reply = replies.get(timeout=_ALIVE_POLL_S)
            except Empty:
                if not self.alive(device.spec.device_id):
                    raise FleetError(self._complaint(device, "died")) from None
                if time.monotonic() > limit_s:
                    raise FleetError(self._complaint(device, f"hangs for {ANSWER_LIMIT_S:g} s")) from None
                continue
            if reply is None:
                return None
            if (sample := reply.ok) is not None:
                return msgspec.msgpack.decode(sample.payload.to_bytes(), type=Answer)
            error = reply.err
            text = "" if error is None else error.payload.to_string()
            raise FleetError(self._complaint(device, f"failed: {text}"))

    def _collect(self, device: _Device, tag: bytes, expected: int) -> tuple[tuple[str, bytes], ...]:
        telegrams: list[tuple[str, bytes]] = []
        while len(telegrams) < expected:
            try:
                found, destination, data = self._inbox.get(timeout=ANSWER_LIMIT_S)
            except Empty:
                what = f"sent {expected} telegrams, {len(telegrams)} came"
                raise FleetError(self._complaint(device, what)) from None
            if found == tag:
                telegrams.append((destination, data))
        return tuple(telegrams)

    def _complaint(self, device: _Device, what: str) -> str:
        log = device.state / "stderr.log"
        tail = log.read_bytes()[-_LOG_TAIL_BYTES:].decode(errors="replace").strip() if log.exists() else ""
        return f"device {device.spec.device_id} {what}" + (f"; it wrote: {tail}" if tail else "")

    def _running(self) -> zenoh.Session:
        if self._session is None:
            raise FleetError("the fleet is not open: use it as a context manager")
        return self._session

    def _end(self, device: _Device, *, at_once: bool) -> None:
        process, device.process = device.process, None
        if process is None:
            return
        if at_once:
            process.kill()
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(_END_LIMIT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _close(self) -> None:
        """All processes end, even if one of them or the session gives trouble."""
        for device in self._devices.values():
            if device.process is not None:
                device.process.terminate()
        for device in self._devices.values():
            self._end(device, at_once=False)
        session, self._session = self._session, None
        if session is not None:
            session.close()  # type: ignore[no-untyped-call, unused-ignore]
