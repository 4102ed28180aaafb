"""Parties as processes: nobody else can speak, hear or join unnoticed, and nothing is left afterwards."""

import base64
import os
import select
import signal
import stat
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec
import psutil
import pytest
import zenoh

import host.lockstep
import host.over_zenoh
import host.process
from host.devices import CODEC, DeviceTold, device_specs
from host.lockstep import Asker, Tagged
from host.order_solver import HANGS_S
from host.over_zenoh import ZenohParties, answer_limit_s
from host.parties import ForeignError, PartyBug, PartyError
from host.party import Advance
from host.planes import Secrets, new_secrets, said_key, session_json5, time_key
from host.process import PartyProcess, environment, last_words
from radio.keys import KeyRing
from tests.nightly import others_nightly
from wayside.config import (
    MANAGER_ID,
    DispatchEntry,
    ManagerConfig,
    OrderRule,
    PointsEntry,
    SectionEntry,
    TerminalConfig,
)

MASTER: Final = b"m" * 32
MANAGER: Final = ManagerConfig("line", MANAGER_ID, ("u1",), (SectionEntry("P", portal=True),), ())
TERMINAL: Final = TerminalConfig("line", "t", (PointsEntry("p", "S", 8.0),))
TOLD: Final = CODEC.encode(DeviceTold())
ROUNDS: Final = 5000  # a telegram of another session comes within this many rounds
needs_proc = pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc to see processes")


def zenoh_parties(directory: Path) -> ZenohParties:
    return ZenohParties("line", device_specs(MANAGER, [TERMINAL], MASTER), directory)


@pytest.fixture
def parties(tmp_path: Path) -> Iterator[ZenohParties]:
    with zenoh_parties(tmp_path) as found:
        yield found


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Secrets]:
    """The secrets of all boots, those of the block manager first, as they are drawn."""
    found: list[Secrets] = []

    def noted(keys: KeyRing) -> Secrets:
        found.append(new_secrets(keys))
        return found[-1]

    monkeypatch.setattr(host.over_zenoh, "new_secrets", noted)
    return found


def stranger(parties: ZenohParties) -> zenoh.Session:
    """A session of the same user that knows where the socket is."""
    return zenoh.open(zenoh.Config.from_json5(session_json5("connect", parties.endpoint, "abc")))


def ask_on(parties: ZenohParties) -> Advance:
    """Round after round, as a run does."""
    for number in range(ROUNDS):
        done = parties.advance("t", 0.1 * number, [], TOLD)
        if done.telegrams:
            return done
    raise AssertionError("nothing was heard")


# who is not of this run -------------------------------------------------------------------------------------


def test_a_foreign_session_ends_the_run(parties: ZenohParties) -> None:
    with stranger(parties), pytest.raises(ForeignError, match="a foreign session has joined the run: abc"):
        ask_on(parties)


def publish(session: zenoh.Session, payload: bytes, attachment: bytes | None) -> zenoh.Publisher:
    publisher = session.declare_publisher(
        said_key("line", "t", "u1"), congestion_control=zenoh.CongestionControl.BLOCK
    )
    publisher.put(payload, attachment=attachment)
    return publisher


@pytest.mark.parametrize("attachment", [None, b"", b"\x93\x01\x00\xc4\x10" + bytes(16)])
def test_a_foreign_telegram_ends_the_run(
    parties: ZenohParties, monkeypatch: pytest.MonkeyPatch, attachment: bytes | None
) -> None:
    """Even if its session were not noticed."""
    monkeypatch.setattr(host.over_zenoh, "of_run", lambda _session, _given: True)
    with stranger(parties) as session, pytest.raises(ForeignError, match="a foreign telegram to u1"):
        _publisher = publish(session, b"stop", attachment)
        ask_on(parties)


def test_without_these_defences_a_stranger_is_heard(
    parties: ZenohParties, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the two tests above guard: switched off, the stranger's telegram goes to a train."""
    monkeypatch.setattr(host.over_zenoh, "of_run", lambda _session, _given: True)
    for defence in ("authentic", "of_round"):
        monkeypatch.setattr(host.lockstep, defence, lambda _found, _expected: True)
    with stranger(parties) as session:
        _publisher = publish(session, b"stop", b"\x93\x01\x00\xc4\x10" + bytes(16))
        assert ask_on(parties).telegrams == (("u1", b"stop"),)


@pytest.mark.parametrize("answers", ["a reply", "an error"])
def test_a_foreign_reply_ends_the_run(
    parties: ZenohParties, monkeypatch: pytest.MonkeyPatch, answers: str
) -> None:
    """The party itself only starts, so that the stranger is the first to answer."""
    monkeypatch.setattr(host.over_zenoh, "of_run", lambda _session, _given: True)

    def reply(query: zenoh.Query) -> None:
        with query:
            if answers == "a reply":
                query.reply(time_key("line", "t"), b"all done" * 4)
            else:
                query.reply_err("all done")

    parties.kill("t")
    with stranger(parties) as session:
        _queryable = session.declare_queryable(time_key("line", "t"), reply)
        with pytest.raises(ForeignError, match="a foreign reply to the question to t"):
            parties.restart("t")


def test_a_process_of_an_earlier_boot_that_is_still_there_ends_the_run(
    tmp_path: Path, drawn: list[Secrets]
) -> None:
    """Two block managers at once: that of before was stopped as its successor began, and goes on."""
    spec = next(spec for spec in device_specs(MANAGER, [TERMINAL], MASTER) if spec.party_id == MANAGER_ID)
    with zenoh_parties(tmp_path) as parties:
        parties.kill(MANAGER_ID)
        parties.restart(MANAGER_ID)
        before = PartyProcess(spec, drawn[0], tmp_path / MANAGER_ID, parties.endpoint)
        try:
            with pytest.raises(ForeignError, match=f"{MANAGER_ID}: its code is not of this run"):
                while "not our question" not in last_words(tmp_path / MANAGER_ID):
                    parties.advance(MANAGER_ID, 0.0, [], TOLD)
                for _ in range(ROUNDS):
                    parties.advance(MANAGER_ID, 0.0, [], TOLD)
        finally:
            before.kill()


def test_only_its_owner_can_reach_the_socket(parties: ZenohParties, tmp_path: Path) -> None:
    socket = Path(parties.endpoint.removeprefix("unixsock-stream/"))
    assert stat.S_ISSOCK(socket.stat().st_mode)
    assert stat.S_IMODE(socket.stat().st_mode) == 0o600
    assert stat.S_IMODE(socket.parent.stat().st_mode) == 0o700
    for party_id in (MANAGER_ID, "t"):
        assert stat.S_IMODE((tmp_path / party_id).stat().st_mode) == 0o700


def test_secrets_stand_in_no_file(
    tmp_path: Path, drawn: list[Secrets], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At no moment, so that whoever is killed leaves none: not when a process begins, and not once it runs."""
    found: list[Path] = []

    def look() -> None:
        files = [path for path in tmp_path.rglob("*") if path.is_file()]
        given = [base64.b64encode(own.plane_key) for own in drawn]
        found.extend(path for path in files if any(secret in path.read_bytes() for secret in given))

    def started(own: Mapping[str, str], folder: Path) -> dict[str, str]:
        look()
        return environment(own, folder)

    monkeypatch.setattr(host.process, "environment", started)
    with zenoh_parties(tmp_path) as parties:
        look()
        parties.kill("t")
        parties.restart("t")
        look()
    assert (len(drawn), found) == (3, [])
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(PartyError, match="ended with code 1"):
        zenoh_parties(tmp_path).__enter__()


def test_no_port_is_open_and_the_socket_goes_with_the_run(tmp_path: Path) -> None:
    with zenoh_parties(tmp_path) as parties:
        folder = Path(parties.endpoint.removeprefix("unixsock-stream/")).parent
        own = psutil.Process()
        for process in (own, *own.children()):
            assert [c for c in process.net_connections("inet") if c.status == psutil.CONN_LISTEN] == []
    assert not folder.exists()


def test_every_boot_has_secrets_of_its_own(tmp_path: Path, drawn: list[Secrets]) -> None:
    with zenoh_parties(tmp_path) as parties:
        parties.kill("t")
        parties.restart("t")
    assert len({own.plane_key for own in drawn}) == len({own.session_id for own in drawn}) == len(drawn) == 3


# trouble ----------------------------------------------------------------------------------------------------


def test_a_question_too_long_for_the_link_is_refused_before_it_breaks_it(parties: ZenohParties) -> None:
    with pytest.raises(PartyError, match="too long for its link"):
        parties.advance("t", 0.0, [], bytes(70_000))


def test_a_party_that_dies_over_a_question_is_named(
    parties: ZenohParties, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(PartyProcess, "alive", lambda _self: True)  # as it was when it was asked
    (terminal,) = [p for p in psutil.Process().children() if "t" in p.cmdline()]
    terminal.kill()
    with pytest.raises(PartyError, match=r"^point terminal t was killed by SIGKILL$"):
        parties.advance("t", 0.0, [], TOLD)


def test_a_party_that_died_since_it_was_asked_is_named_with_its_signal(parties: ZenohParties) -> None:
    (manager,) = [p for p in psutil.Process().children() if MANAGER_ID in p.cmdline()]
    ended = os.pidfd_open(manager.pid)
    manager.terminate()
    assert select.select([ended], [], [], 20.0)[0] == [ended]
    os.close(ended)
    with pytest.raises(PartyError, match=r"^block manager was killed by SIGTERM$") as lost:
        parties.advance(MANAGER_ID, 0.0, [], TOLD)
    assert not isinstance(lost.value, PartyBug)


def test_a_party_whose_program_fails_is_a_bug(parties: ZenohParties) -> None:
    with pytest.raises(PartyBug, match=r"^point terminal t failed: InputError"):
        parties.advance("t", 0.0, [], b"no record of a terminal")


def test_a_party_without_room_on_its_disk_is_no_bug(tmp_path: Path) -> None:
    """Its durable state cannot be written: the file aside is a device that takes nothing."""
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "durable.new").symlink_to("/dev/full")
    with pytest.raises(
        PartyError, match=r"^point terminal t ended with code 3 while it .* No space left"
    ) as lost:
        zenoh_parties(tmp_path).__enter__()
    assert not isinstance(lost.value, PartyBug)


def test_an_endpoint_that_is_gone_is_no_bug(parties: ZenohParties) -> None:
    parties.kill("t")
    Path(parties.endpoint.removeprefix("unixsock-stream/")).unlink()
    with pytest.raises(PartyError, match=r"^point terminal t ended with code 3 .* cannot be reached") as lost:
        parties.restart("t")
    assert not isinstance(lost.value, PartyBug)


# a folder with other modules ----------------------------------------------------------------------------------

TRAPS: Final = ("host", "radio", "network", "wayside", "onboard", "numpy", "msgspec", "zenoh", "queue")


@pytest.fixture
def trap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder from which the program is called; whoever takes a module from it leaves a mark."""
    folder = tmp_path / "trap"
    folder.mkdir()
    mark = f"from pathlib import Path\nPath({str(folder / 'mark')!r}).touch()\nraise SystemExit('the wrong module')\n"
    for name in (*TRAPS, "sitecustomize", "usercustomize"):
        (folder / f"{name}.py").write_text(mark, "utf-8")
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.parametrize(
    "path", others_nightly([None, "", ":", "/nowhere:", ".", "../trap", "{trap}"], ["/nowhere:", "{trap}"])
)
def test_the_folder_from_which_it_is_called_cannot_put_a_module_in_the_way(
    trap: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str | None
) -> None:
    """Nor if PYTHONPATH has it: by its name, or as an empty entry, which a needless colon makes."""
    if path is None:
        monkeypatch.delenv("PYTHONPATH", raising=False)
    else:
        monkeypatch.setenv("PYTHONPATH", path.format(trap=trap))
    with zenoh_parties(tmp_path / "state") as parties:
        parties.advance("t", 0.0, [], TOLD)
    assert not (trap / "mark").exists()


def test_without_that_the_folder_is_in_the_way(
    trap: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the test above guards, switched off."""
    monkeypatch.setattr(host.process, "environment", lambda own, _folder: {**own, "PYTHONPATH": str(trap)})
    with pytest.raises(PartyError, match="ended with code 1 while it started; it wrote: "):
        zenoh_parties(tmp_path / "state").__enter__()
    assert (trap / "mark").exists()


def test_a_party_runs_the_program_of_its_simulator_and_what_else_it_is_told(tmp_path: Path) -> None:
    """A checkout comes first, installed or not; other folders of PYTHONPATH stay, settings of Python's own do not."""
    root, libs, cwd = tmp_path / "checkout", tmp_path / "libs", tmp_path / "cwd"
    own = {
        "PATH": "/bin",
        "PYTHONINSPECT": "1",
        "PYTHONWARNINGS": "error",
        "PYTHONUSERBASE": "/u",
        "PYTHONPATH": os.pathsep.join(["", ".", "rel", str(cwd), str(libs), str(root), f"{libs}/../cwd"]),
    }
    assert environment(own, cwd, root) == {
        "PATH": "/bin",
        "PYTHONUSERBASE": "/u",
        "PYTHONPATH": f"{root}{os.pathsep}{libs}",
    }
    installed = Path(sysconfig.get_path("purelib"))
    assert environment({"PYTHONPATH": str(libs)}, cwd, installed) == {"PYTHONPATH": str(libs)}
    assert environment({"PYTHONPATH": ":"}, cwd, installed) == {}
    assert environment({}, root, root) == {"PYTHONPATH": str(root)}  # called from the checkout itself


# a simulator that sleeps --------------------------------------------------------------------------------------


def test_a_question_asked_again_is_answered_as_before_and_moves_nothing(
    parties: ZenohParties, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when the simulator was stopped and its own limit ran out over the answer."""
    first = parties.advance("t", 1.0, [], TOLD)
    asked: list[bytes] = []
    ask = Asker.ask

    def noted(
        self: Asker, now_s: float, telegrams: Sequence[bytes], told: bytes
    ) -> tuple[bytes, tuple[Tagged, ...]]:
        asked.append(ask(self, now_s, telegrams, told)[0])
        return asked[-1], ()

    monkeypatch.setattr(Asker, "ask", noted)
    second = parties.advance("t", 2.0, [], TOLD)
    monkeypatch.setattr(Asker, "ask", lambda *_: (asked[-1], ()))
    assert [parties.advance("t", 2.0, [], TOLD) for _ in range(3)] == [second] * 3
    monkeypatch.setattr(Asker, "ask", ask)
    assert parties.advance("t", 3.0, [], TOLD).wake_at_s == first.wake_at_s


def test_a_party_that_hangs_is_blamed(parties: ZenohParties, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(host.over_zenoh, "ANSWER_LIMIT_S", 0.0)
    (terminal,) = [p for p in psutil.Process().children() if "t" in p.cmdline()]
    terminal.suspend()
    try:
        with pytest.raises(PartyError, match=r"^point terminal t hangs for 0 s$"):
            parties.advance("t", 0.0, [], TOLD)
    finally:
        terminal.resume()


def test_a_manager_may_wait_for_its_solver_as_long_as_that_may_work() -> None:
    """Else a day with `order = "optimal"` would end on a busy machine. With another order it asks none."""
    for order in OrderRule:
        config = msgspec.structs.replace(MANAGER, dispatch=DispatchEntry(order=order))
        waits_s = [answer_limit_s(spec) for spec in device_specs(config, (), MASTER)]
        assert [limit_s > HANGS_S for limit_s in waits_s] == [order is OrderRule.OPTIMAL]


# what is left ---------------------------------------------------------------------------------------------


def processes_of(directory: Path) -> list[int]:
    """Processes that name the directory on their command line."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                line = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if str(directory).encode() in line and int(entry.name) != os.getpid():
                found.append(int(entry.name))
    return found


@needs_proc
def test_nothing_is_left_after_an_error(tmp_path: Path) -> None:
    def fail() -> None:
        with zenoh_parties(tmp_path) as parties:
            parties.advance("t", 0.0, [], TOLD)
            assert len(processes_of(tmp_path)) == 2
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert processes_of(tmp_path) == []


PARENT = """
import sys
from pathlib import Path
from this_test import TOLD, zenoh_parties
with zenoh_parties(Path(sys.argv[1])) as parties:
    parties.advance("t", 0.0, [], TOLD)
    print("up", flush=True)
    sys.stdin.read()
"""


@needs_proc
def test_devices_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "this_test.py").write_text(
        Path(__file__).read_text(encoding="utf-8"), encoding="utf-8"
    )
    script = tmp_path / "code" / "parent.py"
    script.write_text(PARENT, encoding="utf-8")
    state = tmp_path / "state"
    with subprocess.Popen(
        [sys.executable, str(script), str(state)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    ) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"up\n"
        devices = [pid for pid in processes_of(state) if pid != parent.pid]
        assert len(devices) == 2
        handles = [os.pidfd_open(pid) for pid in devices]
        parent.send_signal(signal.SIGKILL)
    for handle in handles:
        # A pidfd becomes readable when its process ends; no sleep, only a limit.
        assert select.select([handle], [], [], 20.0)[0] == [handle]
        os.close(handle)


def test_a_device_that_cannot_start_says_why(tmp_path: Path) -> None:
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "durable").write_bytes(b"damaged")
    with pytest.raises(
        PartyError, match=r"^point terminal t ended with code 2 while it started; it wrote: .*undamaged"
    ):
        zenoh_parties(tmp_path).__enter__()
    assert processes_of(tmp_path) == []
