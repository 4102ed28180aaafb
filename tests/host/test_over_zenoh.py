"""Parties as processes: nobody else can speak, hear or join unnoticed, and nothing is left afterwards."""

from __future__ import annotations

import os
import select
import signal
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import psutil
import pytest
import zenoh

import host.lockstep
import host.over_zenoh
from host.devices import CODEC, DeviceTold, device_specs
from host.over_zenoh import ZenohParties
from host.parties import ForeignError, PartyError
from host.party import Advance
from host.planes import radio_key, session_json5, time_key
from host.process import SECRETS_FILE, PartyProcess
from wayside.config import MANAGER_ID, ManagerConfig, PointsEntry, SectionEntry, TerminalConfig

pytestmark = pytest.mark.system

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
        radio_key("line", "u1"), congestion_control=zenoh.CongestionControl.BLOCK
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


def test_only_its_owner_can_reach_the_socket_and_read_the_keys(parties: ZenohParties, tmp_path: Path) -> None:
    socket = Path(parties.endpoint.removeprefix("unixsock-stream/"))
    assert stat.S_ISSOCK(socket.stat().st_mode)
    assert stat.S_IMODE(socket.stat().st_mode) == 0o600
    assert stat.S_IMODE(socket.parent.stat().st_mode) == 0o700
    for party_id in (MANAGER_ID, "t"):
        assert stat.S_IMODE((tmp_path / party_id).stat().st_mode) == 0o700
        assert stat.S_IMODE((tmp_path / party_id / SECRETS_FILE).stat().st_mode) == 0o600


def test_no_port_is_open_and_the_socket_goes_with_the_run(tmp_path: Path) -> None:
    with zenoh_parties(tmp_path) as parties:
        folder = Path(parties.endpoint.removeprefix("unixsock-stream/")).parent
        own = psutil.Process()
        for process in (own, *own.children()):
            assert [c for c in process.net_connections("inet") if c.status == psutil.CONN_LISTEN] == []
    assert not folder.exists()


def test_every_boot_has_secrets_of_its_own(parties: ZenohParties, tmp_path: Path) -> None:
    file = tmp_path / "t" / SECRETS_FILE
    before = file.read_bytes()
    parties.kill("t")
    parties.restart("t")
    assert file.read_bytes() != before
    assert (tmp_path / MANAGER_ID / SECRETS_FILE).read_bytes() not in (before, file.read_bytes())


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
    with pytest.raises(PartyError, match="party t died"):
        parties.advance("t", 0.0, [], TOLD)


def test_the_folder_from_which_it_is_called_cannot_put_a_module_in_the_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trap = tmp_path / "trap"
    trap.mkdir()
    for name in ("host", "zenoh", "wayside", "queue"):
        (trap / f"{name}.py").write_text("raise SystemExit('the wrong module')\n", "utf-8")
    monkeypatch.chdir(trap)
    unsafe = subprocess.run([sys.executable, "-m", "host.serve"], capture_output=True, check=False)
    assert b"the wrong module" in unsafe.stderr
    with zenoh_parties(tmp_path / "state") as parties:
        assert parties.alive("t")


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
        [sys.executable, str(script), str(state)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
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
    with pytest.raises(PartyError, match=r"party t ended while it started; it wrote: .*undamaged"):
        zenoh_parties(tmp_path).__enter__()
    assert processes_of(tmp_path) == []
