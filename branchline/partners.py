"""Options that do nothing without another one, or beside it. Their help is the rule: it begins `With --other: ...`, or
`With --one, --other or --third: ...`, of which one must be given, or `Without --other: ...`, of which none may be.
"""

from __future__ import annotations

import re
from functools import wraps
from typing import Any, Final, TypeVar

from typer.core import TyperCommand, TyperGroup, TyperOption

from network.errors import COMMAND_LINE, InputError

CommandT = TypeVar("CommandT")
_RULE: Final = re.compile(r"(With|Without) (--[a-z-]+(?:(?:, | or )--[a-z-]+)*): ")


def with_partners(command: CommandT) -> CommandT:
    """It and all that it consists of, which now refuse what they would not look at. InputError when one is called."""
    if isinstance(command, TyperGroup):
        for other in command.commands.values():
            with_partners(other)
    elif isinstance(command, TyperCommand) and (run := command.callback) is not None:
        options = [param for param in command.params if isinstance(param, TyperOption)]

        @wraps(run)
        def checked(**values: Any) -> Any:  # noqa: ANN401 - whatever the command's own are
            check_partners(options, values)
            return run(**values)

        command.callback = checked
    return command


def check_partners(options: list[TyperOption], values: dict[str, Any]) -> None:
    """InputError for an option that is not looked at, by the values of all by name."""
    given = {option.opts[0]: values[option.name or ""] for option in options if _is_given(option, values)}
    for option in options:
        rule = _RULE.match(option.help or "")
        if rule is None or (name := option.opts[0]) not in given:
            continue
        value = ", ".join(map(str, given[name])) if isinstance(given[name], list) else given[name]
        there = [other for other in re.split(", | or ", rule[2]) if other in given]
        if rule[1] == "With" and not there:
            raise InputError(COMMAND_LINE, name, value, f"{rule[2]} with it")
        if rule[1] == "Without" and there:
            raise InputError(COMMAND_LINE, name, value, f"no {there[0]} with it")


def _is_given(option: TyperOption, values: dict[str, Any]) -> bool:
    """Whether it says something else than without it; what it says in vain then changes nothing."""
    value = values[option.name or ""]
    return value != option.default and value not in (None, ())
