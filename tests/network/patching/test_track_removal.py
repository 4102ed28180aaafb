"""Taking a track out leaves the same line without it: connected, as long as before, usable both ways."""

import tomllib
from typing import Any

import pytest

from network.errors import InputError
from network.files.line_file import line_of, load_line
from network.files.line_schema import LineFile
from network.files.shipped import shipped_line, shipped_names
from network.files.toml_input import parse_toml
from network.graph import find_route, next_pieces, routes_from
from network.model import Direction, Line, SectionKind
from network.patching.track_removal import without_track
from tests.network.sample import SAMPLE


def sample() -> dict[str, Any]:
    return tomllib.loads(SAMPLE)


def ladder() -> dict[str, Any]:
    """The sample with a third track at A: A.1 off the first points, A.2 and A.3 off second ones behind them."""
    data = sample()
    named = {item["id"]: item for table in ("sections", "points", "stations") for item in data[table]}
    named["A.1"] |= {"from_km": 0.13, "to_km": 0.39}
    named["A.11"] |= {"to_km": 0.13, "reverse": "A.13.stem"}
    named["A.12"] |= {"from_km": 0.39, "reverse": "A.14.stem"}
    data["sections"].append(named["A.2"] | {"id": "A.3", "offset_m": 8.0})
    legs = {"normal": "A.2", "reverse": "A.3", "offset_m": 4.0}
    low = {"id": "A.13", "from_km": 0.13, "toe_km": 0.14, "to_km": 0.16, "stem": "A.11.reverse"}
    high = {"id": "A.14", "from_km": 0.36, "toe_km": 0.38, "to_km": 0.39, "stem": "A.12.reverse"}
    data["points"] += [named["A.11"] | low | legs, named["A.12"] | high | legs]
    named["A"]["tracks"].append(named["A"]["tracks"][1] | {"name": "3", "section": "A.3", "directions": []})
    return data


def without(data: dict[str, Any], *tracks: str) -> Line:
    entry = LineFile.model_validate(data)
    for track in tracks:
        entry = without_track(entry, track, "f", "k")
    return line_of(entry, "f")


def ways(line: Line, direction: Direction) -> dict[str, float]:
    """Length (m) of every route of the line in a direction, by its id."""
    stops = [s.id for s in line.sections.values() if s.kind in (SectionKind.TRACK, SectionKind.PORTAL)]
    routes = [route for stop in stops for route in routes_from(line, stop, direction)]
    return {route.id: sum(line.pieces[p].length_m for p in route.piece_ids) for route in routes}


def removable() -> list[tuple[str, str]]:
    """Shipped lines and their tracks, where a station has several."""
    found = []
    for name in shipped_names("lines"):
        for station in load_line(shipped_line(name)).stations.values():
            tracks = [] if station.is_halt or len(station.tracks) < 2 else station.tracks
            found += [(name, track.section_id) for track in tracks]
    return found


def test_points_become_sections_of_the_same_kilometrage() -> None:
    line = without(sample(), "A.2")
    assert set(line.points) == {"B.11"}
    assert "A.2" not in line.sections
    for name, from_m, to_m, low, high in (
        ("A.W", 100.0, 160.0, "P", "A.1"),
        ("A.E", 360.0, 420.0, "A.1", "A-B"),
    ):
        section, piece = line.sections[name], line.pieces[name]
        assert (section.kind, section.piece_ids) == (SectionKind.BETWEEN, (name,))
        assert (piece.from_m, piece.to_m) == (from_m, to_m)
        assert next_pieces(line, name, Direction.DOWN) == (high,)
        assert next_pieces(line, name, Direction.UP) == (low,)
    assert list(line.sections) == ["P", "A.W", "A.1", "A.E", "A-B", "B.W", "B.1", "B.2"]
    (note,) = (text for text in line.assumed if "A.2" in text)
    assert (
        note == "track A.2: taken out; points A.11 and A.12 became plain track without a limit of their own"
    )


@pytest.mark.parametrize(("name", "track"), removable())
def test_what_remains_is_as_long_as_before(name: str, track: str) -> None:
    data = tomllib.loads(shipped_line(name).read_text(encoding="utf-8"))
    before, after = load_line(shipped_line(name)), without(data, track)
    for direction in Direction:
        kept = {k: v for k, v in ways(before, direction).items() if track not in k.split(">")}
        assert ways(after, direction) == pytest.approx(kept)
    station = next(s for s in before.stations.values() if track in {t.section_id for t in s.tracks})
    rest = after.stations[station.id].tracks
    assert len(rest) == len(station.tracks) - 1
    usual = {direction for t in station.tracks for direction in t.directions}
    assert {direction for t in rest for direction in t.directions} == usual
    assert {s.terminal_id for s in after.points.values()} <= {s.terminal_id for s in before.points.values()}


def test_the_last_track_serves_both_directions() -> None:
    (track,) = without(sample(), "A.2").stations["A"].tracks
    assert track.directions == (Direction.DOWN, Direction.UP)
    (track,) = without(sample(), "A.1").stations["A"].tracks
    assert (track.name, track.directions) == ("2", (Direction.DOWN, Direction.UP))


def test_the_diverging_limit_goes_with_the_points() -> None:
    line = without(sample(), "A.1")
    route = find_route(line, "P", "A.2", Direction.DOWN)
    assert route is not None
    assert route.points == ()
    assert line.pieces["A.W"].offset_m == 0.0  # the plain track runs across to track 2 from here
    assert line.pieces["A.2"].offset_m == 4.0


def test_tags_follow_their_rails() -> None:
    data = sample()
    spots = {20: "A.11.normal", 21: "A.11.reverse", 22: "A.12.reverse", 23: "A.2", 24: "A.1"}
    for number, piece in spots.items():
        km = {"A.12.reverse": 0.38, "A.2": 0.26, "A.1": 0.26}.get(piece, 0.15)
        data["tags"].append({"id": number, "piece": piece, "km": km, "purpose": "position"})
    tags = without(data, "A.2").tags
    assert {number: tag.piece_id for number, tag in tags.items()} == {
        7: "A-B",
        8: "A.W",
        20: "A.W",
        24: "A.1",
    }
    assert tags[8].position_m == 105.0


def test_a_stub_track_goes_with_its_only_points() -> None:
    line = without(sample(), "B.2")
    assert [route.to_section for route in routes_from(line, "A.1", Direction.DOWN)] == ["B.1"]
    assert line.pieces["B.W"].to_m == line.pieces["B.1"].from_m == 3060.0


def test_second_points_of_a_ladder_are_added_to_the_track() -> None:
    line = without(ladder(), "A.3")
    assert set(line.points) == {"A.11", "A.12", "B.11"}
    assert (line.pieces["A.2"].from_m, line.pieces["A.2"].to_m) == (130.0, 390.0)
    assert (line.points["A.11"].reverse_piece, line.pieces["A.11.reverse"].offset_m) == ("A.11.reverse", 4.0)
    assert next_pieces(line, "A.11.reverse", Direction.DOWN) == ("A.2",)
    assert line.sections["A.W"].kind is SectionKind.POINTS


def test_first_points_of_a_ladder_get_a_section_of_their_own() -> None:
    line = without(ladder(), "A.1")
    assert set(line.points) == {"A.13", "A.14", "B.11"}
    assert line.sections["A.11"].kind is SectionKind.BETWEEN
    assert next_pieces(line, "A.11", Direction.DOWN) == ("A.13.stem",)
    assert next_pieces(line, "A.13.stem", Direction.UP) == ("A.11",)
    assert list(line.sections)[1:3] == ["A.W", "A.11"]
    # Left-hand running: nothing else was usual for DOWN, so the next track with a mark is.
    assert line.stations["A"].tracks[0].directions == (Direction.DOWN, Direction.UP)


@pytest.mark.parametrize("left", ["A.1", "A.2", "A.3"])
def test_tracks_can_be_taken_out_one_after_the_other(left: str) -> None:
    gone = [track for track in ("A.1", "A.2", "A.3") if track != left]
    for order in (gone, gone[::-1]):
        line = without(ladder(), *order)
        assert set(line.points) == {"B.11"}
        for direction, wanted in ((Direction.DOWN, ["B.1", "B.2"]), (Direction.UP, ["P"])):
            assert [route.to_section for route in routes_from(line, left, direction)] == wanted
        (track,) = line.stations["A"].tracks
        assert track.directions == (Direction.DOWN, Direction.UP)


@pytest.mark.parametrize(
    ("track", "message"),
    [
        ("A.9", r"^f: k is 'A\.9'; expected a platform track, one of A\.1, A\.2, B\.1, B\.2$"),
        ("A-B", "a platform track"),
        ("B.1", "a track that Bessho can do without: no other has a mark for up trains"),
    ],
)
def test_tracks_that_cannot_be_taken_out(track: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        without(sample(), track)


def test_a_station_keeps_a_track() -> None:
    with pytest.raises(InputError, match="one of several tracks of its station; Aoki has no other"):
        without(sample(), "A.2", "A.1")


@pytest.mark.parametrize("track", ["HSK.1", "KRS.1"])
def test_stations_of_one_track_keep_it(track: str) -> None:
    entry = parse_toml(shipped_line("karasuyama").read_text(encoding="utf-8"), "f", LineFile)
    with pytest.raises(InputError, match="has no other"):
        without_track(entry, track, "f", "k")


@pytest.mark.parametrize("over_points", [False, True])
def test_a_track_that_something_hangs_on_is_kept(over_points: bool) -> None:
    """Behind track B.2, a portal joined to it, or points with their stem to it and two portals."""
    data = sample()
    sections = {section["id"]: section for section in data["sections"]}
    sections["B.2"]["to_km"] = 3.16
    data["stations"][2]["tracks"][1] |= {"platform_to_km": 3.15, "mark_down_km": 3.14}
    portal = {"kind": "portal", "from_km": 3.18, "to_km": 3.2, "offset_m": -4.0}
    if over_points:
        data["sections"] += [portal | {"id": "X"}, portal | {"id": "Y", "offset_m": -8.0}]
        data["sections"].append({"id": "B.E", "kind": "points"})
        ends = {"stem": "B.2", "normal": "X", "reverse": "Y"}
        span = {"id": "B.21", "section": "B.E", "from_km": 3.16, "toe_km": 3.17, "to_km": 3.18}
        data["points"].append(data["points"][2] | span | ends)
    else:
        data["sections"].append(portal | {"id": "X", "from_km": 3.16})
        data["joints"] = [{"low": "B.2", "high": "X"}]
    name = "B.21.stem" if over_points else "X"
    with pytest.raises(InputError, match=f"this one leads on to {name}, which needs it"):
        without(data, "B.2")


def test_points_between_points_are_refused() -> None:
    """A third pair of points in the ladder: its middle ones have points on either side."""
    data = ladder()
    named = {item["id"]: item for item in [*data["sections"], *data["points"], *data["stations"]]}
    data["sections"].append(named["A.3"] | {"id": "A.4", "from_km": 0.18, "offset_m": 12.0})
    named["A.3"]["from_km"] = 0.18
    named["A.13"]["reverse"] = "A.15.stem"
    last = {"id": "A.15", "from_km": 0.16, "toe_km": 0.165, "to_km": 0.18, "stem": "A.13.reverse"}
    data["points"].append(named["A.13"] | last | {"normal": "A.3", "reverse": "A.4", "offset_m": 8.0})
    tracks = named["A"]["tracks"]
    tracks.append(tracks[2] | {"name": "4", "section": "A.4"})
    line = line_of(LineFile.model_validate(data), "f")
    assert find_route(line, "P", "A.4", Direction.DOWN) is not None
    with pytest.raises(InputError, match=r"A\.13 lies between A\.11\.reverse and A\.15\.stem"):
        without(data, "A.2")
