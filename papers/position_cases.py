"""The cases of `position-operations`: what trains carry, and what fails; each a scenario's tables in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

LATER_S: Final = 60.0
SOON_S: Final = 15.0
BY_THE_DRIVER: Final = (
    "where no fix comes between ① and the mark, the driver says so within 20 s of the stand"
)
BY_FIXES: Final = "the first fix beyond ① whose whole interval is, at 5 to 10 m/s"
UNITS: Final = ("V1", "V2", "V3", "V4")
HOUR_FROM: Final = "08:00"
HOUR_S: Final = 3600.0


@dataclass(frozen=True, slots=True)
class PositionCase:
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


def carried_table(*names: str) -> str:
    """The table of what trains carry."""
    listed = ", ".join(f'"{name}"' for name in names)
    return f"[sensors]\ncarries = [{listed}]\n"


def failing(kind: str, targets: tuple[str, ...] = UNITS, more: str = "") -> str:
    """A fault for an hour of the morning."""
    return "".join(
        f'[[fault]]\nkind = "{kind}"\ntarget = "{target}"\nstart = "{HOUR_FROM}"\nduration_s = {HOUR_S}\n{more}'
        for target in targets
    )


FEWER_TAGS: Final = '[patch.line]\nremove_tags = { purpose = "position", near_marks_m = 200.0 }\n'
MOVED_TAG: Final = """[belief.line]
remove = { tags = [404] }
add = { tags = [{ id = 404, section = "HSK-OGN", km = 8.192, purpose = "position", directions = ["down"] }] }
"""
MARKERS: Final = """[patch.line.add]
markers = [
  { id = 1, section = "HSK.1", km = -0.040, directions = ["down"], pattern = 1 },
  { id = 2, section = "HSK.1", km = 0.040, directions = ["up"], pattern = 2 },
  { id = 3, section = "HSK-OGN", km = 3.651, directions = ["down"], pattern = 3 },
  { id = 4, section = "HSK-OGN", km = 3.731, directions = ["up"], pattern = 4 },
  { id = 5, section = "HSK-OGN", km = 5.726, directions = ["down"], pattern = 5 },
  { id = 6, section = "HSK-OGN", km = 5.806, directions = ["up"], pattern = 6 },
  { id = 7, section = "HSK-OGN", km = 8.117, directions = ["down"], pattern = 7 },
  { id = 8, section = "HSK-OGN", km = 8.197, directions = ["up"], pattern = 8 },
  { id = 9, section = "OGN.1", km = 12.560, directions = ["down"], pattern = 9 },
  { id = 10, section = "OGN.2", km = 12.640, directions = ["up"], pattern = 10 },
  { id = 11, section = "OGN-KRS", km = 15.054, directions = ["down"], pattern = 11 },
  { id = 12, section = "OGN-KRS", km = 15.134, directions = ["up"], pattern = 12 },
  { id = 13, section = "OGN-KRS", km = 17.335, directions = ["down"], pattern = 13 },
  { id = 14, section = "OGN-KRS", km = 17.415, directions = ["up"], pattern = 14 },
  { id = 15, section = "KRS.1", km = 20.197, directions = ["down"], pattern = 15 },
]
"""
AIM: Final = '[gnss]\ncorrection = "aim"\n'
CASES: Final = (
    PositionCase("tags", "tags, as the line stands", carried_table("tags"), quick=True),
    PositionCase("fewer_tags", "tags, without those before the marks", carried_table("tags") + FEWER_TAGS),
    PositionCase(
        "tags_curvature",
        "fewer tags, and curvature",
        carried_table("tags", "curvature") + FEWER_TAGS,
        SOON_S,
        "the arrival tags are there",
    ),
    PositionCase(
        "curvature", "curvature alone", carried_table("curvature"), LATER_S, BY_THE_DRIVER, quick=True
    ),
    PositionCase(
        "gnss_20", "satellites, fail-safe within 20 m", carried_table("gnss"), SOON_S, BY_FIXES, quick=True
    ),
    PositionCase("gnss_aim", "satellites, the aim of 3 m", carried_table("gnss") + AIM, SOON_S, BY_FIXES),
    PositionCase(
        "curvature_gnss",
        "curvature and satellites within 20 m",
        carried_table("curvature", "gnss"),
        SOON_S,
        BY_FIXES,
    ),
    PositionCase(
        "lidar",
        "markers 60 m before each mark",
        carried_table("lidar") + MARKERS,
        SOON_S,
        "markers lie beyond ①",
    ),
    PositionCase(
        "all",
        "all of them",
        carried_table("tags", "curvature", "gnss", "lidar") + MARKERS,
        SOON_S,
        BY_FIXES,
        quick=True,
    ),
    # an hour, or a morning, of something wrong
    PositionCase(
        "tags_missed", "tags: an arrival tag is not read", carried_table("tags") + failing("miss", ("506",))
    ),
    PositionCase(
        "tags_moved", "tags: one lies 30 m from where units have it", carried_table("tags") + MOVED_TAG
    ),
    PositionCase(
        "gyro_dead", "curvature alone: no gyro works", carried_table("curvature") + failing("gyro_dead")
    ),
    PositionCase(
        "gnss_jammed", "satellites within 20 m: jammed", carried_table("gnss") + failing("gnss_jammed")
    ),
    PositionCase(
        "both_jammed",
        "curvature and satellites: these jammed",
        carried_table("curvature", "gnss") + failing("gnss_jammed"),
        LATER_S,
        BY_THE_DRIVER,
    ),
    PositionCase(
        "slippery",
        "curvature and satellites on slippery rail",
        carried_table("curvature", "gnss") + failing("slippery", more="factor = 0.4\n"),
    ),
)
