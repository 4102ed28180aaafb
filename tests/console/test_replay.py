"""A finished run at the desk: what is shown at a time does not depend on how one came there; and the library."""

import asyncio
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Final

import httpx2
import msgspec
import polars as pl
import pytest
from starlette.testclient import TestClient

from console.access import Refusal, on_loopback, with_tokens
from console.library import LibraryEntry, LibraryRequest, Opens, library, opened, taken_from_library
from console.live import LiveDesk
from console.protocol import MESSAGE_BYTES_MAX, DoAct, GoBack, NextEvent, RunTo, SetPace, State
from console.replay import Replay
from console.seats import Seat
from console.server import BESIDE_PATH, SOCKET_PATH, DeskServer
from console.shown import SentSoFar, state_for
from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from simulation.judge.checkers import Checker
from study.record.directory import reserved
from study.record.read_back import RunRead, read_run
from study.record.shown import RuleBroken
from study.runner.run import PartyLink, execute, fill_run
from tests.console.conftest import TWO, run_apart

TEN: Final = 36_000.0
HOST: Final = "127.0.0.1:8580"


@pytest.fixture(scope="module")
def run(two_trains: Scenario, tmp_path_factory: pytest.TempPathFactory) -> RunRead:
    out = tmp_path_factory.mktemp("runs") / "two"
    with reserved(out) as place:
        fill_run(execute(two_trains, PartyLink.SIMULATED, journal=place.journal), place)
    return read_run(out)


def shown(replay: Replay, time_s: float) -> State:
    assert replay.ask(Seat.GUEST, GoBack(time_s=time_s), 0.0).good
    return msgspec.structs.replace(replay.moment.truth, branch=0)


def test_a_time_shows_the_same_from_before_and_from_after(run: RunRead) -> None:
    forward, back = Replay(run), Replay(run)
    times = [TEN + 7.0 * k for k in range(20)]
    ahead = [shown(forward, time_s) for time_s in times]
    behind = [shown(back, time_s) for time_s in reversed(times)]
    assert ahead == behind[::-1]
    moving = [t for state in ahead for t in state.trains if t.speed_mps]
    assert len(moving) > 5 and all(t.section in t.sections for t in moving)


def test_events_are_sent_anew_when_one_looks_further_back(run: RunRead) -> None:
    replay = Replay(run)
    shown(replay, TEN + 60.0)
    first, had = state_for(replay.moment, Seat.GUEST, SentSoFar())
    shown(replay, TEN - 200.0)
    second, _ = state_for(replay.moment, Seat.GUEST, had)
    assert second.branch > first.branch
    assert set(second.events) < set(first.events)


def test_it_runs_at_a_pace_to_its_end_and_jumps_to_the_next_event(run: RunRead) -> None:
    replay = Replay(run)
    welcome = replay.welcome(Seat.INSTRUCTOR)
    assert (welcome.replay, welcome.acts, welcome.faults) == (True, (), ())
    before_s = replay.moment.known.time_s
    assert replay.ask(Seat.INSTRUCTOR, NextEvent(), 0.0).good
    assert replay.moment.known.time_s > before_s
    assert replay.ask(Seat.INSTRUCTOR, SetPace(factor=60.0), 10.0).good
    began_s = replay.moment.known.time_s
    replay.turn(10.5)
    assert replay.moment.known.time_s == pytest.approx(began_s + 30.0, abs=0.2)
    replay.ask(Seat.INSTRUCTOR, RunTo(time_s=200_000.0), 11.0)
    known = replay.moment.known
    assert (known.time_s, known.digest) == (welcome.end_s, run.summary["digest"])
    assert known.ended == run.summary["ended_because"]


def test_a_run_that_went_wrong_shows_its_trains_and_what_was_broken(tmp_path: Path) -> None:
    """The manager is off from 10:00:10 on and knows of no train; K1 stands from 10:00:40 on and nobody reacts."""
    file, out = tmp_path / "wrong.toml", tmp_path / "wrong"
    faults = (("block-manager", "10:00:10"), ("K1", "10:00:40"))
    faulty = "".join(
        f'[[fault]]\nkind = "power_off"\ntarget = "{target}"\nstart = "{start}"\n' for target, start in faults
    )
    file.write_text(TWO + faulty, "utf-8")
    with reserved(out) as place:
        fill_run(execute(load_scenario(str(file)), PartyLink.SIMULATED, journal=place.journal), place)
    read = read_run(out)
    overran = RuleBroken(TEN + 50.0, Checker.INSIDE_HOLDING.value, "K1 overran")
    moves = read.tables.trajectory.filter(pl.col("speed_mps") > 0.0)  # there are no samples of a stand
    tables = replace(read.tables, trajectory=moves)
    replay = Replay(replace(read, tables=tables, shown=replace(read.shown, violations=(overran,))))
    standing, moving, stopped = (shown(replay, TEN + s) for s in (-60.0, 20.0, 200.0))
    for state, runs in ((standing, False), (moving, True), (stopped, False)):
        train = next(train for train in state.trains if train.unit == "K1")
        assert train.at_m is not None and bool(train.speed_mps) is runs and train.train == "T1"
    assert not moving.manager_on and all(not train.sections for train in moving.trains)
    assert [rule.rule for rule in moving.rules if rule.broken] == []
    assert [rule.first for rule in stopped.rules if rule.broken] == ["K1 overran"]
    ended = shown(replay, 200_000.0)
    broken = {rule.rule: (rule.broken, rule.first) for rule in ended.rules if rule.broken}
    assert broken == {
        Checker.INSIDE_HOLDING.value: (1, "K1 overran"),
        Checker.EVERYONE_ARRIVES.value: (2, "T1 has not arrived"),
    }


def test_nobody_acts_in_a_run_that_has_ended(run: RunRead) -> None:
    answer = Replay(run).ask(Seat.INSTRUCTOR, DoAct(act={"kind": "give_back", "target": "K1"}), 0.0)
    assert not answer.good and "looked at" in answer.why


def test_the_library_has_what_is_shipped_and_the_finished_runs_of_its_folder(run: RunRead) -> None:
    entries = library(run.directory.parent)
    assert LibraryEntry(Opens.SCENARIO, "karasuyama_weekday") in entries
    assert any(entry.kind is Opens.DRILL and entry.name == "rtri/09_manager_power" for entry in entries)
    assert [entry.name for entry in entries if entry.kind is Opens.RUN] == ["two"]
    assert isinstance(taken_from_library(LibraryRequest(Opens.RUN, "two"), run.directory.parent), RunRead)
    assert isinstance(opened(str(run.directory)), RunRead)


@pytest.mark.parametrize("name", ["../two", "/etc", "three", "karasuyama_weekday"])
def test_nothing_but_the_library_can_be_opened_by_a_page(run: RunRead, name: str) -> None:
    with pytest.raises(InputError, match="something of the library"):
        taken_from_library(LibraryRequest(Opens.RUN, name), run.directory.parent)


def test_a_run_beside_another_has_a_socket_of_its_own(run: RunRead) -> None:
    server = DeskServer(on_loopback(8580))
    with ExitStack() as stack:
        lives = [LiveDesk(run, server.changed) for _ in range(2)]
        for live in lives:
            live.start()
            stack.callback(live.stop)
        server.desk, server.beside = lives
        client = stack.enter_context(TestClient(server.app, base_url=f"http://{HOST}"))
        seen = []
        for path in (SOCKET_PATH, BESIDE_PATH):
            with client.websocket_connect(path, headers={"host": HOST}) as socket:
                socket.send_text('{"say": "hello", "seat": "instructor"}')
                said = [socket.receive_json()["say"] for _ in range(2)]
                time_s = TEN + len(seen)
                socket.send_text(f'{{"say": "go_back", "number": 1, "time_s": {time_s}}}')
                while (answer := socket.receive_json())["say"] != "answer":
                    pass
                seen.append((said, answer["good"], float(answer["text"])))
        assert seen == [(["welcome", "state"], True, TEN), (["welcome", "state"], True, TEN + 1.0)]
        assert [live.moment.known.time_s for live in lives] != [TEN + 1.0] * 2


def test_what_cannot_be_opened_leaves_no_page_at_a_run_that_is_no_more(run: RunRead) -> None:
    """Two that are asked for at once are opened one after the other; of one that does not begin nothing is left."""
    server, opening, most = DeskServer(on_loopback(8580)), [0], [0]
    lives: list[LiveDesk] = []

    def opens(asked: LibraryRequest) -> LiveDesk:
        opening[0] += 1
        most[0] = max(most[0], opening[0])
        try:
            if asked.name == "nothing":
                raise InputError("desk", "name", asked.name, "something of the library")
            while lives:
                lives.pop().stop()
            live = LiveDesk(
                run if asked.name == "two" else load_scenario("karasuyama_bad_days"), server.changed
            )
            live.start()
            begun.callback(live.stop)
            lives.append(live)
            return live
        finally:
            opening[0] -= 1

    server.opens = opens

    async def ask_all(*names: str) -> list[int]:
        transport = httpx2.ASGITransport(app=server.app)
        async with httpx2.AsyncClient(transport=transport, base_url=f"http://{HOST}") as client:
            bodies = [{"kind": "run", "name": name} for name in names]
            answers = await asyncio.gather(*(client.post("/open", json=body) for body in bodies))
        return [answer.status_code for answer in answers]

    with ExitStack() as begun:
        assert run_apart(ask_all("two", "two")) == [200, 200]
        assert most == [1]
        assert run_apart(ask_all("nothing")) == [400]
        assert server.desk is lives[0] and not lives[0].is_over  # it goes on
        assert run_apart(ask_all("bad_days")) == [400]
        assert server.desk is None and lives == []


def test_only_the_instructor_and_only_a_page_of_the_desk_opens_something() -> None:
    found: list[LibraryRequest] = []

    def opens(asked: LibraryRequest) -> None:
        found.append(asked)

    for rules, origin, token, code in (
        (on_loopback(8580), f"http://{HOST}", "", 200),
        (on_loopback(8580), "http://elsewhere.example", "", 403),
        (with_tokens(), f"http://{HOST}", "guessed", 403),
    ):
        server = DeskServer(rules)
        server.opens = opens  # type: ignore[assignment]
        client = TestClient(server.app, base_url=f"http://{HOST}")
        assert not client.get("/library.json").json()["running"]
        body = {"kind": "drill", "name": "rtri/09_manager_power", "token": token}
        answer = client.post("/open", json=body, headers={"host": HOST, "origin": origin})
        assert answer.status_code == code
        assert client.post("/open", content=b"{", headers={"host": HOST}).status_code == 403
        much = b" " * (MESSAGE_BYTES_MAX + 1)
        assert client.post("/open", content=much, headers={"host": HOST}).status_code == 403
        assert server.refused[Refusal.SIZE] == 1
    assert [one.name for one in found] == ["rtri/09_manager_power"]
