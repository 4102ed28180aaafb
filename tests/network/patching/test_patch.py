"""Patches change what they say and nothing else, and take the blame for what they break."""

import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.files.edits import PatchInFile
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Coverage, Direction, Line, SpeedLimit
from network.patching.patch import KEY, _patched, load_patched_line
from network.timetable import load_timetable, parse_timetable
from tests.network.sample import SAMPLE, SAMPLE_FILE

DATA = tomllib.loads(SAMPLE)


def patched(toml: str) -> Line:
    """The sample with a patch as it stands in a scenario."""
    return load_patched_line(SAMPLE_FILE, tomllib.loads(toml), "what_if.toml")


def data_patched(data: dict[str, Any], patch: dict[str, Any]) -> dict[str, Any]:
    return _patched(data, PatchInFile(patch, "f", KEY)).data


def test_an_empty_patch_is_the_line_itself() -> None:
    assert patched("") == load_line(SAMPLE_FILE)
    before = deepcopy(DATA)
    assert data_patched(DATA, {}) == DATA
    data_patched(DATA, {"remove_tracks": ["A.2"], "set": {"line.max_speed_kmh": 50}})
    assert before == DATA


def test_the_same_tables_are_the_same_line_and_others_are_not() -> None:
    """By being the same object it is known what was computed of it."""
    slow = "[set]\n'line.max_speed_kmh' = 50\n"
    assert load_line(SAMPLE_FILE) is load_line(SAMPLE_FILE)
    assert patched(slow) is patched(slow) is not patched("")
    assert patched(slow) != patched("")


def test_set_finds_its_place_by_id_name_or_index() -> None:
    line = patched("""
        [set]
        "line.max_speed_kmh" = 72
        "points.A.11.throw_time_s" = 12.0
        "points.A.12.initial" = "reverse"
        "sections.A.2.offset_m" = 5.0
        "alignments.main.limits[1].speed_kmh" = 36
        "alignments.main.coverage" = [{ from_km = 0.0, to_km = 3.2 }]
        "stations.A.tracks.1.mark_down_km" = 0.28
        "tags.7.km" = 0.44
    """)
    assert line.max_speed_mps == pytest.approx(20.0)
    assert [p.throw_time_s for p in line.points.values()] == [12.0, 6.0, 6.0]
    assert line.points["A.12"].initial.value == "reverse"
    assert line.pieces["A.11.reverse"].offset_m == 5.0
    assert [limit.speed_mps for limit in line.alignments["main"].limits] == pytest.approx([17.5, 10.0])
    assert line.alignments["main"].coverage == (Coverage(0.0, 3200.0),)
    assert line.stations["A"].tracks[0].marks_m[Direction.DOWN] == 280.0
    assert line.tags[7].position_m == 440.0


def test_set_prefers_the_longest_id() -> None:
    """Station A, and a station whose id begins like it."""
    data = deepcopy(DATA)
    data["stations"][1]["id"] = "A.tracks"
    changed = data_patched(data, {"set": {"stations.A.tracks.name": "Longest"}})
    assert changed["stations"][1]["name"] == "Longest"


def test_add_appends_and_sorts_by_kilometrage() -> None:
    line = patched("""
        [[add.limits]]
        from_km = 0.1
        to_km = 0.2
        speed_kmh = 18
        directions = ["up"]
        [[add.coverage]]
        alignment = "main"
        from_km = 1.0
        to_km = 1.2
        [[add.tags]]
        id = 90
        section = "A.1"
        km = 0.3
        purpose = "arrival"
        [[add.chargers]]
        station = "A"
        power_kw = 300.0
        voltage_v = 1500.0
        origin = "assumed: a what-if"
    """)
    assert line.chargers["A"].power_w == 300e3
    main = line.alignments["main"]
    assert main.limits[0] == SpeedLimit(100.0, 200.0, 18 / 3.6, (Direction.UP,))
    assert len(main.limits) == 3
    assert main.coverage == (Coverage(0.0, 900.0), Coverage(1000.0, 1200.0), Coverage(2500.0, 3200.0))
    assert line.tags[90].piece_id == "A.1"


def test_tracks_go_first_and_their_place_can_be_patched() -> None:
    line = patched("""
        remove_tracks = ["A.2"]
        add.limits = [{ from_km = 0.1, to_km = 0.16, speed_kmh = 36 }]
        [set]
        "sections.A.W.offset_m" = 0.5
    """)
    assert line.pieces["A.W"].offset_m == 0.5
    assert len(line.alignments["main"].limits) == 3
    with pytest.raises(InputError, match=r"set.\"points\.A\.11\.throw_time_s\" is 'A\.11\.throw_time_s'"):
        patched('remove_tracks = ["A.2"]\nset = { "points.A.11.throw_time_s" = 5.0 }')


def test_a_loop_taken_out_is_its_further_tracks_taken_out() -> None:
    one, other = (
        load_patched_line(shipped_line("karasuyama"), patch, "what_if.toml")
        for patch in ({"remove_loops": ["OGN"]}, {"remove_tracks": ["OGN.2"]})
    )
    assert one == other
    with pytest.raises(InputError, match=r"remove_loops\[0\] is 'NIT'; expected a station with two tracks"):
        load_patched_line(shipped_line("karasuyama"), {"remove_loops": ["NIT"]}, "what_if.toml")


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (
            "take = 1",
            "what_if.toml: patch.line.take is 1; expected no such key, but one of remove, set, times, add, "
            "remove_tracks, remove_loops, add_loops, remove_tags",
        ),
        ('remove_tracks = "A.2"', "what_if.toml: patch.line.remove_tracks is 'A.2'; expected a valid list"),
        (
            'remove_tracks = ["A.2", "A.8"]',
            "what_if.toml: patch.line.remove_tracks[1] is 'A.8'; expected a platform track, one of A.1, B.1, B.2",
        ),
        (
            'set = { "point.A.11.throw_time_s" = 5 }',
            "what_if.toml: patch.line.set.\"point.A.11.throw_time_s\" is 'point'; expected a table that the line "
            "has, one of line, alignments, sections, points, stations, tags, as in "
            '"points.OGN.11.throw_time_s" = 12.0',
        ),
        (
            'set = { "points.A.99.throw_time_s" = 5 }',
            "what_if.toml: patch.line.set.\"points.A.99.throw_time_s\" is 'A.99.throw_time_s'; "
            "expected one of A.11, A.12, B.11",
        ),
        (
            'set = { "points.A.11.throw_time" = 5 }',
            'what_if.toml: patch.line.set."points.A.11.throw_time" is 5; '
            "expected no such key, but one of throw_time_s, to_km, toe_km, from_km, alignment, id, section, terminal, "
            "faces, stem, normal, reverse, diverging_limit_kmh, offset_m, initial",
        ),
        (
            'set = { "stations.H" = 5 }',
            'what_if.toml: patch.line.set."stations.H"; expected a key of H, one of id, name, km, halt, tracks',
        ),
        (
            'set = { "line.assumed[0].x" = 5 }',
            'what_if.toml: patch.line.set."line.assumed[0].x"; expected the whole list',
        ),
        (
            'set.points."A.11".throw_time_s = 5',
            "what_if.toml: patch.line.set.\"points\" is 'a table'; expected one whole key in quotes, such as "
            '"points.OGN.11.throw_time_s" = 12.0',
        ),
        (
            'set = { "points.A.11.throw_time_s" = -5 }',
            'what_if.toml: patch.line.set."points.A.11.throw_time_s" is -5; expected 0.1 to 120 s (throw of points)',
        ),
        (
            'set = { "alignments.main.coverage" = [{ from_km = 0.0 }] }',
            'what_if.toml: patch.line.set."alignments.main.coverage"[0].to_km; '
            "expected this key, which is missing",
        ),
        (
            'set = { "sections.A.1.to_km" = 9.0 }',
            'what_if.toml: patch.line.set."sections.A.1.to_km" is 9.0; '
            "expected 0 to 3.2, the range of alignment main",
        ),
        (
            "add.curbs = [{}]",
            "what_if.toml: patch.line.add is 'curbs'; expected one of curves, chargers, crossings, tunnels, markers, "
            "sections, points, joints, stations, tags, beacons, limits, coverage, second_coverage, obstructed",
        ),
        (
            'add.limits = [{ alignment = "branch", from_km = 0.0, to_km = 0.1, speed_kmh = 5 }]',
            "what_if.toml: patch.line.add.limits[0].alignment is 'branch'; expected one of main",
        ),
        (
            "add.limits = [{ from_km = 3.0, to_km = 3.1, speed_kmh = 5 },"
            " { from_km = 0.0, to_km = 0.1, speed_kmh = 0 }]",
            "what_if.toml: patch.line.add.limits[1].speed_kmh is 0; expected 1 to 575 km/h (speed)",
        ),
        (
            'add.tags = [{ id = 7, section = "P", km = 0.05, purpose = "portal" }]',
            "what_if.toml: patch.line.add.tags[0].id is 7; expected an id of its own; tags[0] has this one",
        ),
    ],
)
def test_the_patch_is_to_blame(toml: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        patched(toml)
    assert str(caught.value) == message


def test_what_is_wrong_elsewhere_names_patch_and_line() -> None:
    with pytest.raises(
        InputError, match=r"^what_if\.toml: patch.line; expected a patch that leaves the line"
    ) as error:
        patched('set = { "sections.A.1.to_km" = 0.3 }')  # A.12 no longer meets it
    assert "sample_line.toml: points[1].normal" in str(error.value)


def test_a_line_file_at_fault_is_named_itself(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text(SAMPLE.replace('stem = "P"', 'stem = "Q"'), encoding="utf-8")
    with pytest.raises(InputError, match=r"broken\.toml: points\[0\]\.stem is 'Q'"):
        load_patched_line(path, {"remove_tracks": ["A.2"]}, "what_if.toml")


STEPS = [
    "line",
    "points",
    "alignments",
    "main",
    "limits",
    "A",
    "11",
    "A.11",
    "tags",
    "7",
    "km",
    "0",
    "[1]",
    "",
    "²",
]
VALUES: st.SearchStrategy[Any] = st.one_of(
    st.integers(), st.text(max_size=3), st.lists(st.integers(), max_size=2), st.just({})
)
ROWS = st.dictionaries(st.sampled_from(["id", "km", "from_km", "a.b[0]", "alignment"]), VALUES, max_size=3)


@given(
    values=st.dictionaries(st.lists(st.sampled_from(STEPS), max_size=5).map(".".join), VALUES, max_size=3),
    rows=st.dictionaries(st.sampled_from(["tags", "limits", "coverage"]), st.lists(ROWS, max_size=2)),
)
def test_any_patch_gives_a_line_or_one_clear_error(values: dict[str, Any], rows: dict[str, Any]) -> None:
    try:
        line = load_patched_line(SAMPLE_FILE, {"set": values, "add": rows}, "what_if.toml")
    except InputError as error:
        assert error.file == "what_if.toml"
        assert error.key.startswith("patch.line")
    else:
        assert line.sections


def test_timetables_of_the_line_still_load() -> None:
    """Trains without a planned track call at the one that is left; a planned track that is gone is an error."""
    line = load_patched_line(shipped_line("karasuyama"), {"remove_tracks": ["OGN.2"]}, "what_if.toml")
    path = shipped_timetable("karasuyama_weekday")
    assert load_timetable(path, line) == load_timetable(path, load_line(shipped_line("karasuyama")))
    text = path.read_text(encoding="utf-8").replace('station = "OGN",', 'station = "OGN", track = "2",', 1)
    with pytest.raises(
        InputError, match=r"calls\[4\]\.track is '2'; expected a track with a mark .*one of 1"
    ):
        parse_timetable(text, "day.toml", line)


def test_tags_near_the_marks_are_taken_out() -> None:
    """The paper's line: position tags lie 300, 100 and 15 m before each mark (its file)."""
    path = shipped_line("rtri_test_line")
    before = load_line(path)
    patch = {"remove_tags": {"purpose": "position", "near_marks_m": 120.0}}
    after = load_patched_line(path, patch, "what_if.toml")
    marks_m = [m for s in before.stations.values() for t in s.tracks for m in t.marks_m.values()]
    gone = {id_ for id_ in before.tags if id_ not in after.tags}
    assert gone
    for id_, tag in before.tags.items():
        near = min(abs(tag.position_m - mark_m) for mark_m in marks_m) <= 120.0
        on_section = tag.piece_id in before.sections
        assert (id_ in gone) == (near and tag.purpose.value == "position" and on_section)


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"purpose": "position", "near_marks_m": 0.01}, "patch.line.remove_tags"),
        ({"purpose": "beacon", "near_marks_m": 100.0}, "patch.line.remove_tags.purpose"),
    ],
)
def test_tags_that_do_not_exist_cannot_be_taken_out(table: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as caught:
        load_patched_line(shipped_line("rtri_test_line"), {"remove_tags": table}, "what_if.toml")
    assert (caught.value.file, caught.value.key) == ("what_if.toml", key)


@pytest.mark.parametrize(
    ("patch", "key", "named"),
    [
        ({"remove": {"alignments": ["main"]}}, "patch.line", "alignments"),
        ({"set": {"alignments": "x"}, "add": {"limits": [{}]}}, 'patch.line.set."alignments"', "list"),
        ({"set": {"tags": "x"}, "add": {"tags": [{}]}}, 'patch.line.set."tags"', "list"),
        (
            {"set": {"alignments.main.limits": ["a", "b"]}, "add": {"limits": [{"from_km": 0.0}]}},
            'patch.line.set."alignments.main.limits"[0]',
            "dictionary",
        ),
    ],
)
def test_a_patch_that_leaves_no_line_is_to_blame_and_what_is_lacking_is_the_lines(
    patch: dict[str, Any], key: str, named: str
) -> None:
    """What it left is read once, as the line's own file."""
    with pytest.raises(InputError) as raised:
        load_patched_line(SAMPLE_FILE, patch, "what_if.toml")
    assert (raised.value.file, raised.value.key) == ("what_if.toml", key)
    assert named in raised.value.expected
    assert "what_if.toml" not in raised.value.expected
