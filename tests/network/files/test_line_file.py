from pathlib import Path

import pytest

from network.errors import InputError
from network.files.line_file import load_line, parse_line
from network.model import Direction, PointsLeg, Position, SectionKind, TagPurpose
from network.timetable import parse_timetable
from network.train_fit import usable_length_m, validate_train_fits
from tests.network.sample import SAMPLE, changed
from tests.trains import timetable_of

HALT = """[[stations]]
id = "G"
name = "Another halt"
km = 1.2
halt = true
tracks = [
  { name = "1", section = "A-B", platform_from_km = 1.5, platform_to_km = 1.7, mark_down_km = 1.63, mark_up_km = 1.57 },
]
"""


def test_units_become_si() -> None:
    line = parse_line(SAMPLE, "sample.toml")
    assert line.max_speed_mps == pytest.approx(25.0)
    assert line.points["A.11"].diverging_limit_mps == pytest.approx(10.0)
    assert line.alignments["main"].limits[0].speed_mps == pytest.approx(17.5)
    assert line.alignments["main"].to_m == 3200.0
    assert line.stations["A"].tracks[0].marks_m == {Direction.DOWN: 290.0, Direction.UP: 210.0}
    assert line.assumed == ("everything: a sample",)


def test_kilometrage_has_no_float_noise() -> None:
    line = parse_line(changed("km = 0.43\n", "km = 1.001\n"), "f")  # 1.001 * 1000 = 1000.9999999999999
    assert line.tags[7].position_m == 1001.0


def test_pieces_of_points_lie_on_both_sides_of_the_toe() -> None:
    pieces = parse_line(SAMPLE, "sample.toml").pieces
    assert (pieces["A.11.stem"].from_m, pieces["A.11.stem"].to_m) == (100.0, 110.0)
    assert (pieces["A.11.reverse"].from_m, pieces["A.11.reverse"].to_m) == (110.0, 160.0)
    assert (pieces["A.12.stem"].from_m, pieces["A.12.stem"].to_m) == (410.0, 420.0)
    assert pieces["A.12.normal"].leg is PointsLeg.NORMAL
    assert pieces["A.11.stem"].high_node == pieces["A.11.normal"].low_node == "A.11"
    assert pieces["A.12.stem"].low_node == pieces["A.12.reverse"].high_node == "A.12"


def test_legs_take_the_offset_of_what_they_lead_to() -> None:
    pieces = parse_line(SAMPLE, "sample.toml").pieces
    offsets = {leg: pieces[f"A.11.{leg}"].offset_m for leg in ("stem", "normal", "reverse")}
    assert offsets == {"stem": 0.0, "normal": 0.0, "reverse": 4.0}
    assert pieces["B.11.reverse"].offset_m == -4.0


def test_sections_know_their_station() -> None:
    sections = parse_line(SAMPLE, "sample.toml").sections
    assert (sections["A.2"].station_id, sections["A.2"].track) == ("A", "2")
    assert sections["A.E"].station_id == "A"
    assert sections["B.W"].station_id == "B"
    assert sections["A-B"].station_id is None
    assert sections["A.W"].kind is SectionKind.POINTS
    assert sections["A.W"].piece_ids == ("A.11.stem", "A.11.normal", "A.11.reverse")


def test_tags_and_initial_position() -> None:
    line = parse_line(changed('faces = "down"', 'faces = "down"\ninitial = "reverse"'), "f")
    assert line.tags[7].purpose is TagPurpose.DEPARTED
    assert line.tags[8].directions == (Direction.DOWN, Direction.UP)
    assert line.points["A.11"].initial is Position.REVERSE


def test_two_alignments_may_meet_at_different_kilometrages() -> None:
    branch = """
[[alignments]]
id = "branch"
from_km = 50.0
to_km = 51.0
gradients = [{ from_km = 50.0, to_km = 51.0, permille = 0 }]
[[sections]]
id = "Q"
kind = "portal"
alignment = "branch"
from_km = 50.0
to_km = 51.0
[[joints]]
low = "B.1"
high = "Q"
"""
    line = parse_line(SAMPLE + branch, "f")
    assert line.pieces["B.1"].high_node == line.pieces["Q"].low_node == "B.1+Q"


SECTION = '[[sections]]\nid = "{}"\nkind = "{}"\nfrom_km = {}\nto_km = {}\noffset_m = {}\n'
CROSS = changed('stem = "P"', 'stem = "A.12.stem"')

# (what is wrong, text, key, value, part of what is expected)
FAULTS = [
    ("[line", "", None, "valid TOML"),
    (changed('id = "sample"\n', ""), "line.id", None, "missing"),
    (changed('name = "Sample"', 'nam = "x"\nname = "S"'), "line.nam", "x", "no such key"),
    (changed("max_speed_kmh = 90", 'max_speed_kmh = "90"'), "line.max_speed_kmh", "90", "a valid"),
    (changed("max_speed_kmh = 90", "max_speed_kmh = -9"), "line.max_speed_kmh", -9, "1 to 575 km/h"),
    (changed("permille = 10.0", "permille = nan"), "alignments[0].gradients[1].permille", ..., "finite"),
    (changed("speed_kmh = 63", "speed_kmh = 0"), "alignments[0].limits[0].speed_kmh", 0, "1 to 575 km/h"),
    (changed('id = "sample"', 'id = "a b"'), "line.id", "a b", "an identifier"),
    (changed('kind = "portal"', 'kind = "door"'), "sections[0].kind", "door", "'track'"),
    (
        changed("from_km = 0.5, to_km = 1.5, permille", "from_km = 0.6, to_km = 1.5, permille"),
        "alignments[0].gradients[1].from_km",
        0.6,
        "0.5, where alignments[0].gradients[0] ends (the table has a gap)",
    ),
    (
        changed("from_km = 1.5, to_km = 3.2, permille", "from_km = 1.4, to_km = 3.2, permille"),
        "alignments[0].gradients[2].from_km",
        1.4,
        "an overlap",
    ),
    (
        changed("to_km = 3.2, permille", "to_km = 3.1, permille"),
        "alignments[0].gradients[2].to_km",
        3.1,
        "3.2, where the alignment ends",
    ),
    (
        changed("from_km = 2.0, to_km = 2.3, radius", "from_km = 0.9, to_km = 2.3, radius"),
        "alignments[0].curves[1].from_km",
        0.9,
        "at least 1.0",
    ),
    (changed("= -250.0", "= 0.0"), "alignments[0].curves[1].radius_m", 0.0, "10 to 100000 m"),
    (
        changed("transition_m = 50.0", "transition_m = 201.0"),
        "alignments[0].curves[0].transition_m",
        201.0,
        "at most 200",
    ),
    (changed("to_km = 2.3005", "to_km = 3.3"), "alignments[0].limits[1].to_km", 3.3, "0.0 to 3.2"),
    (changed("{ from_km = 2.5,", "{ from_km = 0.8,"), "alignments[0].coverage[1].from_km", 0.8, "sorted"),
    (changed("to_km = 0.1\n", "to_km = -0.1\n"), "sections[0].to_km", -0.1, "more than from_km"),
    (changed("to_km = 3.2\n[[s", "to_km = 3.4\n[[s"), "sections[7].to_km", 3.4, "0 to 3.2"),
    (changed('id = "A.2"', 'id = "A.1"'), "sections[3].id", "A.1", "sections[2] has this one"),
    (changed('id = "A.12"', 'id = "A.11"'), "points[1].id", "A.11", "an id of its own"),
    (changed("id = 8\n", "id = 7\n"), "tags[1].id", 7, "tags[0] has this one"),
    (changed("id = 8\n", "id = 65536\n"), "tags[1].id", 65536, "65535"),
    (changed('id = "H"', 'id = "A"'), "stations[1].id", "A", "an id of its own"),
    (changed("from_km = 0.42\n", ""), "sections[5].from_km", None, "missing"),
    (
        changed('kind = "points"\n', 'kind = "points"\nfrom_km = 0.1\n'),
        "sections[1].from_km",
        0.1,
        "no range",
    ),
    (changed('section = "A.W"', 'section = "A.E"'), "sections[1].id", "A.W", "[[points]]"),
    (changed('section = "A.W"', 'section = "A.1"'), "points[0].section", "A.1", "A.W, A.E"),
    (changed('faces = "down"', 'faces = "down"\nalignment = "x"'), "points[0].alignment", "x", "main"),
    (changed("toe_km = 0.11", "toe_km = 0.16"), "points[0].toe_km", 0.16, "between from_km = 0.1"),
    (changed("km = 1.5\n", "km = 0.2\n"), "stations[1].km", 0.2, "0.42 to 3, where its tracks lie"),
    (
        changed('[[stations]]\nid = "B"', f'{HALT}[[stations]]\nid = "B"'),
        "stations[1].km",
        1.5,
        "less than G's, whose mark",
    ),
    (
        changed("offset_m = 4.0", "offset_m = 0.5"),
        "sections[3].offset_m",
        0.5,
        "at least 2 m from 0, that of A.1",
    ),
    (changed('stem = "P"', 'stem = "Q"'), "points[0].stem", "Q", "one of "),
    (changed('stem = "P"', 'stem = "A.E"'), "points[0].stem", "A.E", "A.12.stem"),
    (changed("to_km = 0.1\n", "to_km = 0.099\n"), "points[0].stem", "P", "an end at 0.1 km"),
    (changed('faces = "down"', 'faces = "up"'), "points[0].faces", "up", "'down'"),
    (changed('normal = "A.1"', 'normal = "P"'), "points[0].normal", "P", "high side"),
    (changed('reverse = "A.2"', 'reverse = "A.1"'), "points[0].reverse", "A.1", "is joined to A.11"),
    (CROSS, "points[0].stem", "A.12.stem", "low side"),
    (
        SAMPLE + SECTION.format("X", "between", 0.3, 0.4, 0),
        "sections[9].from_km",
        0.3,
        "at least 0.36, where A.1 ends",
    ),
    (changed("offset_m = 4.0", ""), "sections[3].from_km", 0.16, "another offset_m"),
    (
        SAMPLE + SECTION.format("X", "between", 0.3, 0.4, 50),
        "sections[9].id",
        "X",
        "cannot be reached from P",
    ),
    (
        SAMPLE + SECTION.format("X", "between", 3.2, 3.2 - 1e-9, 0).replace("3.199999999", "3.2"),
        "sections[9].to_km",
        3.2,
        "more than",
    ),
    (changed('"between"', '"portal"'), "stations[1].tracks[0].section", "A-B", "for a halt"),
    (changed("km = 1.5\n", "km = 15\n"), "stations[1].km", 15, "0 to 3.2"),
    (changed('name = "2"', 'name = "1"'), "stations[0].tracks[1].name", "1", "of its own"),
    (
        changed('section = "A.2"', 'section = "A.1"'),
        "stations[0].tracks[1].section",
        "A.1",
        "stations[0].tracks[0] has this one",
    ),
    (
        changed('section = "A.2"', 'section = "A-B"'),
        "stations[0].tracks[1].section",
        "A-B",
        "a 'track' section for a station",
    ),
    (
        changed("platform_to_km = 0.3,", "platform_to_km = 0.37,"),
        "stations[0].tracks[0].platform_to_km",
        0.37,
        "0.16 to 0.36",
    ),
    (
        changed("mark_down_km = 0.29", "mark_down_km = 0.31"),
        "stations[0].tracks[0].mark_down_km",
        0.31,
        "along the platform",
    ),
    (
        changed("mark_down_km = 0.29, ", ""),
        "stations[0].tracks[0].mark_down_km",
        None,
        "down trains call here",
    ),
    (changed("km = 0.43\n", "km = 0.41\n"), "tags[0].km", 0.41, "0.42 to 3"),
    (changed('piece = "A.11.stem"', 'section = "A.W"'), "tags[1].section", "A.W", "piece ="),
    (changed('piece = "A.11.stem"\n', ""), "tags[1].section", None, "either section or piece"),
    (changed('piece = "A.11.stem"', 'piece = "Z"'), "tags[1].piece", "Z", "one of "),
]


@pytest.mark.parametrize(("text", "key", "value", "expected"), FAULTS, ids=[f[3] for f in FAULTS])
def test_a_fault_names_file_key_value_and_expectation(
    text: str, key: str, value: object, expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        parse_line(text, "broken.toml")
    error = caught.value
    assert (error.file, error.key) == ("broken.toml", key)
    assert value is ... or error.value == value
    assert expected in error.expected
    assert "\n" not in str(error)


def test_portal_and_between_need_their_joints() -> None:
    spur = '[[joints]]\nlow = "B.1"\nhigh = "X"\n'
    longer = SAMPLE.replace("to_km = 3.2\nelev", "to_km = 3.4\nelev").replace(
        "to_km = 3.2, per", "to_km = 3.4, per"
    )
    with pytest.raises(InputError, match="nothing meets its high end"):
        parse_line(longer + SECTION.format("X", "between", 3.2, 3.3, 0) + spur, "f")
    parse_line(longer + SECTION.format("X", "portal", 3.2, 3.3, 0) + spur, "f")
    with pytest.raises(InputError, match="0 of its ends are"):
        parse_line(longer + SECTION.format("X", "portal", 3.2, 3.3, 0), "f")


def test_joint_that_does_not_meet() -> None:
    with pytest.raises(InputError, match=r"an end at 0\.1 km, where P ends"):
        parse_line(SAMPLE + '[[joints]]\nlow = "P"\nhigh = "A.1"\n', "f")
    with pytest.raises(InputError, match="at its toe"):
        parse_line(SAMPLE + '[[joints]]\nlow = "A.11.stem"\nhigh = "A.1"\n', "f")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    missing = tmp_path / "none.toml"
    with pytest.raises(InputError, match=r"none\.toml; expected a readable file"):
        load_line(missing)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="UTF-8"):
        load_line(binary)
    good = tmp_path / "good.toml"
    good.write_text(SAMPLE, encoding="utf-8")
    assert load_line(good) == parse_line(SAMPLE, "sample.toml")


TIMETABLE = timetable_of(
    "t", "sample", "1 down, portal:P to stabled: A -/06:00; H 06:02/06:03; B 06:06/-", K="1"
)


@pytest.mark.parametrize(
    ("length_m", "where"),
    [
        (40.0, None),
        (80.0, None),
        (81.0, "train 1 at H track 1"),  # halt: platform 1.46 to 1.54 km
        (126.0, "train 1 at A track 1"),  # mark 0.29 - section 0.16 = 130 m, less the margin of 5 m
    ],
)
def test_train_must_fit_where_it_calls(length_m: float, where: str | None) -> None:
    line = parse_line(SAMPLE, "sample.toml")
    timetable = parse_timetable(TIMETABLE, "t.toml", line)
    if where is None:
        validate_train_fits(line, {"K": length_m}, timetable, "t.toml")
        return
    with pytest.raises(InputError) as caught:
        validate_train_fits(line, {"K": length_m}, timetable, "t.toml")
    assert where in caught.value.key
    assert caught.value.value == f"{length_m:.1f} m"


def test_usable_length_is_behind_the_mark() -> None:
    line = parse_line(SAMPLE, "sample.toml")
    track = line.stations["A"].tracks[0]
    assert usable_length_m(line, track, Direction.DOWN) == pytest.approx(290 - 160 - 5)
    assert usable_length_m(line, track, Direction.UP) == pytest.approx(360 - 210 - 5)
    assert usable_length_m(line, line.stations["H"].tracks[0], Direction.UP) == pytest.approx(80)


def test_stock_of_unknown_length() -> None:
    line = parse_line(SAMPLE, "sample.toml")
    with pytest.raises(InputError, match=r"diagrams\[0\].stock is 'K'"):
        validate_train_fits(line, {"V": 40.0}, parse_timetable(TIMETABLE, "t.toml", line), "t.toml")
