"""A desk served beside the work of the caller: for tests, pictures and the measurement of what it costs."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Thread
from typing import Final

import uvicorn

from console.access import LOOPBACK, on_loopback
from console.live import LiveDesk
from console.protocol import DeskAnswer, Request, RunTo
from console.seats import Seat
from console.server import SOCKET_PATH, DeskServer, listening_on
from scenario.scenario import Scenario
from study.record.read_back import RunRead

LONGEST_S: Final = 3600.0


@dataclass(frozen=True, slots=True)
class ServedDesk:
    """A desk, the thread of its server, and the port on this machine."""

    live: LiveDesk
    thread: Thread
    port: int
    changed: Event = field(repr=False)

    @property
    def page(self) -> str:
        """Address of its pages."""
        return f"http://{LOOPBACK}:{self.port}/"

    @property
    def socket(self) -> str:
        """Address of its messages."""
        return f"ws://{LOOPBACK}:{self.port}{SOCKET_PATH}"

    def ask(self, request: Request) -> DeskAnswer:
        """Ask as the instructor; its answer. TimeoutError after an hour."""
        answers: list[DeskAnswer] = []
        answered = Event()

        def take(answer: DeskAnswer) -> None:
            answers.append(answer)
            answered.set()

        self.live.ask(Seat.INSTRUCTOR, request, take)
        if not answered.wait(LONGEST_S):
            raise TimeoutError(f"no answer to {request}")
        return answers[0]

    def run_to(self, time_s: float) -> None:
        """Run to a time, or to the end where that comes first. TimeoutError if an hour brings nothing new."""
        self.ask(RunTo(time_s=time_s))
        while not self._is_at(time_s):
            self.changed.clear()
            if not self._is_at(time_s) and not self.changed.wait(LONGEST_S):
                raise TimeoutError(f"the desk is not at {time_s} s")

    def _is_at(self, time_s: float) -> bool:
        known = self.live.moment.known
        return known.time_s >= time_s or bool(known.ended)


@contextmanager
def served(what: Scenario | RunRead, beside: RunRead | None = None) -> Generator[ServedDesk]:
    """A desk of a run that begins or has ended, on any free port, and of one that has, beside it. Raises what ended
    a thread of theirs.
    """
    changed = Event()
    with listening_on(LOOPBACK, 0) as bound:
        port = bound.getsockname()[1]
        server = DeskServer(on_loopback(port))

        def note() -> None:
            server.changed()
            changed.set()

        lives = [LiveDesk(one, note) for one in (what, beside) if one is not None]
        for live in lives:
            live.start()
        server.desk, *others = lives
        server.beside = others[0] if others else None
        web = uvicorn.Server(uvicorn.Config(server.app, log_level="error", ws="websockets-sansio"))
        thread = Thread(target=web.run, kwargs={"sockets": [bound]})
        thread.start()
        try:
            yield ServedDesk(lives[0], thread, port, changed)
        finally:
            web.should_exit = True
            thread.join()
            for live in lives:
                live.stop()
    for live in lives:
        if live.error is not None:
            raise live.error
