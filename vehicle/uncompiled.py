"""Functions to be compiled, before anybody calls them: most commands call none, and the compiler is slow to load."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
from types import FunctionType
from typing import Any, Final


class Uncompiled:
    """A function that `make` makes callable by machine code, when it is called or the compiler looks at it."""

    def __init__(self, function: FunctionType, make: Callable[[FunctionType], Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._make = make

    @cached_property
    def made(self) -> Any:  # noqa: ANN401 - a dispatcher of numba, which is not loaded here
        """What is called."""
        return self._make(self.py_func)

    def __call__(self, *args: object, **kwargs: object) -> object:
        """Call it."""
        return self.made(*args, **kwargs)

    def __getattr__(self, name: str) -> object:
        """Whatever else is asked is asked of what is called: its type as the compiler has it, what it has compiled."""
        return getattr(self.made, name)


LATE: Final[dict[str, Uncompiled]] = {}  # those that compiled code calls by address, the last of each name
