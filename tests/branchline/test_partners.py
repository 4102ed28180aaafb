"""No option is ignored in silence: what its help says that it goes with is asked for, in every command."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from typer.core import TyperCommand, TyperGroup, TyperOption

from branchline.cli import whole_command
from network.errors import InputError
from tests.conftest import Ended


def commands(command: object, name: str = "") -> Iterator[tuple[str, TyperCommand]]:
    if isinstance(command, TyperGroup):
        for word, other in command.commands.items():
            yield from commands(other, f"{name} {word}".strip())
    elif isinstance(command, TyperCommand):
        yield name, command


def ruled() -> Iterator[tuple[str, str]]:
    """Commands, each with an option whose help names another one that it needs."""
    for name, command in commands(whole_command()):
        for option in command.params:
            if isinstance(option, TyperOption) and re.match("With --[a-z-]+(?:,| or|:)", option.help or ""):
                yield name, option.opts[0]


def asked(name: str, *options: str) -> Callable[[], Any]:
    """A command as parsed from these options, not yet begun; its arguments are as good as any."""
    command = dict(commands(whole_command()))[name]
    needed = ["x"] * sum(param.required and not isinstance(param, TyperOption) for param in command.params)
    context = command.make_context(name, [*needed, *options])
    return lambda: command.invoke(context)


@pytest.mark.parametrize(("name", "option"), list(ruled()))
def test_an_option_without_what_it_goes_with_is_refused(name: str, option: str) -> None:
    command = dict(commands(whole_command()))[name]
    (param,) = (param for param in command.params if option in param.opts)
    value = () if getattr(param, "is_flag", False) else ("7",)
    with pytest.raises(InputError, match=r"expected --.* with it") as refused:
        asked(name, option, *value)()
    assert (refused.value.file, refused.value.key) == ("command line", option)


def test_what_was_ignored_has_its_rule() -> None:
    imports = {
        (f"import {kind}", f"--{word}")
        for kind in ("oudia", "gtfs", "mini-tokyo")
        for word in ("id", "name", "names", "add", "train", "turn-min", "outside-min", "without")
    }
    sweeps = {
        ("drill", f"--{word}") for word in ("every", "from", "to", "jobs", "faults", "sample", "resume")
    }
    runs = {("run", f"--{word}") for word in ("over", "certificates", "elsewhere", "gui-delay")}
    assert imports | sweeps | runs | {("best equipment", "--proof")} <= set(ruled())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("run", "rtri_test_line", "--over", "5"), "--over is 5.0; expected --against with it"),
        (("drill", "list", "--jobs", "3"), "--jobs is 3; expected --sweep, --sweep-kinds or --at with it"),
        (
            ("best", "interval", "a", "--check", "b", "--out", "c.toml"),
            "--check is 'b'; expected no --out with it",
        ),
        (
            ("sweep", "a", "--scheduler", "tcp://a:1", "--recycle", "9"),
            "--recycle is 9; expected no --scheduler with it",
        ),
        (("serve", "--seed", "3"), "--seed is 3; expected the name of a scenario or a drill with it"),
    ],
)
def test_it_is_one_line(main: Callable[..., Ended], arguments: tuple[str, ...], said: str) -> None:
    assert main(*arguments) == Ended(2, "", f"error: command line: {said}\n")


def test_what_comes_with_it_or_says_nothing_new_is_taken(main: Callable[..., Ended]) -> None:
    """`--every 1` is its default; a folder that is not there is refused by what looks at it."""
    assert main("drill", "list", "--every", "1").code == 0
    assert "nowhere" in main("run", "rtri_test_line", "--against", "nowhere", "--over", "5").err
