"""Key expressions and configuration of the two planes, secrets, and the private folder of the socket."""

import os
import stat
from pathlib import Path

import msgspec
import pytest
import zenoh

import host.planes
from host.parties import PartyError
from host.planes import (
    LOCK_SUFFIX,
    SOCKET_NAME,
    SOCKET_PATH_BYTES_MAX,
    endpoint_of,
    new_secrets,
    private_folder,
    radio_key,
    said_key,
    session_json5,
    time_key,
)
from network.errors import InputError
from radio.keys import KEY_BYTES, KeyRing

KEYS = KeyRing("t", {}, {})


def test_keys() -> None:
    assert radio_key("karasuyama", "t1") == "branchline/karasuyama/radio/t1"
    assert said_key("karasuyama", "t1", "u1") == "branchline/karasuyama/said/t1/u1"
    assert said_key("karasuyama", "t1") == "branchline/karasuyama/said/t1/*"
    assert time_key("karasuyama", "t1") == "branchline/karasuyama/time/t1"


@pytest.mark.parametrize("name", ["", "a/b", "a*", "a b", "a?b", "$x", "#"])
def test_names_that_would_change_the_key_are_refused(name: str) -> None:
    with pytest.raises(InputError, match="an id without"):
        time_key("line", name)


def test_a_session_scouts_for_nobody_and_knows_one_way_only() -> None:
    config = msgspec.json.decode(session_json5("connect", "unixsock-stream/z", "abc"))
    assert config["scouting"] == {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    assert config["listen"] == {"endpoints": []}
    assert config["transport"]["link"]["protocols"] == ["unixsock-stream"]


def test_who_was_stopped_for_a_day_has_lost_no_link() -> None:
    """Nothing is heard of a stopped process; a link ends with the process, not with silence."""
    tx = msgspec.json.decode(session_json5("listen", "unixsock-stream/z", "1"))["transport"]["link"]["tx"]
    assert tx["lease"] > 24 * 3600 * 1000


def test_secrets_are_drawn_and_the_session_has_a_name_that_zenoh_keeps() -> None:
    drawn = [new_secrets(KEYS) for _ in range(50)]
    assert len({secrets.plane_key for secrets in drawn}) == 50
    assert all(len(secrets.plane_key) == KEY_BYTES for secrets in drawn)
    assert all(len(secrets.session_id) == 32 and secrets.session_id[0] != "0" for secrets in drawn)
    with private_folder() as folder:
        config = session_json5("listen", endpoint_of(folder), drawn[0].session_id)
        with zenoh.open(zenoh.Config.from_json5(config)) as session:
            assert str(session.info.zid()) == drawn[0].session_id


def test_the_folder_of_the_socket_is_its_owners_alone_and_goes(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        with private_folder(tmp_path) as folder:
            assert folder.parent == tmp_path
            assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    finally:
        os.umask(before)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["long", "長"])
def test_a_folder_too_deep_for_a_socket_is_not_taken(tmp_path: Path, name: str) -> None:
    """The limit is in bytes, and the lock that Zenoh puts beside the socket has to fit too."""
    deep = tmp_path / (name * (SOCKET_PATH_BYTES_MAX // len(name.encode())))
    deep.mkdir()
    with private_folder(deep) as folder:
        assert deep not in folder.parents
        assert len(bytes(folder / (SOCKET_NAME + LOCK_SUFFIX))) <= SOCKET_PATH_BYTES_MAX
    assert list(deep.iterdir()) == []


def test_the_longest_path_that_fits_is_one_on_which_zenoh_listens(tmp_path: Path) -> None:
    """One byte more is refused before Zenoh is asked."""
    made = len(b"/bl-xxxxxxxx/") + len(SOCKET_NAME + LOCK_SUFFIX)
    room = SOCKET_PATH_BYTES_MAX - made - len(bytes(tmp_path)) - 1
    if room < 1:
        pytest.skip("the folder for temporary files is too deep for this test")
    for length, fits in ((room, True), (room + 1, False)):
        base = tmp_path / ("x" * length)
        base.mkdir()
        with private_folder(base) as folder:
            assert (folder.parent == base) is fits
            config = zenoh.Config.from_json5(session_json5("listen", endpoint_of(folder), "1"))
            with zenoh.open(config):
                assert stat.S_ISSOCK((folder / SOCKET_NAME).stat().st_mode)


def test_where_no_folder_is_short_enough_the_person_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deep = tmp_path / ("x" * SOCKET_PATH_BYTES_MAX)
    deep.mkdir()
    monkeypatch.setattr(host.planes, "SHORT_FOLDERS", ())
    with pytest.raises(PartyError, match="set TMPDIR to a shorter one"), private_folder(deep):
        pass
