"""The command itself: help, usage errors, exit codes, what goes to which stream, and how it is stopped."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from typer.core import TyperGroup

from branchline.cli import ANALYSE, COMPLETION, PREPARE, READ, RESEARCH, RUN, whole_command
from host.parties import PartyError
from simulation.loop import Simulation
from simulation.result import Ending
from study.outcome import Outcome
from study.record.read_back import read_run

HEAVY = ("numba", "libsumo", "matplotlib", "polars", "numpy", "scipy", "zenoh", "cv2", "pydantic")


@pytest.mark.parametrize("module", ["branchline", "branchline.cli"])
def test_help_needs_nothing_heavy(module: str) -> None:
    asked = f"import sys, {module}; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("arguments", [("--help",), ("run", "--help"), ("import", "--help")])
def test_help_is_no_error(main: Callable[..., Any], arguments: tuple[str, ...]) -> None:
    ended = main(*arguments)
    assert (ended.code, ended.err) == (0, "")
    assert "branchline" in ended.out


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("run",), "scenario"),
        (("run", "rtri_test_line", "--bogus"), "--bogus"),
        (("run", "rtri_test_line", "--seed", "-1"), "--seed"),
        (("run", "rtri_test_line", "--seed", "one"), "--seed"),
        (("run", "rtri_test_line", "--out"), "--out"),
        (("bench", "--rounds", "0"), "--rounds"),
        (("dance",), "dance"),
        ((), "command"),
        (("--bogus",), "--bogus"),
        (("run", "rtri_test_line", "another"), "another"),
        (("run", "rtri_test_line", "--link", "string"), "--link"),
        (("run", "rtri_test_line", "--units", "moon"), "--units"),
        (("run", "rtri_test_line", "--carrier", "horse"), "--carrier"),
        (("drill",), "file"),
        (("drill", "list", "--every", "0"), "--every"),
        (("reproduce",), "name"),
        (("check",), "scenario"),
        (("compare",), "base"),
        (("compare", "one"), "OTHER"),
        (("compare", "one", "two", "--over", "much"), "--over"),
        (("schema", "a", "b"), "b"),
        (("import",), "command"),
        (("import", "dance"), "dance"),
        (("import", "geometry", "a"), "stations"),
        (("import", "mini-tokyo", "a", "--calendar"), "--calendar"),
        (("dance" * 1000,), "dance"),
        (("dance\nand\nsing",), "sing"),
    ],
)
def test_a_usage_error_is_one_line_that_names_what_is_wrong(
    main: Callable[..., Any], tmp_path: Path, arguments: tuple[str, ...], named: str
) -> None:
    ended = main(*arguments)
    assert (ended.code, ended.out) == (2, "")
    (line,) = ended.err.splitlines()
    assert line.startswith("error: command line: ")
    assert named in line
    assert len(line) < 300
    assert list(tmp_path.iterdir()) == []


def test_the_version_is_that_of_the_package(main: Callable[..., Any]) -> None:
    ended = main("--version")
    assert (ended.code, ended.out, ended.err) == (0, f"branchline {version('branchline')}\n", "")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("hea", ["headway"]),
        ("import g", ["geometry", "gtfs"]),
        ("headway --th", ["--theory"]),
        ("dance x", []),
    ],
)
def test_a_shell_is_told_what_may_follow(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, typed: str, offered: list[str]
) -> None:
    words = f"branchline {typed}"
    monkeypatch.setenv(COMPLETION, "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    ended = main()
    assert (ended.code, ended.out.split(), ended.err) == (0, offered, "")


def test_the_script_for_a_shell_asks_by_the_name_that_is_answered(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    # read as options are put together
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    monkeypatch.setattr("branchline.cli.whole_command", whole_command.__wrapped__)
    shown = main("--show-completion", "bash")
    assert shown.code == 0
    assert f"{COMPLETION}=complete_bash" in shown.out


@pytest.mark.parametrize(
    ("arguments", "outcome"),
    [
        (("check", "rtri_test_line"), Outcome.GOOD),
        (("run", "no_such_scenario"), Outcome.BAD_INPUT),
        (("run", "--bogus"), Outcome.BAD_INPUT),
        (("drill", "no_such_drill"), Outcome.BAD_INPUT),
        (("drill", "--bogus"), Outcome.BAD_INPUT),
        (("reproduce", "no_such_paper"), Outcome.BAD_INPUT),
        (("bench", "no_such_scenario"), Outcome.BAD_INPUT),
        (("check", "no_such_scenario"), Outcome.BAD_INPUT),
        (("compare", "no_such_run", "another"), Outcome.BAD_INPUT),
    ],
)
def test_one_object_says_how_it_ended(
    main: Callable[..., Any], arguments: tuple[str, ...], outcome: Outcome
) -> None:
    """Where nothing goes wrong, and where something does before anything has begun."""
    ended = main(*arguments, "--json")
    assert ended.code == outcome.code
    figures = ended.figures()
    assert figures["outcome"] == outcome.value
    if outcome is Outcome.BAD_INPUT:
        assert ended.err.endswith(f"error: {figures['message']}\n")


@pytest.mark.parametrize("arguments", [("schema",), ("--help",), ("run", "--json")])
def test_what_cannot_be_printed_was_not_said(command: tuple[str, ...], arguments: tuple[str, ...]) -> None:
    """A full disk under stdout is told, whatever the command; not a traceback at the end of the interpreter."""
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*command, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    code = Outcome.BAD_INPUT if arguments[0] == "run" else Outcome.COULD_NOT_RUN  # the first that went wrong
    assert done.returncode == code.code
    (told,) = done.stderr.splitlines()
    assert "No space left" in told or arguments[0] == "run"


def test_who_reads_no_further_ends_it_in_one_line(command: tuple[str, ...]) -> None:
    """As `branchline schema | head -1` does."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*command, "schema"], stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    assert done.stderr == "error: the reader of the output has closed it\n"


def test_a_run_for_a_person_and_its_seed(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("run", "rtri_test_line", "--carrier", "plain", "--seed", "3", "--out", "a/b")
    assert ended.code == 0
    summary = json.loads((tmp_path / "a" / "b" / "summary.json").read_text("utf-8"))
    assert summary["seed"] == 3
    for words in (
        "1 of 1 ran their whole journey",
        summary["digest"],
        f"report: {tmp_path}/a/b/report.html\n",
    ):
        assert words in ended.out
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["b"]


def test_a_run_replaces_the_run_before_it(main: Callable[..., Any], tmp_path: Path) -> None:
    digests = []
    for seed in ("1", "2"):
        ended = main("run", "rtri_test_line", "--carrier", "plain", "--seed", seed, "--out", "run", "--json")
        assert ended.figures()["out"] == str(tmp_path / "run")
        digests.append(json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))["digest"])
    assert digests[0] != digests[1]
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.fixture
def hang_up_counts() -> Iterator[None]:
    """SIGHUP as it is set at a terminal: not what nohup may have set for these tests."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.mark.usefixtures("hang_up_counts")
@pytest.mark.parametrize(
    ("number", "times", "code"),
    [(signal.SIGINT, 2, 130), (signal.SIGTERM, 2, 143), (signal.SIGHUP, 1, 129)],
)
@pytest.mark.parametrize("moment", ["branchline.whole_run.execute", "study.runner.run.write_report"])
def test_a_signal_ends_it_with_a_word_and_nothing_half_written(
    main: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    moment: str,
    number: signal.Signals,
    times: int,
    code: int,
) -> None:
    def stopped(*_: object, **__: object) -> None:
        for _time in range(times):
            os.kill(os.getpid(), number)

    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "summary.json").write_text("the run before", "utf-8")
    monkeypatch.setattr(moment, stopped)
    ended = main("run", "rtri_test_line", "--carrier", "plain", "--out", "run")
    assert (ended.code, ended.out) == (code, "")
    assert ended.err.splitlines()[-1] == "interrupted"
    assert "Traceback" not in ended.err
    assert [path.name for path in tmp_path.rglob("*")] == ["run", "summary.json"]
    assert (tmp_path / "run" / "summary.json").read_text("utf-8") == "the run before"


def test_a_failing_device_is_one_line(main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise PartyError("party OGN-W died")

    monkeypatch.setattr("branchline.whole_run.execute", fail)
    ended = main("run", "rtri_test_line")
    assert (ended.code, ended.out, ended.err) == (3, "", "error: party OGN-W died\n")


def test_check_prints_one_object(main: Callable[..., Any]) -> None:
    ended = main("check", "rtri_test_line", "--json")
    assert ended.code == 0
    assert ended.figures()["trains"] == 1
    assert "trains: 1" in main("check", "rtri_test_line").out


def test_every_command_stands_in_a_group_and_its_help_begins_with_one_short_sentence() -> None:
    whole = whole_command()
    assert isinstance(whole, TyperGroup)
    for name, command in whole.commands.items():
        assert list(whole_command(name).commands) == [name]  # put together alone
        first = (command.help or "").partition("\n\n")[0].strip()
        assert first.endswith(".") and ". " not in first and len(first) < 120, first
        assert getattr(command, "rich_help_panel", None) in {PREPARE, RUN, READ, ANALYSE, RESEARCH}


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_the_first_signal_keeps_what_was_run_so_far_with_its_report(
    main: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    turn_back: str,
    number: signal.Signals,
    code: int,
) -> None:
    settle, at_step = Simulation.settle, 10 * (5 * 3600 + 45 * 60)
    sent: list[int] = []

    def settle_and_stop(simulation: Simulation) -> Ending | None:
        if simulation.step >= at_step and not sent:
            sent.append(simulation.step)
            os.kill(os.getpid(), number)
        return settle(simulation)

    monkeypatch.setattr(Simulation, "settle", settle_and_stop)
    ended = main("run", turn_back, "--out", "run", "--json")
    summary = json.loads(ended.out)
    assert ended.code == code and not (tmp_path / "run").exists()
    kept = tmp_path / "run-incomplete"
    assert str(kept) == summary["out"] and str(kept) in ended.err.splitlines()[-1]
    assert {"report.html", "summary.json", "stops.parquet", "journal.jsonl"} <= {
        p.name for p in kept.iterdir()
    }
    assert "Traceback" not in ended.err and summary["invariants_broken"] == 0 and summary["broken"] == []
    assert summary["latest_end_s"] == sent[0] / 10 and summary["ended_because"] == Ending.STOPPED.value
    assert (summary["trains_arrived"], summary["trains_planned"]) == (0, 0)  # of two, neither due by then
    again = read_run(kept)
    came = again.tables.stops.filter(pl.col("arrival_s").is_not_null())
    assert came["station"].to_list() == ["HSK", "SHN"]


def test_what_an_exploration_counts_is_never_taken_for_a_number(main: Callable[..., Any]) -> None:
    """Of a level crossing everything is counted: `any` would be 99 times, unsaid."""
    ended = main("verify", "explore", "any", "--crossing", "barriers", "--states", "1")
    assert (ended.code, "CONFIG" in ended.err, "numbers" in ended.err) == (2, True, True)
