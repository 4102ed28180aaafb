"""The cases of `position-operations`: what trains carry, and what fails; each a scenario's tables in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

LATER_S: Final = 60.0
SOON_S: Final = 10.0
BY_THE_DRIVER: Final = (
    "where no fix comes between arrival tag and mark, the driver says within 20 s of the stand"
)
BY_FIXES: Final = "a fix a second, as soon as its whole interval lies beyond the tag's place"
UNITS: Final = ("V1", "V2", "V3", "V4")


@dataclass(frozen=True, slots=True)
class Case:
    """One case. `later_s`: how much later than with tags 95 % of the sections may be released; None: not judged."""

    name: str
    title: str
    tables: str
    later_s: float | None = None
    why: str = ""
    quick: bool = False

    def text(self, extends: str) -> str:
        """The scenario's file."""
        head = f'extends = "{extends}"\nid = "{self.name}"\nname = "{self.title}"\n'
        return head + self.tables


def carries(*names: str) -> str:
    """The table of what trains carry."""
    listed = ", ".join(f'"{name}"' for name in names)
    return f"[sensors]\ncarries = [{listed}]\n"


def failing(kind: str, targets: tuple[str, ...] = UNITS, more: str = "") -> str:
    """A fault for an hour of the morning."""
    return "".join(
        f'[[fault]]\nkind = "{kind}"\ntarget = "{target}"\nstart = "08:00"\nduration_s = 3600.0\n{more}'
        for target in targets
    )


WITHOUT_POSITION_TAGS: Final = '[patch.line]\nremove_tags = { purpose = "position", near_marks_m = 200.0 }\n'
CASES: Final = (
    Case("tags", "tags, as the line stands", carries("tags"), quick=True),
    Case("fewer_tags", "tags, without those before the marks", WITHOUT_POSITION_TAGS + carries("tags")),
)
