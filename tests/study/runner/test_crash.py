"""A bug in the loop, planted by name: exit code 70, one line that says what and when, the journal so far on disk."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import pytest

from host.parties import PartyError
from network.errors import InputError
from scenario.scenario import load_scenario
from simulation.journal import read_journal
from simulation.loop import Simulation
from study.runner.crash import Crashed
from study.runner.run import PartyLink, execute

PLANTED_STEP: Final = 360_500  # 10:00:50, while T1 runs
WORDS: Final = re.compile(
    r"bug: KeyError: 'planted'; scenario (\w+), seed 1, step (\d+), simulated time 10:(\d\d):(\d\d\.\d);"
    r" its journal so far and the traceback are in (\S+)"
)


def fails_while_a_train_runs(patch: pytest.MonkeyPatch) -> list[bytes]:
    """The switch: the loop raises from 10:00:50 on. Returns where the journal of that moment is put."""
    advance, told = Simulation.advance, []

    def failing(self: Simulation) -> None:
        advance(self)
        if self.step >= PLANTED_STEP:
            told.append(self.journal.to_bytes())
            raise KeyError("planted")

    patch.setattr(Simulation, "advance", failing)
    return told


def check_kept(folder: Path, told: list[bytes]) -> None:
    """All entries up to the bug, and the traceback; nothing else, as that is no whole run."""
    assert sorted(path.name for path in folder.iterdir()) == ["crash.txt", "journal.jsonl"]
    assert (folder / "journal.jsonl").read_bytes() == told[0]
    entries = read_journal(folder / "journal.jsonl")
    assert 36_000.0 < entries[-1].t_s <= 36_000.0 + 120.0
    trace = (folder / "crash.txt").read_text("utf-8")
    assert "KeyError: 'planted'" in trace and "in failing" in trace


@pytest.mark.parametrize(
    ("arguments", "scenario", "folder"),
    [
        (("run", "rtri_test_line", "--out", "a/run"), "rtri_test_line", "a/run"),
        (("run", "rtri_test_line", "--json"), "rtri_test_line", "runs/rtri_test_line"),
        (("drill", "rtri/13_tag_not_read", "--out", "a/drill"), "rtri_13_tag_not_read", "a/drill"),
        (("drill", "rtri/13_tag_not_read"), "rtri_13_tag_not_read", "runs/rtri_13_tag_not_read-crash"),
    ],
)
def test_a_bug_is_one_line_and_leaves_the_journal(
    main: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    arguments: tuple[str, ...],
    scenario: str,
    folder: str,
) -> None:
    told = fails_while_a_train_runs(monkeypatch)
    ended = main(*arguments)
    assert ended.code == 70
    if "--json" in arguments:
        assert ended.figures()["outcome"] == "bug" and ended.figures()["message"] in ended.err
    else:
        assert ended.out == ""
    said = WORDS.fullmatch(ended.err.splitlines()[-1])
    assert said is not None, ended.err
    assert (said[1], said[5]) == (scenario, str(tmp_path / folder))
    assert int(said[2]) >= PLANTED_STEP
    assert int(said[2]) / 10.0 == pytest.approx(36_000.0 + 60.0 * int(said[3]) + float(said[4]))
    assert ended.err.count("bug:") == 1 and "Traceback" not in ended.err
    check_kept(tmp_path / folder, told)


def test_a_reproduction_names_the_bug_of_its_run(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    told = fails_while_a_train_runs(monkeypatch)
    ended = main("reproduce", "sugiyama-table5", "--quick", "--json")
    assert (ended.code, ended.figures()["outcome"]) == (70, "bug")
    assert "bug: KeyError: 'planted'; scenario rtri_" in ended.err and "Traceback" not in ended.err
    (folder,) = (tmp_path / "runs").iterdir()
    check_kept(folder, told)


def test_the_run_before_is_not_lost_to_a_folder_that_holds_something_else(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Nobody's work is overwritten by what a bug leaves: it goes to a folder for temporary files."""
    told = fails_while_a_train_runs(monkeypatch)
    mine = tmp_path / "runs" / "rtri_13_tag_not_read-crash" / "thesis.tex"
    mine.parent.mkdir(parents=True)
    mine.write_text("work", "utf-8")
    ended = main("drill", "rtri/13_tag_not_read")
    assert ended.code == 70
    assert mine.read_text("utf-8") == "work"
    check_kept(Path(ended.err.splitlines()[-1].rpartition(" ")[2]), told)


def test_bad_input_is_no_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(_: Simulation) -> str:
        raise InputError("file", "key", 1, "another")

    monkeypatch.setattr(Simulation, "settle", refuses)
    with pytest.raises(InputError, match="another"):
        execute(load_scenario("rtri_test_line"), PartyLink.SIMULATED)


def test_a_party_that_is_down_in_this_process_is_a_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over Zenoh it is a process that has died (tests/system); here the simulator has asked for what it had killed."""

    def down(_: Simulation) -> str:
        raise PartyError("party K1 is down")

    monkeypatch.setattr(Simulation, "settle", down)
    with pytest.raises(Crashed, match="PartyError: party K1 is down; scenario rtri_test_line, seed 1, step"):
        execute(load_scenario("rtri_test_line"), PartyLink.SIMULATED)


def test_a_bug_outside_a_run_is_one_line_too(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*_: object) -> None:
        raise ValueError("planted\nin two lines")

    monkeypatch.setattr("study.runner.run.write_report", failing)
    ended = main("run", "rtri_test_line", "--carrier", "plain", "--json")
    assert (ended.code, ended.figures()["outcome"]) == (70, "bug")
    last = ended.err.splitlines()[-1]
    assert last.startswith("bug: ValueError: planted in two lines; the traceback is in ")
    assert "ValueError: planted" in Path(last.rpartition(" ")[2]).read_text("utf-8")
    assert "Traceback" not in ended.err


def test_the_planted_bug_is_what_ends_it(main: Callable[..., Any]) -> None:
    """Without it the same command is good."""
    ended = main("run", "rtri_test_line", "--json")
    assert ended.code == 0
    assert json.loads(ended.out)["trains_arrived"] == 1
