"""Parties on other machines: the same bytes, and nobody gets in, speaks or leaves without being told apart."""

import stat
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zenoh

import host.elsewhere
import host.over_zenoh
from host.certificates import DENIED_FILE, make_certificates, name_in
from host.devices import CODEC, DeviceTold
from host.elsewhere import INVITATION_FILE, Elsewhere
from host.local import LocalParties
from host.over_tls import PartyInvitation, access_control, tls_session_json5
from host.over_zenoh import ZenohParties
from host.parties import ForeignError, Parties, PartyBug, PartyError
from host.planes import said_key
from host.store import NotCommissioned
from network.errors import InputError
from tests.host.far_parties import (
    ADDRESS,
    EXPIRED,
    SIMULATORS,
    Machines,
    certificates_in,
    free_endpoint,
    serve_party,
    with_far,
)
from tests.host.test_parties import Script, specs
from wayside.config import MANAGER_ID

TOLD = CODEC.encode(DeviceTold())
ROUNDS = 5000  # a telegram of another session comes within this many rounds


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return certificates_in(tmp_path_factory.mktemp("certificates") / "made")


@pytest.fixture
def machines(made: Path) -> Iterator[Machines]:
    with Machines(made, ["t"]) as found:
        yield found


@pytest.fixture
def parties(machines: Machines, tmp_path: Path) -> Iterator[ZenohParties]:
    with with_far(machines, tmp_path) as found:
        yield found


def session_of(folder: Path, endpoint: str, session_id: str = "abc") -> zenoh.Session:
    config = tls_session_json5("connect", endpoint, folder, session_id)
    return zenoh.open(zenoh.Config.from_json5(config))


def ask_on(parties: ZenohParties, party_id: str = "t") -> None:
    for number in range(ROUNDS):
        parties.advance(party_id, 0.1 * number, [], TOLD)


# a right run ------------------------------------------------------------------------------------------------


def through_a_life(parties: Parties) -> list[Any]:
    """All that a script and a lost store bring out of devices."""
    found: list[Any] = list(Script(parties).run())
    parties.kill("t")
    parties.lose("t")
    with pytest.raises(NotCommissioned):
        parties.restart("t")
    assert not parties.alive("t")
    parties.commission("t", 2, b"")
    for now_s in (3.0, 4.0):  # commissioned once, it boots as often as it must
        parties.restart("t")
        found.append(parties.advance("t", now_s, [], TOLD))
        parties.kill("t")
    return found


def test_a_party_on_another_machine_says_the_same_to_the_byte(made: Path, tmp_path: Path) -> None:
    """With power cuts, a lost store and a commissioning; when the run is over its machine is told so."""
    with LocalParties(specs()) as one:
        expected = through_a_life(one)
    with Machines(made, [MANAGER_ID, "t"]) as machines:
        with with_far(machines, tmp_path) as other:
            assert through_a_life(other) == expected
        assert [machines.ended(name) for name in machines.started] == [(0, ""), (0, "")]
    assert machines.said == [
        f"waiting at {machines.elsewhere.endpoint} for {MANAGER_ID}, t; what each needs is in {made}/parties"
    ]
    assert list(tmp_path.iterdir()) == []  # neither keeps anything on this machine
    assert list(made.rglob(INVITATION_FILE)) == []


def test_invitations_are_their_owners_alone_and_go_when_nobody_waits(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modes: list[int] = []
    invite = Elsewhere.invite

    def noted(self: Elsewhere, invitation: PartyInvitation) -> None:
        invite(self, invitation)
        modes.append(stat.S_IMODE((self.folder_of("t") / INVITATION_FILE).stat().st_mode))

    monkeypatch.setattr(Elsewhere, "invite", noted)
    monkeypatch.setattr(host.over_zenoh, "JOIN_LIMIT_S", 0.0)
    with (
        Machines(made, ["t"]) as machines,
        pytest.raises(PartyError, match=r"^point terminal t was not ready within 0 s$"),
    ):
        with_far(machines, tmp_path).__enter__()
    assert modes == [0o600]
    assert list(made.rglob(INVITATION_FILE)) == []


def test_a_party_that_dies_is_named(parties: ZenohParties, machines: Machines) -> None:
    machines.started["t"].kill()
    machines.started["t"].wait()
    with pytest.raises(PartyError, match=r"^point terminal t has left the run$") as lost:
        ask_on(parties)
    assert not isinstance(lost.value, PartyBug)


def test_a_machine_whose_run_breaks_off_says_so(machines: Machines, tmp_path: Path) -> None:
    def broken() -> None:
        with with_far(machines, tmp_path):
            raise KeyError

    with pytest.raises(KeyError):
        broken()
    code, err = machines.ended("t")
    assert (code, "is lost before the run of t was over" in err) == (3, True)


def test_a_link_is_of_no_other_kind_and_ends_with_its_certificate(made: Path) -> None:
    for role in ("listen", "connect"):
        transport = msgspec.json.decode(tls_session_json5(role, "tls/a:1", made, "1"))["transport"]
        link = transport["link"]
        assert (link["protocols"], link["tls"]["close_link_on_expiration"]) == (["tls"], True)
        assert transport["unicast"]["lowlatency"] is False  # with it nobody notices that one has run out


# who is not let in ------------------------------------------------------------------------------------------


def test_who_cannot_prove_who_he_is_joins_nothing(
    parties: ZenohParties, machines: Machines, made: Path
) -> None:
    """Another authority's certificate, none, one that has run out, one that is no party's; and who is no
    simulator, or is elsewhere than its certificate says, is not believed.
    """
    endpoint, folder = machines.elsewhere.endpoint, made / "parties" / "t"
    make_certificates(made.parent / "others", ["t"], ADDRESS)
    right = msgspec.json.decode(tls_session_json5("connect", endpoint, folder, "abc"))
    shown = right["transport"]["link"]["tls"]

    def tried(change: dict[str, Any], at: str = endpoint) -> str:
        tls = {key: value for key, value in (shown | change).items() if value is not None}
        link = right["transport"]["link"] | {"tls": tls}
        config = right | {"transport": right["transport"] | {"link": link}}
        config["connect"] = right["connect"] | {"endpoints": [at]}
        try:
            with zenoh.open(zenoh.Config.from_json5(msgspec.json.encode(config).decode())):
                return "let in"
        except zenoh.ZError:
            return "refused"

    def of(other: Path) -> dict[str, str]:
        return {
            "connect_certificate": str(other / "certificate.pem"),
            "connect_private_key": str(other / "key.pem"),
        }

    no_one = {"connect_certificate": None, "connect_private_key": None, "enable_mtls": False}
    localhost, posed = endpoint.replace(ADDRESS, "localhost"), free_endpoint()
    poser = tls_session_json5("listen", posed, made / "parties" / "u1", "1")
    with ThreadPoolExecutor() as pool, zenoh.open(zenoh.Config.from_json5(poser)):
        attempts = {
            "another authority": pool.submit(tried, of(made.parent / "others" / "parties" / "t")),
            "no certificate": pool.submit(tried, no_one),
            "expired": pool.submit(tried, of(made / EXPIRED)),
            "no party's": pool.submit(tried, of(made / SIMULATORS)),
            "a party that poses as the simulator": pool.submit(tried, {}, posed),
            "another address": pool.submit(tried, {}, localhost),
        }
        assert {what: done.result() for what, done in attempts.items()} == dict.fromkeys(attempts, "refused")
    parties.advance("t", 0.0, [], TOLD)  # the run goes on
    assert tried({}) == "let in"  # and the right one would have been


def test_a_certificate_without_an_invitation_ends_the_run(
    parties: ZenohParties, machines: Machines, made: Path
) -> None:
    with (
        session_of(made / "parties" / "u1", machines.elsewhere.endpoint),
        pytest.raises(
            ForeignError, match="a foreign session has joined the run: abc with the certificate of u1"
        ),
    ):
        ask_on(parties)


def test_an_invitation_with_the_certificate_of_another_ends_the_run(
    parties: ZenohParties, machines: Machines, made: Path
) -> None:
    """Its own machine would refuse it; somebody else's program does not."""
    (session_id,) = [one for one, name in parties._sessions.items() if name == "t"]
    machines.started["t"].kill()
    machines.started["t"].wait()
    with (
        session_of(made / "parties" / "u1", machines.elsewhere.endpoint, session_id),
        pytest.raises(ForeignError, match="the session of t has joined the run with the certificate of u1"),
    ):
        ask_on(parties, MANAGER_ID)


@pytest.mark.parametrize("permission", ["deny", "allow"])
def test_what_is_not_a_partys_to_say_does_not_arrive(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, permission: str
) -> None:
    """Even if its session were not noticed. Allowed, it arrives: what the rules guard, switched off."""

    def rules(line_id: str, party_ids: frozenset[str]) -> dict[str, Any]:
        found = access_control(line_id, party_ids)
        return found if permission == "deny" else found | {"default_permission": "allow"}

    monkeypatch.setattr(host.elsewhere, "access_control", rules)
    for defence in ("of_run", "of_certificate"):
        monkeypatch.setattr(host.over_zenoh, defence, lambda _found, _expected: True)
    with Machines(made, [MANAGER_ID, "t"]) as machines, with_far(machines, tmp_path) as parties:
        machines.started[MANAGER_ID].kill()
        with session_of(made / "parties" / MANAGER_ID, machines.elsewhere.endpoint) as session:
            for sender in ("t", MANAGER_ID):  # one link keeps their order
                publisher = session.declare_publisher(
                    said_key("line", sender, f"by-{sender}"), congestion_control=zenoh.CongestionControl.BLOCK
                )
                publisher.put(b"stop")
            first = MANAGER_ID if permission == "deny" else "t"
            with pytest.raises(ForeignError, match=f"a foreign telegram to by-{first}: it has no tag"):
                ask_on(parties)


def test_a_denied_party_takes_no_part(tmp_path: Path) -> None:
    folder = certificates_in(tmp_path / "made")
    (folder / DENIED_FILE).write_text(f"{MANAGER_ID}\n\nt \n", "utf-8")
    with Machines(folder, ["t"]) as machines:
        with pytest.raises(InputError, match=r"made/denied is 't'; expected no party that is to take part"):
            with_far(machines, tmp_path).__enter__()
        assert machines.started == {}


# what is refused before it is tried -------------------------------------------------------------------------


def test_a_folder_that_would_be_refused_is_named(made: Path, tmp_path: Path) -> None:
    make_certificates(tmp_path / "a", ["t"], ADDRESS)
    make_certificates(tmp_path / "b", ["t"], ADDRESS)
    assert name_in(tmp_path / "a" / "parties" / "t") == "t"
    with pytest.raises(InputError, match=r"a; expected a folder that is not there yet"):
        make_certificates(tmp_path / "a", ["t"], ADDRESS)
    with pytest.raises(InputError, match=r"UTC'; expected a time that has not run out"):
        name_in(made / EXPIRED)
    day = datetime.now(UTC) + timedelta(hours=24, minutes=1)
    with pytest.raises(InputError, match=r"expected a time that has not run out"):
        name_in(tmp_path / "a", day)
    with pytest.raises(InputError, match=r"nowhere/authority.pem; expected a certificate"):
        name_in(tmp_path / "nowhere")
    (tmp_path / "a" / "certificate.pem").write_bytes((tmp_path / "b" / "certificate.pem").read_bytes())
    with pytest.raises(InputError, match=r"certificate.pem; expected a certificate by the authority in"):
        name_in(tmp_path / "a")
    (tmp_path / "b" / "key.pem").chmod(0o640)
    with pytest.raises(InputError, match=r"key.pem; expected a key that its owner alone can read"):
        name_in(tmp_path / "b")
    (tmp_path / "b" / "key.pem").chmod(0o600)
    for other in ((tmp_path / "a" / "key.pem").read_bytes(), b"no key"):
        (tmp_path / "b" / "key.pem").write_bytes(other)
        with pytest.raises(InputError, match=r"key.pem; expected the key of "):
            name_in(tmp_path / "b")


def test_all_that_is_made_is_its_owners_alone(tmp_path: Path) -> None:
    make_certificates(tmp_path / "made", ["t"], "host.example")
    found = [path for path in (tmp_path / "made").rglob("*") if path.is_file()]
    assert len(found) == 6
    assert {stat.S_IMODE(path.stat().st_mode) for path in found} == {0o600}
    assert stat.S_IMODE((tmp_path / "made").stat().st_mode) == 0o700
    assert [path.name for path in tmp_path.iterdir()] == ["made"]
    for name, address, expected in (
        ("x" * 65, ADDRESS, "at most 64 characters"),
        *(("t", address, "ASCII letters") for address in ("日", "nowhere..x", "10.0.0.256", "a b")),
    ):
        with pytest.raises(InputError, match=expected):
            make_certificates(tmp_path / "other", [name], address)
    assert [path.name for path in tmp_path.iterdir()] == ["made"]


@pytest.mark.parametrize(
    ("folder", "expected"),
    [
        ("parties/t", "invitation.json; expected what the simulator writes"),
        ("expired", "expected a time that has not run out"),
        ("parties/u1", "name is 'u1'; expected t, who is invited"),
    ],
)
def test_a_partys_machine_refuses_what_does_not_fit(tmp_path: Path, folder: str, expected: str) -> None:
    made = certificates_in(tmp_path / "made")
    if folder == "parties/u1":
        elsewhere = Machines(made, ["t"]).elsewhere
        elsewhere.invite(PartyInvitation(specs()[1], bytes(32), "abc"))
        (elsewhere.folder_of("t") / INVITATION_FILE).rename(made / folder / INVITATION_FILE)
    with serve_party(made / folder, free_endpoint()) as process:
        _, err = process.communicate(timeout=60.0)
    assert (process.returncode, len(err.splitlines())) == (2, 1)
    assert expected in err


def test_a_party_is_known_to_be_there_and_others_are_not(made: Path, tmp_path: Path) -> None:
    with (
        Machines(made, ["nobody"]) as machines,
        pytest.raises(
            InputError, match=rf"--elsewhere is 'nobody'; expected a party that is a process: {MANAGER_ID}, t"
        ),
    ):
        with_far(machines, tmp_path).__enter__()
    assert Machines(made, []).elsewhere.chosen(["t", "u1"]) == {"t", "u1"}
