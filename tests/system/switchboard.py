"""The switchboard of the defects: behaviours taken away on purpose, each under the name of its function."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

import pytest

from onboard.authority import machine as authority
from onboard.authority import records as sym
from onboard.authority.tables import Handler
from study.runner.run import FinishedRun

Switch = Callable[[pytest.MonkeyPatch], None]
RunWith = Callable[..., tuple[FinishedRun, set[str]]]

FOLDER: Final = Path(__file__).parent / "defects"
TRAIN_M: Final = 40.0  # length of the train of every scenario here
K1_ON_P7_S: Final = 36_071.0  # two_trains: from here on K1 is on P7
K2_ON_P7_S: Final = 36_112.0  # and from here on K2
ON_THE_POINTS_AFTER_S: Final = 12.0  # a train that has started on sight from before them is on them

SWITCHES: Final[dict[str, Switch]] = {}


def switch(function: Switch) -> Switch:
    """Enter a switch under its name."""
    SWITCHES[function.__name__] = function
    return function


def with_handlers(
    patch: pytest.MonkeyPatch, handlers: Mapping[type[sym.Event], Callable[[Handler], Handler]]
) -> None:
    """Unit's authority: each handler of these events, whatever the standing, as the given function makes it."""
    table = dict(authority.TABLE)
    for (standing, event), handler in authority.TABLE.items():
        if event in handlers:
            table[standing, event] = handlers[event](handler)
    patch.setattr(authority, "TABLE", MappingProxyType(table))
