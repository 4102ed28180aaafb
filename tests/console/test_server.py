"""The desk's door: who may come in, what is refused and counted, and that none of it reaches the run."""

import asyncio
import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from io import BytesIO
from pathlib import Path
from socket import create_connection
from typing import Any, Final

import pytest

pytest.importorskip("starlette", reason="the extra [console] is not installed")
pytest.importorskip("httpx2", reason="starlette's test client needs it")

from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect

from console import access
from console.access import LOOPBACK, SOCKETS_MAX, AccessRules, Refusal, on_loopback, with_tokens, write_tokens
from console.desk import Desk
from console.protocol import MESSAGE_BYTES_MAX, DeskAnswer, Request, Welcome
from console.seats import Seat
from console.server import FULL_CODE, REFUSED_CODE, SOCKET_PATH, DeskServer, listening_on
from console.session import Session
from console.shown import DeskMoment
from network.errors import InputError
from scenario.scenario import Scenario
from study.report.face import FIRST_JAPANESE
from tests.console.conftest import run_apart

HOST: Final = "127.0.0.1:8580"
ORIGIN: Final = {"origin": f"http://{HOST}"}


class Door:
    """A desk that stands still but for what it is asked, in the thread that asks."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.desk = Desk(session)
        self.asked = 0

    @property
    def moment(self) -> DeskMoment:
        return self.desk.moment

    @property
    def is_over(self) -> bool:
        return False

    def welcome(self, seat: Seat) -> Welcome:
        return self.desk.welcome(seat)

    def look_from(self, units: frozenset[str]) -> None:
        self.desk.cabs = units

    def ask(self, seat: Seat, request: Request, take: Callable[[DeskAnswer], None], unit: str = "") -> None:
        self.asked += 1
        take(self.desk.ask(seat, request, 0.0, unit))


@pytest.fixture(scope="module")
def door(two_trains: Scenario) -> Iterator[Door]:
    with Session(two_trains) as session:
        yield Door(session)


class Visit:
    """A server with rules of its own on the one desk; its clock stands."""

    def __init__(self, door: Door, rules: AccessRules | None = None) -> None:
        self.door = door
        self.server = DeskServer(on_loopback(8580) if rules is None else rules, lambda: 0.0)
        self.server.desk = door
        self.client = TestClient(self.server.app, base_url=f"http://{HOST}")

    def connect(self, **headers: str) -> WebSocketTestSession:
        return self.client.websocket_connect(SOCKET_PATH, headers={"host": HOST, **headers})

    def closed_with(self, **headers: str) -> int:
        with pytest.raises(WebSocketDisconnect) as closed, self.connect(**headers):
            pass
        return closed.value.code


def say(socket: WebSocketTestSession, **message: object) -> None:
    socket.send_text(json.dumps(message))


def sit(socket: WebSocketTestSession, seat: str, **more: object) -> dict[str, Any]:
    say(socket, say="hello", seat=seat, **more)
    return dict(socket.receive_json())


def answer(socket: WebSocketTestSession) -> dict[str, Any]:
    """The next answer; what is shown between is left alone."""
    while (message := socket.receive_json())["say"] != "answer":
        pass
    return dict(message)


def test_a_seat_is_taken_and_sees_what_is_its_own(door: Door) -> None:
    visit = Visit(door)
    with visit.connect(**ORIGIN) as socket:
        welcome = sit(socket, "dispatcher")
        state = socket.receive_json()
    assert welcome["say"] == "welcome"
    assert welcome["faults"] == []
    assert "power_on" not in welcome["acts"]
    assert {section["id"] for section in state["sections"]} == set(door.session.names.sections)
    assert (state["rules"], state["deeds"], state["points"], state["silent"]) == ([], [], [], [])
    assert all(train["at_m"] is None for train in state["trains"])
    assert not visit.server.refused


def test_the_instructor_sees_the_truth_and_every_kind_of_fault_with_its_keys(door: Door) -> None:
    with Visit(door).connect(**ORIGIN) as socket:
        welcome = sit(socket, "instructor")
        state = socket.receive_json()
    kinds = {kind["kind"]: kind for kind in welcome["faults"]}
    assert "duration_s" not in kinds["loss"]["schema"]["properties"]
    assert "p" in kinds["loss"]["schema"]["properties"]
    assert kinds["restart"]["momentary"] is True
    assert [point["id"] for point in state["points"]] == list(door.session.scenario.setup.line.points)
    assert all(rule["broken"] == 0 for rule in state["rules"])


@pytest.mark.parametrize(
    ("headers", "why"),
    [
        ({"origin": "http://evil.example"}, Refusal.ORIGIN),
        ({"origin": "null"}, Refusal.ORIGIN),
        ({"origin": f"https://{HOST}"}, Refusal.ORIGIN),
        ({"host": "evil.example:8580"}, Refusal.HOST),
    ],
)
def test_a_forged_origin_or_host_is_refused(door: Door, headers: dict[str, str], why: Refusal) -> None:
    visit = Visit(door)
    assert visit.closed_with(**headers) == REFUSED_CODE
    assert visit.server.refused == {why: 1}
    if why is Refusal.HOST:
        assert visit.client.get("/", headers=headers).status_code == 403


def test_behind_what_encrypts_a_page_has_another_scheme(door: Door) -> None:
    """`--listen` says to put the desk behind something that encrypts: its pages then come by https."""
    for rules, taken in ((with_tokens(), True), (on_loopback(8580), False)):
        assert (rules.refused(HOST, f"https://{HOST}") is None) is taken
        assert rules.refused(HOST, "https://evil.example") is Refusal.ORIGIN


def test_a_browser_names_no_port_where_it_is_that_of_http() -> None:
    for port, taken in ((80, True), (8580, False)):
        rules = on_loopback(port)
        assert (rules.refused(LOOPBACK, f"http://{LOOPBACK}") is None) is taken
        assert rules.refused(f"{LOOPBACK}:{port}", None) is None


def test_a_seat_opens_with_its_own_token_alone(door: Door) -> None:
    rules = with_tokens()
    assert rules.tokens is not None
    visit = Visit(door, rules)
    for token in ("", "x", rules.tokens[Seat.INSTRUCTOR]):
        with visit.connect() as socket, pytest.raises(WebSocketDisconnect) as closed:
            sit(socket, "dispatcher", token=token)
        assert closed.value.code == REFUSED_CODE
    assert visit.server.refused == {Refusal.TOKEN: 3}
    with visit.connect() as socket:
        assert sit(socket, "dispatcher", token=rules.tokens[Seat.DISPATCHER])["seat"] == "dispatcher"


def test_who_comes_before_the_server_has_begun_waits_for_it() -> None:
    """A browser is opened on the address that is printed, and may be quicker than the server."""
    with listening_on(LOOPBACK, 0) as bound, create_connection(bound.getsockname(), timeout=5.0) as early:
        accepted, address = bound.accept()
        accepted.close()
        assert address == early.getsockname()


def test_tokens_are_written_for_their_owner_alone_and_over_no_file(tmp_path: Path) -> None:
    rules = with_tokens()
    file = tmp_path / "tokens.json"
    write_tokens(rules, file)
    assert file.stat().st_mode & 0o777 == 0o600
    assert set(json.loads(file.read_text("utf-8"))) == {seat.value for seat in Seat}
    with pytest.raises(InputError, match="--tokens"):
        write_tokens(rules, file)


@pytest.mark.parametrize(
    ("seat", "message", "why"),
    [
        ("dispatcher", {"say": "pace", "factor": 60}, "expected instructor"),
        ("dispatcher", {"say": "fail", "fault": {"kind": "restart", "target": "K1"}}, "expected instructor"),
        ("dispatcher", {"say": "go_back", "time_s": 35000}, "expected instructor"),
        ("dispatcher", {"say": "act", "act": {"kind": "power_on", "target": "K1"}}, "the seat dispatcher"),
        ("dispatcher", {"say": "protocol"}, "expected instructor, or the run's end"),
        ("guest", {"say": "save", "id": "x"}, "expected instructor, or the run's end"),
        ("staff", {"say": "act", "act": {"kind": "accept_picture"}}, "the seat staff"),
        ("guest", {"say": "act", "act": {"kind": "give_back", "target": "K1"}}, "none is"),
        (
            "dispatcher",
            {"say": "act", "act": {"kind": "give_back", "target": "K1", "person": "staff"}},
            "whose seat this is",
        ),
        ("instructor", {"say": "act", "act": {"kind": "sing"}}, "act.kind"),
        ("instructor", {"say": "act", "act": {"kind": ["sing"]}}, "a valid string"),
        ("instructor", {"say": "end_fault", "deed": 7}, "a fault in force"),
        ("instructor", {"say": "save", "id": "../x"}, "an identifier"),
    ],
)
def test_what_a_seat_may_not_do_is_refused_with_a_reason(
    door: Door, seat: str, message: dict[str, Any], why: str
) -> None:
    with Visit(door).connect(**ORIGIN) as socket:
        sit(socket, seat)
        say(socket, number=5, **message)
        said = answer(socket)
    assert (said["number"], said["good"]) == (5, False)
    assert why in said["why"]
    assert door.session.deeds == []


@pytest.mark.parametrize(
    "text",
    [
        *("", "{", "[]", '{"say":"pace"}', '{"say":"pace","factor":61}', '{"say":"hello","seat":"king"}'),
        '{"say":"act","act":{"target":'
        + "[" * 400
        + "]" * 400
        + "}}",  # whoever wrote a reason of it broke down
        '{"say":"act","act":{"target":' + "[" * 5000 + "]" * 5000 + "}}",
    ],
)
def test_what_is_no_message_is_refused_and_the_connection_goes_on(door: Door, text: str) -> None:
    visit = Visit(door)
    with visit.connect(**ORIGIN) as socket:
        sit(socket, "instructor")
        socket.send_text(text)
        assert answer(socket)["good"] is False
        socket.send_bytes(b"\xff")
        assert answer(socket)["good"] is False
        say(socket, say="run_to", number=9, time_s=None)
        refused = answer(socket)
        assert (refused["number"], refused["good"]) == (9, False)
        say(socket, say="pace", number=1, factor=0.0)
        assert answer(socket) == {
            "say": "answer",
            "number": 1,
            "good": True,
            "why": "",
            "text": "",
            "deed": None,
        }
    assert visit.server.refused == {Refusal.FORM: 3}


def test_a_message_that_is_too_long_ends_the_connection(door: Door) -> None:
    visit = Visit(door)
    asked = door.asked
    with visit.connect(**ORIGIN) as socket:
        sit(socket, "instructor")
        for number in range(100):  # more than are heard at once: nothing is read of it all the same
            say(socket, say="pace", number=number, factor=0.0)
        say(socket, say="save", number=7, id="x" * MESSAGE_BYTES_MAX)
        assert [answer(socket)["number"] for _ in range(100)] == list(range(100))
        with pytest.raises(WebSocketDisconnect) as closed:
            answer(socket)
    assert closed.value.reason == Refusal.SIZE.value
    assert visit.server.refused == {Refusal.RATE: 60, Refusal.SIZE: 1}
    assert door.asked == asked + 40


def test_of_a_thousand_messages_a_second_forty_are_heard(door: Door) -> None:
    """The clock stands: 40 at once, 100 are refused, each with its number, and the connection is closed."""
    visit, asked = Visit(door), door.asked
    with visit.connect(**ORIGIN) as socket:
        sit(socket, "instructor")
        for number in range(1000):
            say(socket, say="pace", number=number, factor=0.0)
        said = []
        with pytest.raises(WebSocketDisconnect):
            while True:
                said.append(answer(socket))
    assert [(one["number"], one["good"]) for one in said] == [(n, n < 40) for n in range(140)]
    assert door.asked - asked == 40
    assert visit.server.refused[Refusal.RATE] == 101


def test_of_two_hundred_sockets_as_many_are_let_in_as_there_may_be(door: Door) -> None:
    visit = Visit(door)
    with visit.client, ExitStack() as opened:
        for _ in range(SOCKETS_MAX):
            opened.enter_context(visit.connect(**ORIGIN))
        for _ in range(200 - SOCKETS_MAX):
            assert visit.closed_with(**ORIGIN) == FULL_CODE
    assert visit.server.refused == {Refusal.SOCKETS: 200 - SOCKETS_MAX}


def test_who_takes_no_seat_makes_room(door: Door, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(access, "SEAT_WITHIN_S", 0.0)
    visit = Visit(door)
    with visit.connect(**ORIGIN) as socket, pytest.raises(WebSocketDisconnect) as closed:
        sit(socket, "guest")
    assert closed.value.code == REFUSED_CODE
    assert visit.server.refused == {Refusal.SILENCE: 1}


def test_pages_come_from_two_folders_and_from_nowhere_else(door: Door) -> None:
    client = Visit(door).client
    assert client.get("/graphpaper.js").headers["content-type"].startswith("text/javascript")
    for name in ("session.py", "..%2fsession.py", "%2e%2e/session.py", "a/b.js", "a" * 300):
        assert client.get(f"/{name}").status_code == 404
    assert "default-src 'self'" in client.get("/graphpaper.js").headers["content-security-policy"]


def test_the_japanese_font_comes_with_the_pages_and_is_kept(door: Door) -> None:
    """Every character of the catalogue's Japanese is in it, so no browser shows boxes."""
    from fontTools.ttLib import TTFont

    client = Visit(door).client
    assert '"branchline-ja.ttf"' in client.get("/desk.css").text
    font = client.get("/branchline-ja.ttf")
    assert (font.headers["content-type"], font.headers["cache-control"]) == ("font/ttf", "max-age=86400")
    drawn = set(TTFont(BytesIO(font.content))["cmap"].getBestCmap())
    said = {ord(c) for word in client.get("/words.json").json().values() for c in word}
    assert {c for c in said if c >= FIRST_JAPANESE} <= drawn
    assert client.get("/branchline-ja.ttf", headers={"host": "elsewhere.example"}).status_code == 403


def test_a_connection_that_takes_nothing_holds_up_itself_alone(door: Door) -> None:
    """Its first send never ends; the other is sent every moment, and the desk answers."""

    async def both() -> tuple[int, list[str]]:
        server = DeskServer(on_loopback(8580), lambda: 0.0)
        server.desk = door
        stalled, lively = _Wire(stalls=True), _Wire(stalls=False)
        tasks = [
            asyncio.create_task(server.app(wire.scope, wire.receive, wire.send)) for wire in (stalled, lively)
        ]
        for wire in (stalled, lively):
            wire.say({"say": "hello", "seat": "instructor"})
        for number in range(5):
            lively.say({"say": "one_step", "number": number})
            await lively.heard("answer")
            server.changed()
            await lively.heard("state")
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return len(stalled.sent), lively.sent

    before = door.session.step
    held, sent = run_apart(both())
    assert held == 0
    assert sent.count("answer") == 5
    assert sent.count("state") >= 5
    assert door.session.step == before + 5


class _Wire:
    """What a server has of a connection; one that stalls takes nothing that is sent on it."""

    def __init__(self, *, stalls: bool) -> None:
        self.scope: dict[str, Any] = {
            "type": "websocket",
            "path": SOCKET_PATH,
            "headers": [(b"host", HOST.encode()), (b"origin", ORIGIN["origin"].encode())],
            "query_string": b"",
            "subprotocols": [],
        }
        self.sent: list[str] = []
        self._stalls = stalls
        self._coming: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._going: asyncio.Queue[str] = asyncio.Queue()
        self._coming.put_nowait({"type": "websocket.connect"})

    def say(self, message: dict[str, Any]) -> None:
        self._coming.put_nowait({"type": "websocket.receive", "text": json.dumps(message)})

    async def receive(self) -> dict[str, Any]:
        return await self._coming.get()

    async def send(self, message: Any) -> None:  # noqa: ANN401
        if message["type"] != "websocket.send":
            return
        if self._stalls:
            await asyncio.Event().wait()
        word = json.loads(message["text"])["say"]
        self.sent.append(word)
        self._going.put_nowait(word)

    async def heard(self, word: str) -> None:
        while await self._going.get() != word:
            pass
