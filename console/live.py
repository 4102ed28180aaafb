"""The desk in a thread of its own, by the clock on the wall: whoever asks waits for nothing but an answer.

The simulation never waits for a page. It leaves the present where pages take it from, and what they ask for comes by a
queue that has an end. SUMO and the compiled code live in this thread alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from queue import Empty, Full, Queue
from threading import Event, Thread
from typing import Final

from console.desk import Desk
from console.protocol import DeskAnswer, Request, Welcome
from console.replay import Replay
from console.seats import Seat
from console.session import Session
from console.shown import DeskMoment
from scenario.scenario import Scenario
from study.record.read_back import RunRead
from study.runner.collector import collecting_rarely

UPDATES_EVERY_S: Final = 0.095  # a little under what is wanted, ten a second
WAITING_MAX: Final = 256  # requests

Take = Callable[[DeskAnswer], None]


@dataclass(frozen=True, slots=True)
class _QueuedRequest:
    seat: Seat
    request: Request
    take: Take
    unit: str


@dataclass(frozen=True, slots=True)
class _Looked:
    """Somebody looks from another cab."""


_LOOKED: Final = _Looked()


class LiveDesk:
    """A desk that runs, of a scenario, or of a run that is looked at again.

    `changed` is called from its thread when there is a new `moment`.
    """

    def __init__(self, what: Scenario | RunRead, changed: Callable[[], None]) -> None:
        self._what: Final = what
        self._changed: Final = changed
        self._queue: Queue[_QueuedRequest | _Looked | None] = Queue(WAITING_MAX)
        self._thread = Thread(target=self._run, name="desk")
        self._ready = Event()
        self._welcomes: dict[Seat, Welcome] = {}
        self._moment: DeskMoment | None = None
        self._cabs: frozenset[str] = frozenset()
        self.is_over = False
        self.error: BaseException | None = None

    def start(self) -> None:
        """Begin, and come back when there is a line to look at. Raises what keeps it from beginning."""
        self._thread.start()
        self._ready.wait()
        if self.error is not None:
            raise self.error

    @property
    def thread_id(self) -> int | None:
        """Of the thread in which the run is, as the system counts it."""
        return self._thread.native_id

    def stop(self) -> None:
        """End the run where it is."""
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()

    @property
    def moment(self) -> DeskMoment:
        """The present. RuntimeError before it has begun."""
        if self._moment is None:
            raise RuntimeError("the desk has not begun")
        return self._moment

    def welcome(self, seat: Seat) -> Welcome:
        """What a seat is told once."""
        return self._welcomes[seat]

    def look_from(self, units: frozenset[str]) -> None:
        """From now on these units' cabs are looked at."""
        if units != self._cabs:
            self._cabs = units
            with suppress(Full):  # whoever is asked for something shows the cabs too
                self._queue.put_nowait(_LOOKED)

    def ask(self, seat: Seat, request: Request, take: Take, unit: str = "") -> None:
        """Ask for something; `take` is called with the answer, from the desk's thread or, where it is busy, at once."""
        try:
            self._queue.put_nowait(_QueuedRequest(seat, request, take, unit))
        except Full:
            take(DeskAnswer(number=request.number, good=False, why="the desk is busy: ask again"))
        if self.is_over:
            self._refuse_all()

    def _refuse_all(self) -> None:
        """Nobody is left who waits for an answer of a run that is no more."""
        with suppress(Empty):
            while True:
                asked = self._queue.get_nowait()
                if isinstance(asked, _QueuedRequest):
                    _refuse(asked)

    def _run(self) -> None:
        try:
            with collecting_rarely(), _desk_of(self._what) as desk:
                self._welcomes = {seat: desk.welcome(seat) for seat in Seat}
                self._moment = desk.moment
                self._ready.set()
                self._turn_by_turn(desk)
        except BaseException as error:
            self.error = error
        finally:
            self.is_over = True
            self._refuse_all()
            self._ready.set()
            self._changed()

    def _turn_by_turn(self, desk: Desk | Replay) -> None:
        shown_s = -UPDATES_EVERY_S
        stale = True
        while True:
            moved, wait_s = desk.turn(time.monotonic())
            stale = stale or moved
            now_s = time.monotonic()
            if stale and now_s - shown_s >= UPDATES_EVERY_S:
                desk.cabs = self._cabs
                self._moment, shown_s = desk.moment, now_s
                stale = False
                self._changed()
            until_s = [
                w for w in (wait_s, shown_s + UPDATES_EVERY_S - now_s if stale else None) if w is not None
            ]
            try:
                asked = self._queue.get(timeout=max(min(until_s), 0.0)) if until_s else self._queue.get()
            except Empty:
                continue
            if asked is None:
                return
            stale = True
            if isinstance(asked, _Looked):
                continue
            try:
                answer = desk.ask(asked.seat, asked.request, time.monotonic(), asked.unit)
            except BaseException:
                _refuse(asked)
                raise
            asked.take(answer)


def _refuse(asked: _QueuedRequest) -> None:
    why = "the run is no more: it was ended here, or by an error"
    asked.take(DeskAnswer(number=asked.request.number, good=False, why=why))


@contextmanager
def _desk_of(what: Scenario | RunRead) -> Generator[Desk | Replay]:
    """The desk of a run that begins, or of one that has ended."""
    if isinstance(what, RunRead):
        yield Replay(what)
        return
    with Session(what) as session:
        yield Desk(session)
