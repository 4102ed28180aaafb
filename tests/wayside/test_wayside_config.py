"""Fixed data of the devices from a line: who drives what, who may leave where."""

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction, Line, Points, Position, Route, Section, SectionKind
from wayside.config import MANAGER_ID, PointsEntry, RouteEntry, SectionEntry, manager_config, terminal_configs


def points(points_id: str, section_id: str, terminal_id: str, throw_time_s: float) -> Points:
    return Points(points_id, section_id, terminal_id, "n", Direction.DOWN, "a", "b", "c", throw_time_s, 10.0)


LINE = Line(
    "line",
    "A line",
    "線",
    20.0,
    stations={},
    alignments={},
    sections={
        "P": Section("P", SectionKind.PORTAL, ("p",)),
        "S": Section("S", SectionKind.POINTS, ("s",)),
        "T": Section("T", SectionKind.TRACK, ("t",)),
    },
    pieces={},
    points={
        "w1": points("w1", "S", "west", 6.0),
        "w2": points("w2", "S", "west", 5.0),
        "x1": points("x1", "S", "extra", 6.0),
    },
    tags={},
    assumed=(),
)
ROUTE = Route("R", Direction.DOWN, "P", "T", ("S", "T"), ("p", "s", "t"), (("w1", Position.NORMAL),))


def test_manager() -> None:
    config = manager_config(LINE, [ROUTE], ["u1", "u2"])
    assert (config.line_id, config.device_id, config.unit_ids) == ("line", MANAGER_ID, ("u1", "u2"))
    assert config.sections == (
        SectionEntry("P", portal=True),
        SectionEntry("S", terminal_ids=("extra", "west")),
        SectionEntry("T"),
    )
    assert config.routes == (RouteEntry("R", "P", ("S", "T")),)


def test_terminals_have_their_points_and_time_to_throw_them() -> None:
    extra, west = terminal_configs(LINE)
    assert (extra.device_id, west.device_id) == ("extra", "west")
    assert west.points == (PointsEntry("w1", "S", 10.0), PointsEntry("w2", "S", 8.5))


def test_a_train_may_wait_on_open_line_that_the_radio_reaches_from_end_to_end() -> None:
    """Of the Karasuyama line the radio reaches the surroundings of stations, of the paper's test line all."""
    for line_id, opens, hears in (
        ("karasuyama", {"HSK-OGN", "OGN-KRS"}, set[str]()),
        ("rtri_test_line", {"1", "6", "11"}, {"1", "6", "11"}),
    ):
        config = manager_config(load_line(shipped_line(line_id)), [], [])
        assert {entry.section_id for entry in config.sections if entry.open_line} == opens
        assert {entry.section_id for entry in config.sections if entry.hears} == hears
