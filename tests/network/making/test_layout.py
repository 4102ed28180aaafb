"""Lists of stations drawn at random become lines that validate, on which every track leads to every next one."""

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.new_line import NewLine, NewLineOptions, make_line
from network.errors import InputError
from network.files.line_file import parse_line
from network.graph import all_routes
from network.making import layout
from network.making.layout import LayoutRule
from network.making.station_list import TRACKS_MAX
from network.model import Direction, Line, SectionKind, TagPurpose
from network.tag_layout import lay_tags
from network.train_fit import usable_length_m
from sumo_cfg.build import build_net
from sumo_cfg.truth_map import read_net

STATION_KINDS = ("station", "halt", "signal station")


def made(folder: Path, rows: list[dict[str, object]], **asked: float) -> NewLine:
    """A line from rows of a list, by way of a file."""
    table = "\n".join(
        "[[stations]]\n"
        + "\n".join(f'{key} = "{v}"' if isinstance(v, str) else f"{key} = {v}" for key, v in row.items())
        for row in rows
    )
    path = folder / "list.toml"
    path.write_text(table + "\n", "utf-8")
    return make_line(path, "drawn", NewLineOptions(**asked))  # type: ignore[arg-type]


@st.composite
def station_rows(draw: st.DrawFn, spacing_km: tuple[float, float], most: int = 10) -> list[dict[str, object]]:
    count = draw(st.integers(2, most))
    km = draw(st.floats(-5.0, 50.0).map(lambda x: round(x, 3)))
    rows: list[dict[str, object]] = []
    for i in range(count):
        at_end = i in (0, count - 1)
        row: dict[str, object] = {"name": f"Station {i}", "km": km}
        kind = "station" if at_end else draw(st.sampled_from(STATION_KINDS))
        tracks = 1 if kind == "halt" else draw(st.integers(1, TRACKS_MAX))
        row |= {"kind": kind, "tracks": tracks}
        if at_end:
            row["end"] = draw(st.sampled_from(("stub", "portal")))
        elif tracks > 1:
            row["points"] = draw(st.sampled_from(("both", "both", "low", "high")))
        if tracks > 1:
            row["side"] = draw(st.sampled_from(("right", "left")))
            if draw(st.booleans()):
                row["normal"] = str(draw(st.integers(1, tracks)))
            elif row.get("points", "both") == "both" and draw(st.booleans()):
                row["offset_m"] = draw(st.sampled_from((-16.0, -8.0, 0.0, 8.0)))
        rows.append(row)
        km = round(km + draw(st.floats(*spacing_km)), 3)
    return rows


def leads(row: dict[str, object], track: str, end: str, *, outer: bool) -> bool:
    """By the words of the list alone: whether a track of a station can be left at its low or high end."""
    tracks = row["tracks"]
    points = row.get("points", "both")
    if tracks == 1 or points in ("both", end) or outer:
        return True
    return track == row.get("normal", "1" if row.get("side") != "left" else str(tracks))


def assert_every_track_leads_to_every_next_one(rows: list[dict[str, object]], line: Line) -> None:
    routes = {(r.from_section, r.to_section, r.direction) for r in all_routes(line)}
    stations = list(line.stations.values())
    own = [i for i, row in enumerate(rows) if row["kind"] != "halt"]
    for low, high in pairwise(own):
        for a in stations[low].tracks:
            for b in stations[high].tracks:
                possible = leads(rows[low], a.name, "high", outer=low == own[0]) and leads(
                    rows[high], b.name, "low", outer=high == own[-1]
                )
                for key in (
                    (a.section_id, b.section_id, Direction.DOWN),
                    (b.section_id, a.section_id, Direction.UP),
                ):
                    assert (key in routes) is possible, key


@given(
    rows=station_rows((3.0, 8.0)),
    speed=st.sampled_from((45.0, 65.0, 85.0)),
    length=st.sampled_from((20.0, 41.7, 80.0)),
)
def test_stations_with_room_make_a_line_whose_tracks_all_hang_together(
    tmp_path_factory: pytest.TempPathFactory, rows: list[dict[str, object]], speed: float, length: float
) -> None:
    line = made(tmp_path_factory.mktemp("l"), rows, max_speed_kmh=speed, train_length_m=length).line
    assert [s.name for s in line.stations.values()] == [row["name"] for row in rows]
    assert [s.position_m for s in line.stations.values()] == pytest.approx(
        [1000.0 * float(str(row["km"])) for row in rows], abs=0.5
    )
    assert [len(s.tracks) for s in line.stations.values()] == [row["tracks"] for row in rows]
    assert_every_track_leads_to_every_next_one(rows, line)
    for station in line.stations.values():
        for track in station.tracks:
            for direction in track.marks_m:
                assert usable_length_m(line, track, direction) >= length
        assert station.is_signal_station is (
            rows[list(line.stations).index(station.id)]["kind"] == "signal station"
        )
    assert tuple(line.tags.values()) == lay_tags(line, LayoutRule(length, speed / 3.6).tags)
    portals = [s for s in line.sections.values() if s.kind is SectionKind.PORTAL]
    assert len(portals) == sum(row.get("end") == "portal" for row in rows)


@given(rows=station_rows((0.15, 1.5)), length=st.sampled_from((20.0, 40.0, 120.0)))
def test_stations_near_each_other_make_a_line_or_are_refused_by_name(
    tmp_path_factory: pytest.TempPathFactory, rows: list[dict[str, object]], length: float
) -> None:
    try:
        line = made(tmp_path_factory.mktemp("l"), rows, max_speed_kmh=65.0, train_length_m=length).line
    except InputError as error:
        assert re.search(r"at least \d+ m from Station \d", error.expected)
        assert re.fullmatch(r"Station \d+", str(error.value))
        assert re.fullmatch(r"stations\[\d+\]\.km", error.key)
        return
    assert_every_track_leads_to_every_next_one(rows, line)


@given(rows=station_rows((3.0, 60.0), most=4))
def test_no_train_runs_far_without_a_tag(
    tmp_path_factory: pytest.TempPathFactory, rows: list[dict[str, object]]
) -> None:
    """Bounds that grow by 1 % over two such ways stay well below the 300 m at which the tags of a stop begin."""
    line = made(tmp_path_factory.mktemp("l"), rows, max_speed_kmh=65.0, train_length_m=40.0).line
    for direction in Direction:
        read = sorted(tag.position_m for tag in line.tags.values() if direction in tag.directions)
        assert max(after - before for before, after in pairwise(read)) <= 6_001.0


@pytest.mark.parametrize("tracks", [(1, 2), (2, 2), (4, 1), (3, 4)])
def test_what_a_refusal_asks_for_is_enough_and_needed(tmp_path: Path, tracks: tuple[int, int]) -> None:
    def rows(km: float) -> list[dict[str, object]]:
        return [{"name": "A", "km": 0.0, "tracks": tracks[0]}, {"name": "B", "km": km, "tracks": tracks[1]}]

    with pytest.raises(InputError) as refused:
        made(tmp_path, rows(0.1))
    least_m = int(re.findall(r"at least (\d+) m", str(refused.value))[0])
    assert made(tmp_path, rows(least_m / 1000.0)).line.stations["B"].position_m == least_m
    with pytest.raises(InputError, match=f"at least {least_m} m"):
        made(tmp_path, rows((least_m - 1) / 1000.0))


def test_forty_stations_of_four_tracks(tmp_path: Path) -> None:
    rows: list[dict[str, object]] = [
        {"name": f"Station {i}", "km": 2.5 * i, "tracks": 4, "kind": "station"} for i in range(40)
    ]
    line = made(tmp_path, rows).line
    assert_every_track_leads_to_every_next_one(rows, line)
    assert len(line.points) == 3 * (2 * 40 - 2)  # none at the two ends where the rails end


def test_near_stations_have_shorter_tracks_and_it_is_said(tmp_path: Path) -> None:
    rows: list[dict[str, object]] = [
        {"name": "A", "km": 0.0, "tracks": 2},
        {"name": "B", "km": 0.6, "tracks": 2},
        {"name": "C", "km": 6.0, "tracks": 1},
    ]
    line = made(tmp_path, rows, max_speed_kmh=65.0).line
    # 600 m less two fans of 80 m and two halves of 50 m
    assert line.pieces["A-B"].length_m == pytest.approx(340.0)
    approach = [t for t in line.tags.values() if t.piece_id == "A-B" and t.purpose is TagPurpose.APPROACH]
    assert sorted(t.position_m for t in approach) == pytest.approx([135.0, 465.0])
    assert any("A and B are near each other" in text for text in line.assumed)
    assert any("no approach tag 450 m before points" in text for text in line.assumed)
    # the far side of B has its whole length
    assert line.pieces["B.1"].to_m == pytest.approx(720.0)


def test_trains_keep_left_and_a_normal_track_is_straight_on_from_both_sides(tmp_path: Path) -> None:
    def points(normal: str) -> dict[str, str]:
        rows: list[dict[str, object]] = [
            {"name": "A", "km": 0.0},
            {"name": "M", "km": 3.0, "tracks": 3, **({"normal": normal} if normal else {})},
            {"name": "Z", "km": 6.0},
        ]
        line = made(tmp_path, rows).line
        straight: dict[str, str] = {}
        for section, direction in (("A.1", Direction.DOWN), ("Z.1", Direction.UP)):
            for route in all_routes(line):
                normal_all = all(position.value == "normal" for _, position in route.points)
                if route.from_section == section and route.direction is direction and normal_all:
                    straight[section] = route.to_section
        return straight

    assert points("") == {"A.1": "M.1", "Z.1": "M.3"}
    assert points("2") == {"A.1": "M.2", "Z.1": "M.2"}


def test_the_text_is_the_line(tmp_path: Path) -> None:
    rows: list[dict[str, object]] = [{"name": "A", "km": 0.0}, {"name": "B", "km": 3.0, "tracks": 2}]
    new = made(tmp_path, rows)
    assert parse_line(new.text, "again") == new.line


@pytest.mark.parametrize("offset_m", [None, 0.0])
@pytest.mark.parametrize("tracks", range(1, TRACKS_MAX + 1))
def test_a_station_has_as_many_tracks_as_are_asked_for(
    tmp_path: Path, tracks: int, offset_m: float | None
) -> None:
    """At a stub, in the middle and at a portal; one of the tracks may lie where the points lead on."""
    where = {} if offset_m is None or tracks == 1 else {"offset_m": offset_m}
    rows: list[dict[str, object]] = [
        {"name": f"Station {i}", "km": 4.0 * i, "kind": "station", "tracks": tracks, **where}
        for i in range(3)
    ]
    rows[-1]["end"] = "portal"
    line = made(tmp_path, rows).line
    assert_every_track_leads_to_every_next_one(rows, line)
    pytest.importorskip("sumo", reason="netconvert comes with the extra `net`")
    (tmp_path / "net.xml").write_bytes(build_net(line))
    assert read_net(tmp_path / "net.xml")


@pytest.mark.parametrize("km", [(0.0, 0.0004, 4.0), (0.0, 3.9998, 4.0)])
def test_a_halt_where_a_station_is_does_not_vanish(tmp_path: Path, km: Sequence[float]) -> None:
    rows: list[dict[str, object]] = [
        {"name": n, "km": at, "tracks": 1} for n, at in zip("AHB", km, strict=True)
    ]
    with pytest.raises(InputError, match=r"expected at least 1 m from [AH], not 0 m"):
        made(tmp_path, rows)


@pytest.mark.parametrize("tracks", [0, TRACKS_MAX + 1])
def test_other_numbers_of_tracks_are_refused_at_once(tmp_path: Path, tracks: int) -> None:
    with pytest.raises(InputError, match=rf"stations\[1\].tracks is {tracks}; expected an integer 1 to"):
        made(tmp_path, [{"name": "A", "km": 0.0}, {"name": "B", "km": 4.0, "tracks": tracks}])


def test_a_list_of_which_no_line_comes_is_named_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Switched off, the points lead on where the middle one of five tracks lies: what is told names the list."""
    lay = layout.LaidPoints
    monkeypatch.setattr(layout, "LaidPoints", lambda *a, **given: lay(*a, **(given | {"offset_m": 0.0})))
    rows: list[dict[str, object]] = [{"name": "A", "km": 0.0}, {"name": "B", "km": 4.0, "tracks": 5}]
    with pytest.raises(InputError) as refused:
        made(tmp_path, rows)
    assert refused.value.file == str(tmp_path / "list.toml")
    assert "same track" in refused.value.expected
