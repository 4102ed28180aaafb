"""One damaged input through the command, in this process, and what is wrong with how it ended."""

import io
import json
import os
import signal
import sys
import tomllib
from collections.abc import Generator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import FrameType
from typing import Final

from branchline import cli
from network.errors import EXPECTED_MAX, SHOWN_MAX
from study.outcome import Outcome
from tests.system.damaged.damages import Case
from tests.system.damaged.places import places_of, value_at

CPU_S_MAX: Final = 10.0  # of work, not of time that passes: another process may take the machine meanwhile
GOOD: Final = Outcome.GOOD.code


class _StillAtWork(BaseException):
    """The command has worked for longer than any input may take."""


@contextmanager
def bounded() -> Generator[None]:
    """An end to the work of what is inside."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise _StillAtWork

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, CPU_S_MAX)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def put(case: Case, folder: Path) -> None:
    """The files of a case, in a folder of its own."""
    for name, content in case.files.items():
        path = folder / name
        match content:
            case None:
                path.mkdir()
            case "":
                os.mkfifo(path)
            case "loop":
                path.symlink_to(name)
            case "missing":
                pass
            case "unreadable":
                path.write_bytes(b"id = 1")
                path.chmod(0)
            case str():
                path.symlink_to(content)
            case bytes():
                path.write_bytes(content)


def told(arguments: tuple[str, ...], folder: Path) -> tuple[int | str, str, str]:
    """Exit code, or what was raised, with stdout and stderr of a command in a folder."""
    out, err = io.StringIO(), io.StringIO()
    before, argv = Path.cwd(), sys.argv
    os.chdir(folder)
    sys.argv = ["branchline", *arguments]
    try:
        with redirect_stdout(out), redirect_stderr(err), bounded():
            cli.main()
        code: int | str = GOOD
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else GOOD
    except BaseException as error:  # whatever comes out of the command is what is looked for
        code = f"{type(error).__name__}: {error}"
    finally:
        os.chdir(before)
        sys.argv = argv
    return code, out.getvalue(), err.getvalue()


def faults_of(case: Case, folder: Path) -> list[str]:
    """What is wrong with how the command took the case; empty if nothing is."""
    put(case, folder)
    before = _listing(folder)
    code, out, err = told(case.bundle.arguments, folder)
    written = set(_listing(folder) - before)
    wrong = (
        [f"wrote {sorted(name for name, _ in written)}"]
        if {n for n, _ in written} - {case.bundle.out}
        else []
    )
    if code == Outcome.BAD_INPUT.code:
        wrong += _refusal(case, out, err)
        wrong += ["wrote and refused"] if written else []
    elif code == GOOD or (code == Outcome.BROKEN.code and case.bundle.arguments[0] == "check"):
        # What is within its range may yet be a plan that cannot work: check says so.
        wrong += _acceptance(case, folder, out)
    else:
        wrong.append(f"ended with {code}: {err[-300:]}")
    return wrong


def _listing(folder: Path) -> set[tuple[str, float]]:
    return {(path.name, path.lstat().st_mtime_ns) for path in folder.iterdir()}


def _refusal(case: Case, out: str, err: str) -> list[str]:
    """One line that names file, key where there is one, and what was expected; the same on stdout for JSON."""
    wrong = []
    line = err.removesuffix("\n")
    told = {"outcome": Outcome.BAD_INPUT.value, "message": line.removeprefix("error: ")}
    if "--json" in case.bundle.arguments:
        wrong += [] if json.loads(out) == told else [f"stdout says otherwise: {out[:200]}"]
    elif out:
        wrong.append(f"stdout has {out[:80]!r}")
    if not line.startswith("error: ") or not line.isprintable() or "; expected " not in line:
        wrong.append(f"no line as it should be: {err[:300]!r}")
    if not any(name in line for name in case.files):
        wrong.append(f"no file of the input is named: {line[:300]}")
    if len(line) > 200 + 6 * SHOWN_MAX + EXPECTED_MAX:
        wrong.append(f"a line of {len(line)} characters")
    if case.place is None:
        return wrong
    own = f"{case.file}: {case.place.key} is "
    blamed = f"({case.place.quantity.name})" in line
    if case.inside and own in line and blamed:
        wrong.append(f"inside its range and refused for it: {line}")
    if not case.inside and not (own in line and blamed):
        wrong.append(f"outside, but another message: {line}")
    return wrong


def _acceptance(case: Case, folder: Path, out: str) -> list[str]:
    """The result is there, and every figure of every file is in its range."""
    if case.bundle.out is not None:
        return [] if (folder / case.bundle.out).is_file() else ["good, and nothing written"]
    wrong = [] if out.count("\n") == 1 and json.loads(out) else [f"no JSON: {out[:80]!r}"]
    for name, model in case.bundle.models.items():
        path = folder / name
        if not path.is_file():
            continue
        data = tomllib.loads(path.read_text("utf-8-sig"))
        for place in places_of(model, data):  # type: ignore[type-var]
            value = value_at(data, place.path)
            if not place.holds(value):
                wrong.append(f"accepted {name}: {place.key} = {value!r}, outside {place.quantity.text()}")
    return wrong
