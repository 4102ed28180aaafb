"""The desk's pages and its WebSocket: who connects takes a seat, asks, and is sent the present.

A connection that does not take what it is sent holds up itself alone: it is sent the present when it has taken what
came before, and what lay between is not kept for it.
"""

from __future__ import annotations

import asyncio
import socket
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from importlib.resources import files
from typing import Final, Protocol

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request as PageRequest
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from console import access
from console.access import REFUSED_MAX, SOCKETS_MAX, AccessRules, Allowance, Refusal
from console.library import LibraryRequest, library
from console.protocol import (
    MESSAGE_BYTES_MAX,
    VERSION,
    DeskAnswer,
    Request,
    Welcome,
    encoded,
    hello_of,
    number_of,
    request_of,
)
from console.seats import Seat
from console.shown import DeskMoment, SentSoFar, is_behind, state_for
from network.errors import COMMAND_LINE, InputError
from study.report.face import FAMILY, japanese_font
from study.wording.catalogue import phrases_of

SOCKET_PATH: Final = "/desk"
BESIDE_PATH: Final = "/beside"  # of the other run, where two are looked at side by side
WORDS_IN: Final = ("desk", "act", "rule", "party", "ending")  # contexts of the catalogue
REFUSED_CODE, FULL_CODE, GONE_CODE = 1008, 1013, 1012
HEADERS: Final = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
TYPES: Final = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".json": "application/json",
}


class DeskDoor(Protocol):
    """What the server needs of a desk."""

    @property
    def moment(self) -> DeskMoment:
        """The present."""
        ...

    @property
    def is_over(self) -> bool:
        """Whether its run was ended here, or by an error: it answers no more."""
        ...

    def welcome(self, seat: Seat) -> Welcome:
        """What a seat is told once."""
        ...

    def look_from(self, units: frozenset[str]) -> None:
        """From now on these units' cabs are looked at."""
        ...

    def ask(self, seat: Seat, request: Request, take: Callable[[DeskAnswer], None], unit: str = "") -> None:
        """Ask for something; `take` may be called from another thread."""
        ...


class DeskServer:
    """All connections of one desk. `refused` counts what was, by reason."""

    def __init__(self, rules: AccessRules, clock: Callable[[], float] = time.monotonic) -> None:
        self.refused: Counter[Refusal] = Counter()
        self.desk: DeskDoor | None = None
        self.beside: DeskDoor | None = None
        self.opens: Callable[[LibraryRequest], DeskDoor] | None = (
            None  # of the library; None: there is one run alone
        )
        self._rules: Final = rules
        self._clock: Final = clock
        self._connections: set[_Connection] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._opening = asyncio.Lock()  # SUMO carries one run a process
        self._told = False  # that there is something new, and nobody has looked yet
        self.app = Starlette(
            routes=[
                WebSocketRoute(SOCKET_PATH, self._socket),
                WebSocketRoute(BESIDE_PATH, self._socket),
                Route("/words.json", self._words),
                Route("/library.json", self._library),
                Route("/open", self._open, methods=["POST"]),
                Route(f"/{FAMILY}.ttf", self._face),
                Route("/{name:path}", self._page),
            ]
        )

    def changed(self) -> None:
        """There is something new to send; called from any thread, as often as it likes."""
        loop = self._loop
        if loop is not None and not self._told and not loop.is_closed():
            self._told = True
            loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        self._told = False
        for connection in self._connections:
            connection.wake()

    def _refuse(self, why: Refusal) -> None:
        self.refused[why] += 1

    def _turned_away(self, request: PageRequest) -> Response | None:
        """The answer to who asks for a page from where it may not be had."""
        if (why := self._rules.refused(request.headers.get("host", ""), None)) is None:
            return None
        self._refuse(why)
        return PlainTextResponse(why.value, 403)

    async def _words(self, _request: PageRequest) -> Response:
        """The Japanese of what the pages say, by English and context as gettext joins them."""
        words = {
            f"{context}\u0004{english}": said.ja
            for context in WORDS_IN
            for english, said in phrases_of(context).items()
        }
        return JSONResponse(words, headers=HEADERS)

    async def _library(self, request: PageRequest) -> Response:
        """What can be opened, and whether something is."""
        if (refusal := self._turned_away(request)) is not None:
            return refusal
        entries = () if self.opens is None else library()
        body = msgspec.json.encode({"running": self.desk is not None, "entries": entries})
        return Response(body, media_type="application/json", headers=HEADERS)

    async def _open(self, request: PageRequest) -> Response:
        """Something else is opened; all who are connected come back to that."""
        why = self._rules.refused(request.headers.get("host", ""), request.headers.get("origin"))
        body = b""
        parts = request.stream()
        while why is None and (part := await anext(parts, None)) is not None:
            body += part
            why = Refusal.SIZE if len(body) > MESSAGE_BYTES_MAX else None  # the rest is not waited for
        try:
            asked = msgspec.json.decode(body, type=LibraryRequest) if why is None else None
        except msgspec.DecodeError:
            asked, why = None, Refusal.FORM
        if asked is not None and not self._rules.opens(Seat.INSTRUCTOR, asked.token):
            why = Refusal.TOKEN
        if why is not None or asked is None or self.opens is None:
            self._refuse(why or Refusal.FORM)
            return PlainTextResponse((why or Refusal.FORM).value, 403)
        async with self._opening:
            try:
                self.desk = await asyncio.to_thread(self.opens, asked)
            except InputError as error:
                return PlainTextResponse(str(error), 400)
            finally:
                if self.desk is not None and self.desk.is_over:
                    self.desk = None
                for connection in tuple(self._connections):
                    if connection.desk is not self.desk:
                        await connection.send_away()
        return JSONResponse({}, headers=HEADERS)

    async def _face(self, request: PageRequest) -> Response:
        """The Japanese font, for browsers whose machine has none; they keep it."""
        if (refusal := self._turned_away(request)) is not None:
            return refusal
        path = japanese_font()
        if path is None:
            return PlainTextResponse("its package is not installed", 404)
        return FileResponse(path, media_type="font/ttf", headers=HEADERS | {"Cache-Control": "max-age=86400"})

    async def _page(self, request: PageRequest) -> Response:
        if (refusal := self._turned_away(request)) is not None:
            return refusal
        name = request.path_params["name"] or "index.html"
        for folder in (files("console") / "web", files("study") / "report" / "web"):
            file = next((one for one in folder.iterdir() if one.name == name and one.is_file()), None)
            if file is not None:
                kind = TYPES.get(f".{name.rpartition('.')[2]}", "application/octet-stream")
                return Response(file.read_bytes(), media_type=kind, headers=HEADERS)
        return PlainTextResponse("there is no such page", 404)

    async def _socket(self, socket: WebSocket) -> None:
        host, origin = socket.headers.get("host", ""), socket.headers.get("origin")
        why = self._rules.refused(host, origin)
        why = why or (Refusal.SOCKETS if len(self._connections) >= SOCKETS_MAX else None)
        if why is not None:
            self._refuse(why)
            await socket.close(FULL_CODE if why is Refusal.SOCKETS else REFUSED_CODE, why.value)
            return
        self._loop = asyncio.get_running_loop()
        desk = self.beside if socket.url.path == BESIDE_PATH else self.desk
        connection = _Connection(socket, self._clock, self._refuse, desk)
        self._connections.add(connection)
        try:
            await socket.accept()
            await self._serve(connection)
        except WebSocketDisconnect:
            pass
        finally:
            self._connections.discard(connection)

    async def _serve(self, connection: _Connection) -> None:
        desk = connection.desk
        if desk is None:
            raise WebSocketDisconnect
        seat, connection.unit = await connection.seat_taken(self._rules)
        welcome = desk.welcome(seat)
        if connection.unit not in (("", *welcome.units) if seat is not Seat.DRIVER else welcome.units):
            await connection.close(Refusal.FORM)
            return
        self._look(desk)
        await connection.send(encoded(welcome))
        sending = asyncio.create_task(connection.send_moments(desk, seat))
        try:
            await connection.hear(desk, seat)
        finally:
            sending.cancel()
            connection.unit = ""
            self._look(desk)

    def _look(self, desk: DeskDoor) -> None:
        desk.look_from(frozenset(c.unit for c in self._connections if c.unit and c.desk is desk))


class _Connection:
    """One page or panel."""

    def __init__(
        self,
        socket: WebSocket,
        clock: Callable[[], float],
        refuse: Callable[[Refusal], None],
        desk: DeskDoor | None,
    ) -> None:
        self.desk: Final = desk
        self._socket, self._clock, self._refuse = socket, clock, refuse
        self._news = asyncio.Event()
        self._allowance = Allowance(at_s=clock())
        self._refused = 0
        self.unit = ""

    def wake(self) -> None:
        """There is something new."""
        self._news.set()

    async def send(self, text: str) -> None:
        """Send a message whole."""
        await self._socket.send_text(text)

    async def _text(self) -> str:
        """The next message; empty, and so none of the protocol, where it is bytes."""
        message = await self._socket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", REFUSED_CODE))
        return message.get("text") or ""

    async def seat_taken(self, rules: AccessRules) -> tuple[Seat, str]:
        """The seat that the first message takes, a driver's of which unit; closed where it takes none."""
        why, text = Refusal.FORM, ""
        try:
            text = await asyncio.wait_for(self._text(), access.SEAT_WITHIN_S)
        except TimeoutError:
            await self.close(Refusal.SILENCE)
            raise WebSocketDisconnect(REFUSED_CODE) from None
        if len(text.encode()) <= MESSAGE_BYTES_MAX:
            try:
                hello = hello_of(text)
            except msgspec.DecodeError:
                pass
            else:
                if hello.version == VERSION and rules.opens(hello.seat, hello.token):
                    return hello.seat, hello.unit if hello.seat is Seat.DRIVER else ""
                why = Refusal.TOKEN if hello.version == VERSION else why
        else:
            why = Refusal.SIZE
        await self.close(why)
        raise WebSocketDisconnect(REFUSED_CODE)

    async def send_moments(self, desk: DeskDoor, seat: Seat) -> None:
        """Send the present whenever there is a new one and the last was taken."""
        had = SentSoFar()
        with suppress(WebSocketDisconnect, RuntimeError):  # it is gone, which `hear` sees too
            while True:
                self._news.clear()
                moment = desk.moment
                state, had = state_for(moment, seat, had, self.unit)
                await self.send(encoded(state))
                if not is_behind(moment, had):
                    await self._news.wait()

    async def hear(self, desk: DeskDoor, seat: Seat) -> None:
        """Take messages until the connection ends, or too many were refused."""
        loop = asyncio.get_running_loop()
        answers = asyncio.Queue[DeskAnswer](1)

        def take(answer: DeskAnswer) -> None:
            with suppress(RuntimeError):  # the server is no more
                loop.call_soon_threadsafe(answers.put_nowait, answer)

        while self._refused < REFUSED_MAX:
            text = await self._text()
            if len(text.encode()) > MESSAGE_BYTES_MAX:  # before anything is read of it
                await self.close(Refusal.SIZE)
                return
            may, self._allowance = self._allowance.after(self._clock())
            if not may:
                self._count(Refusal.RATE)
                await self._refuse_message(text, Refusal.RATE.value)
                continue
            try:
                request = request_of(text)
            except msgspec.DecodeError as error:
                self._count(Refusal.FORM)
                await self._refuse_message(text, str(error))
                continue
            desk.ask(seat, request, take, self.unit)
            await self.send(encoded(await answers.get()))
        await self.close(Refusal.RATE)

    async def _refuse_message(self, text: str, why: str) -> None:
        """Whoever said it waits for an answer with its number, where it has one."""
        await self.send(encoded(DeskAnswer(number=number_of(text), good=False, why=why)))

    def _count(self, why: Refusal) -> None:
        self._refused += 1
        self._refuse(why)

    async def send_away(self) -> None:
        """There is another run: whoever is here is to come again."""
        with suppress(RuntimeError, WebSocketDisconnect):
            await self._socket.close(GONE_CODE)

    async def close(self, why: Refusal) -> None:
        """End the connection, and say why."""
        self._refuse(why)
        await self._socket.close(REFUSED_CODE, why.value)


def listening_on(host: str, port: int) -> socket.socket:
    """A socket on an address, on which whoever comes before the server has begun waits. InputError where that cannot be
    had.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((host, port))
        bound.listen()
    except OSError as error:
        bound.close()
        expected = f"an address and port of this machine that are free: {error.strerror}"
        raise InputError(COMMAND_LINE, "--port", f"{host}:{port}", expected) from error
    return bound
