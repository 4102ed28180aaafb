"""A line of one unit, one portal and one set of points, for hosts of its devices."""

from typing import Final

from wayside.config import MANAGER_ID, ManagerConfig, PointsEntry, RouteEntry, SectionEntry, TerminalConfig

MASTER: Final = b"m" * 32
MANAGER: Final = ManagerConfig(
    "line",
    MANAGER_ID,
    ("u1",),
    (SectionEntry("P", portal=True), SectionEntry("S", terminal_ids=("t",)), SectionEntry("T")),
    (RouteEntry("R", "P", ("S", "T")),),
)
TERMINAL: Final = TerminalConfig("line", "t", (PointsEntry("p", "S", 8.0),))
