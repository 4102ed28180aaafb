"""`branchline certificates`, and `run --listen` before it waits: what they refuse."""

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from host.certificates import make_certificates

AT = "tls/127.0.0.1:17447"
FAR = ("--link", "zenoh", "--listen", AT)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (FAR, f"--listen is '{AT}'; expected --certificates, without which nobody would be let in"),
        ((*FAR, "--certificates", "nowhere"), "nowhere/authority.pem; expected a certificate"),
        ((*FAR, "--certificates", "{late}"), "expected a time that has not run out"),
        (
            (*FAR, "--certificates", "{made}", "--elsewhere", "moon"),
            "--elsewhere is 'moon'; expected a party",
        ),
        ((*FAR, "--certificates", "{made}", "--elsewhere", "A-E"), "denied is 'A-E'; expected no party"),
        ((*FAR, "--certificates", "{made}", "--elsewhere", "B-E"), "made/parties/B-E; expected its folder"),
        ((*FAR, "--certificates", "{made}", "--elsewhere", "K1"), "--elsewhere is 'K1'; expected a party"),
        (("--listen", AT), "--listen is 'tls/127.0.0.1:17447'; expected --link zenoh"),
        (("--certificates", "here"), "--certificates is 'here'; expected --listen"),
        (("--elsewhere", "K1"), "--elsewhere is 'K1'; expected --listen"),
        *(
            (("--link", "zenoh", "--listen", at), f"--listen is '{at}'; expected tls/ADDRESS:PORT")
            for at in ("tcp/127.0.0.1:17447", "127.0.0.1:17447", "tls/127.0.0.1", "tls/a:1?b", "tls/::1:7447")
        ),
    ],
)
def test_what_nobody_could_be_waited_for_with_is_refused(
    main: Callable[..., Any], tmp_path: Path, options: tuple[str, ...], said: str
) -> None:
    made, late = tmp_path / "made", tmp_path / "late"
    make_certificates(made, ["block-manager", "A-E"], "127.0.0.1")
    (made / "denied").write_text("A-E\n", "utf-8")
    make_certificates(late, ["A-E"], "127.0.0.1", 1, datetime.now(UTC) - timedelta(hours=2))
    given = [option.format(made=made, late=late) for option in options]
    ended = main("run", "rtri_test_line", "--carrier", "plain", *given, "--out", str(tmp_path / "out"))
    assert ended.code == 2
    assert said in ended.err
    assert not (tmp_path / "out").exists()


def test_days_of_learning_are_run_on_one_machine(main: Callable[..., Any], tmp_path: Path) -> None:
    make_certificates(tmp_path / "made", ["block-manager"], "127.0.0.1")
    scenario = tmp_path / "learning.toml"
    scenario.write_text('extends = "rtri_test_line"\n[tuning]\ndays = 2\n', "utf-8")
    options = (*FAR, "--certificates", str(tmp_path / "made"), "--out", str(tmp_path / "out"))
    ended = main("run", str(scenario), *options)
    assert ended.code == 2
    assert "days is 2; expected 1 with --listen" in ended.err


def test_each_party_of_a_scenario_has_its_folder(main: Callable[..., Any], tmp_path: Path) -> None:
    folder = tmp_path / "made"
    ended = main(
        "certificates", "rtri_test_line", str(folder), "--address", "simulator.example", "--hours", "2"
    )
    assert (ended.code, ended.err) == (0, "")
    assert "for 6 parties, 2 h" in ended.out
    names = {path.name for path in (folder / "parties").iterdir()}
    assert names == {"block-manager", "A-E", "A-W", "B-E", "B-W", "K1"}
    again = main("certificates", "rtri_test_line", str(folder), "--address", "simulator.example")
    assert (again.code, "expected a folder that is not there yet" in again.err) == (2, True)
