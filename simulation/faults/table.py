"""Every fault there is: the classes of this folder that have a `kind`, file by file.

Files of drills, their checks, the injector and docs/faults.md take them from here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, Final

from simulation import faults
from simulation.faults.fault import Fault


def _kinds() -> Iterator[type[Fault[Any]]]:
    for name in sorted(each.name for each in iter_modules(faults.__path__) if each.name != "table"):
        for found in vars(import_module(f"{faults.__name__}.{name}")).values():
            if isinstance(found, type) and issubclass(found, Fault) and "kind" in found.__dict__:
                yield found


KINDS: Final = tuple(dict.fromkeys(_kinds()))
FAULTS: Final[Mapping[str, type[Fault[Any]]]] = {kind.kind: kind for kind in KINDS}
