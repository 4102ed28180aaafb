"""Grounds with what the other families leave out, each by chance: virtual blocks, overlaps, two radio networks, markers
for a LiDAR, batteries with chargers, and sets that go there and back and there again, which a dispatcher may cut.

Lines are the test line and those that are drawn, changed by a patch of the scenario.
"""

import tomllib
from functools import cache
from typing import Any, Final

from network.errors import InputError
from network.files.line_file import parse_line
from network.files.shipped import shipped_line
from network.model import Direction, Line, SectionKind
from onboard.localisation.marker_patterns import PATTERNS
from tests.system.chaos.draw import Draw
from tests.system.chaos.ground import Ground, timetable_table
from tests.system.chaos.lines import DrawnLine, drawn_line
from tests.system.chaos.timetables import TEST_LINE_STOPS, there_and_back, trains_on
from tests.system.chaos.toml_text import toml_of

WIDE: Final = 72  # grounds
TEST_LINE_P: Final = 0.25
CROSSED_P: Final = 0.3
BLOCKS_P, BLOCKS_MAX = 0.6, 5
OVERLAP_P: Final = 0.4
# to the points of some tracks, of all, and with points behind points
OVERLAPS_M: Final = (60.0, 120.0, 200.0)
SECOND_P: Final = 0.5
SECOND_AIR: Final = {"delay_min_s": 0.2, "delay_mean_s": 0.4, "loss_good_p": 0.02}
MARKERS_P: Final = 0.6
MARKER_M: Final = 60.0  # before the mark
MARKERS_EVERY_M: Final = 700.0  # on open line, beyond what a LiDAR sees
BATTERY_P: Final = 0.3
CHARGER_P: Final = 0.6
AGAIN_P: Final = 0.7
SWEPT_S: Final = (
    14_400.0  # after the last planned time: trains that sweep the whole line on sight, one after the other
)
TRIES: Final = 50
Row = dict[str, Any]
Rows = list[Row]


@cache
def wide_ground(number: int) -> Ground:
    """The ground of a number."""
    draw = Draw(number, ("wide",))
    on_test_line = draw.of("test line").chance(TEST_LINE_P)
    crossed = draw.of("crossed").chance(CROSSED_P)
    drawn = (
        None if on_test_line else line_that_can_be(f"wide_line_{number}", draw.of("line"), crossed=crossed)
    )
    text = shipped_line("rtri_test_line").read_text("utf-8") if drawn is None else drawn.text
    line, stops = parse_line(text, "line"), TEST_LINE_STOPS if drawn is None else drawn.stops
    second = draw.of("second network").chance(SECOND_P) or bool(drawn and drawn.second_network)
    battery = drawn is not None and draw.of("battery").chance(BATTERY_P)
    if battery and (chargers := _chargers(line, draw.of("chargers"))):
        text += toml_of({"chargers": chargers})
    head: dict[str, Any] = {
        "line": f"{drawn.id}.toml" if drawn else "rtri_test_line",
        "timetable": f"wide_{number}_times.toml",
        "assumed": ["everything: drawn by chance"],
        "trains": {"default": "ev_e301"},
        "limits": {"time_limit_s": SWEPT_S},
        "patch": {"line": _patch(line, draw, _reach(text), second=second)},
        **({"second_air": SECOND_AIR} if second else {}),
        **({"battery": _battery(draw.of("charge"))} if battery else {}),
    }
    trains = trains_on(stops, draw.of("times"))
    if draw.of("again").chance(AGAIN_P):
        trains = there_and_back(trains, stops, draw.of("there and back"))
        head["dispatch"] = {"certificate": True}  # without, two sets that are late may block each other
    times = toml_of(timetable_table(f"wide_{number}_times", line.id, trains))
    files = {f"{drawn.id}.toml": text} if drawn else {}
    return Ground(f"wide_{number}", head, files | {f"wide_{number}_times.toml": times})


def line_that_can_be(name: str, draw: Draw, *, crossed: bool) -> DrawnLine:
    """The first line drawn that is none for which the rule of the tags, or netconvert, finds no room."""
    for attempt in range(TRIES):
        try:
            return drawn_line(name, draw.of(str(attempt)), crossed=crossed)
        except (InputError, ValueError):
            continue
    raise RuntimeError(f"no line in {TRIES} tries: {name}")


def _reach(text: str) -> Row:
    """From end to end of a line, as its file has it."""
    (alignment,) = tomllib.loads(text)["alignments"]
    return {key: alignment[key] for key in ("from_km", "to_km")}


def _patch(line: Line, draw: Draw, whole: Row, *, second: bool) -> dict[str, Any]:
    (alignment,) = line.alignments.values()
    sets: dict[str, Any] = {}
    adds: dict[str, Rows] = {}
    blocks = draw.of("blocks")
    if blocks.chance(BLOCKS_P):
        # a train asks for its next block where it stands
        sets[f"alignments.{alignment.id}.coverage"] = [whole]
        for section in line.sections.values():
            if section.kind is SectionKind.BETWEEN:
                sets[f"sections.{section.id}.virtual_blocks"] = blocks.whole(1, BLOCKS_MAX)
    if draw.of("overlap").chance(OVERLAP_P):
        sets["line.overlap_m"] = draw.of("overlap", "m").one_of(OVERLAPS_M)
    if second:
        sets[f"alignments.{alignment.id}.second_coverage"] = [whole]
    if draw.of("markers").chance(MARKERS_P):
        adds["markers"] = _markers(line)
    return {"set": sets, "add": adds}


def _markers(line: Line) -> Rows:
    """Before each mark, and here and there on open line, for trains of either direction."""
    places: list[tuple[str, float, Direction]] = []
    for station in line.stations.values():
        for track in station.tracks:
            piece = line.pieces[track.piece_id]
            for direction, mark_m in track.marks_m.items():
                at_m = mark_m - MARKER_M if direction is Direction.DOWN else mark_m + MARKER_M
                if piece.from_m + 1.0 < at_m < piece.to_m - 1.0:
                    places.append((track.section_id, at_m, direction))
    for section in line.sections.values():
        if section.kind is not SectionKind.BETWEEN:
            continue
        (piece_id,) = section.piece_ids
        piece = line.pieces[piece_id]
        at_m = piece.from_m + MARKERS_EVERY_M / 2.0
        while at_m < piece.to_m - MARKER_M:
            free = all(
                section_id != section.id or abs(other_m - at_m) > MARKER_M
                for section_id, other_m, _ in places
            )
            places += [(section.id, at_m, direction) for direction in Direction if free]
            at_m += MARKERS_EVERY_M
    return [
        {
            "id": k,
            "section": section_id,
            "km": round(at_m) / 1000.0,
            "directions": [direction.name.lower()],
            "pattern": 1 + k % PATTERNS,
        }
        for k, (section_id, at_m, direction) in enumerate(places, 1)
    ]


def _chargers(line: Line, draw: Draw) -> Rows:
    """At some of the stations where trains wait for each other: who waits elsewhere keeps what its way takes."""
    return [
        {
            "station": station.id,
            "power_kw": draw.of(station.id).between(100.0, 400.0, 0),
            "voltage_v": 1500.0,
            "origin": "assumed: drawn by chance",
        }
        for station in line.stations.values()
        if not station.is_halt and draw.of(station.id, "has").chance(CHARGER_P)
    ]


def _battery(draw: Draw) -> Row:
    """Enough to begin with; on a cold day a stand of an hour or two uses it up."""
    return {"start_share": draw.between(0.75, 1.0, 2), "heating_kw": draw.of("heating").between(0.0, 24.0, 0)}
