"""Arguments of the verbs, checked against their annotations: who calls from Python has no parser before them."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, Literal, ParamSpec, TypeVar, get_args, get_origin, get_type_hints

from network.errors import InputError
from network.files.toml_input import one_of

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
_NUMBERS: Final[dict[type, type]] = {int: Integral, float: Real}  # numpy's are among them, bools are not
_NAMES: Final[dict[type, str]] = {
    int: "a whole number",
    float: "a number",
    str: "a text",
    bool: "True or False",
    Path: "a path",
    NoneType: "None",
}


def checked_call(verb: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """The same verb; InputError naming verb and argument for a value that is not of its annotation."""
    parameters = signature(verb)

    @wraps(verb)
    def checked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        hints = get_type_hints(verb)
        for name, value in parameters.bind(*args, **kwargs).arguments.items():
            kind = parameters.parameters[name].kind
            if name in hints and kind is not Parameter.VAR_KEYWORD:
                for each in value if kind is Parameter.VAR_POSITIONAL else (value,):
                    _check(f"branchline.{verb.__name__}", name, each, hints[name])
        return verb(*args, **kwargs)

    return checked


def _check(verb: str, name: str, value: object, hint: Any) -> None:  # noqa: ANN401 - whatever a parameter says
    choices = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    if not any(_is_of(value, choice) for choice in choices):
        raise InputError(verb, name, value, " or ".join(map(_name, choices)))


def _is_of(value: object, hint: Any) -> bool:  # noqa: ANN401
    if get_origin(hint) is Literal:
        return value in get_args(hint)
    if hint in _NUMBERS:
        return isinstance(value, _NUMBERS[hint]) and not isinstance(value, bool)
    return isinstance(value, hint)


def _name(hint: Any) -> str:  # noqa: ANN401
    if get_origin(hint) is Literal:
        return one_of(get_args(hint))
    name: str = hint.__name__
    return _NAMES.get(hint, name)
