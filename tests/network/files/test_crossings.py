"""`[[crossings]]`: the times of the ministry's interpretation where a line says nothing, and what is refused."""

from pathlib import Path

import pytest

from exchange.new_line import NewLineOptions, write_line
from network.errors import InputError
from network.files.crossing_road import roads_of
from network.files.crossings import least_closed_s, least_warning_s
from network.files.line_file import parse_line
from network.model import CrossingClass, Direction, LevelCrossing
from network.virtual_blocks import with_blocks_of

TEST_LINE = Path("network/lines/rtri_test_line.toml").read_text(encoding="utf-8")


def crossing(*keys: str) -> LevelCrossing:
    """The crossing of these keys, on section 6 (0.53 to 0.88 km) at 0.7 km unless they say otherwise."""
    own = {key.split(" ")[0] for key in keys}
    usual = [key for key in ('id = "C"', 'section = "6"', "km = 0.7") if key.split(" ")[0] not in own]
    if "piece" in own:
        usual.remove('section = "6"')
    text = "\n".join((TEST_LINE, "[[crossings]]", *usual, *keys))
    (found,) = parse_line(text, "line.toml").crossings.values()
    return found


@pytest.mark.parametrize(
    ("kind", "closing_s", "closed_s", "warning_s", "least_warning", "least_closed"),
    [("1", 15.0, 20.0, 35.0, 25.0, 15.0), ("3", 0.0, 30.0, 30.0, 20.0, 20.0)],
)
def test_the_times_of_article_62(
    kind: str,
    closing_s: float,
    closed_s: float,
    warning_s: float,
    least_warning: float,
    least_closed: float,
) -> None:
    found = crossing(f'kind = "{kind}"')
    assert (found.closing_s, found.closed_s, found.warning_s) == (closing_s, closed_s, warning_s)
    assert (least_warning_s(found), least_closed_s(found)) == (least_warning, least_closed)
    assert found.by_radio


def test_one_without_a_device_asks_nobody() -> None:
    found = crossing('kind = "4"')
    assert found.kind is CrossingClass.NO_DEVICE
    assert not (found.has_device or found.by_radio)


def test_each_direction_meets_its_own_edge_first() -> None:
    found = crossing("width_m = 8.0")
    assert (found.edge_m(Direction.DOWN), found.edge_m(Direction.UP)) == (696.0, 704.0)


def test_its_road_keeps_clear_of_points_on_the_track_beside_it(tmp_path: Path) -> None:
    """At B the points between the second track and the third lie from 2.8 to 2.88 km, where the first has begun."""
    (tmp_path / "list.csv").write_text("name,km,tracks\nA,0,1\nB,3,3\nC,6,1\n", "utf-8")
    write_line(tmp_path / "list.csv", tmp_path / "line.toml", NewLineOptions(max_speed_kmh=70.0))
    text = (tmp_path / "line.toml").read_text("utf-8")
    clear, beside = (f'{text}\n[[crossings]]\nid = "X"\nsection = "B.1"\nkm = {km}\n' for km in (2.9, 2.882))
    assert parse_line(clear, "line.toml").crossings["X"].position_m == 2900.0
    with pytest.raises(
        InputError, match=r"crossings\[0\]\.km is 2\.882; expected a place clear of points B\.12"
    ):
        parse_line(beside, "line.toml")


@pytest.mark.parametrize("section", ["B.1", "B.2"])
def test_its_road_goes_through_no_platform_of_whichever_track(tmp_path: Path, section: str) -> None:
    """Platforms of B, for trains of 40 m, lie from 2.96 to 3.04 km; a road of 6 m beside them ends where they do."""
    (tmp_path / "list.csv").write_text("name,km,tracks\nA,0,1\nB,3,2\nC,6,1\n", "utf-8")
    write_line(tmp_path / "list.csv", tmp_path / "line.toml", NewLineOptions(max_speed_kmh=70.0))
    text = (tmp_path / "line.toml").read_text("utf-8")
    platform = "platform_from_km = 2.96, platform_to_km = 3.04, "
    text = text.replace(f'section = "B.1", {platform}', 'section = "B.1", ')  # an island for the other track
    beside, through = (
        f'{text}\n[[crossings]]\nid = "X"\nsection = "{section}"\nkm = {km}\n' for km in (2.957, 2.958)
    )
    assert parse_line(beside, "line.toml").crossings["X"].position_m == 2957.0
    with pytest.raises(InputError, match=r"crossings\[0\]\.km is 2\.958; .* platform of B, 2\.96 to 3\.04"):
        parse_line(through, "line.toml")


def test_no_two_roads_lie_at_one_place() -> None:
    """Roads of 6 and 8 m: 7 m from middle to middle they meet."""
    one = f'{TEST_LINE}\n[[crossings]]\nid = "C"\nsection = "6"\nkm = 0.7\n'
    other = '[[crossings]]\nid = "D"\nsection = "6"\nwidth_m = 8.0\nkm = '
    assert len(parse_line(f"{one}{other}0.707\n", "line.toml").crossings) == 2
    with pytest.raises(
        InputError, match=r"crossings\[1\]\.km is 0\.706; expected a road clear of crossing C"
    ):
        parse_line(f"{one}{other}0.706\n", "line.toml")


def test_it_goes_with_its_block() -> None:
    """Three blocks of 350 m / 3: 0.7 km lies in the second, which begins at 0.6467 km."""
    text = f'{TEST_LINE}\n[[crossings]]\nid = "C"\nsection = "6"\nkm = 0.7\n'
    line = with_blocks_of(parse_line(text, "line.toml"), {"6": 3})
    assert line.crossings["C"].piece_id == "6_2"


def test_roads_are_read_from_the_tables_that_were_found_right() -> None:
    """By id of the crossing; one without a road has none, and a single figure counts for every hour."""
    rows = [{"id": "C1"}, {"id": "C2", "road": {"vehicles_per_h": [60.0], "lanes": 2}}]
    roads = roads_of({"crossings": rows}, "line.toml")
    assert list(roads) == ["C2"]
    assert (roads["C2"].per_h(23), roads["C2"].width_m) == (60.0, 12.0)
    assert roads_of({}, "line.toml") == {}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (['id = "B-W"'], "crossings[0].id is 'B-W'; expected an id that no terminal has"),
        (
            ['piece = "P7.stem"', "km = 0.885"],
            "crossings[0].piece is 'P7.stem'; expected a platform track or a section between stations: no crossing in"
            " points or a portal",
        ),
        (
            ['section = "PW"', "km = 0.04"],
            "crossings[0].section is 'PW'; expected a platform track or a section between stations: no crossing in"
            " points or a portal",
        ),
        (["km = 0.879"], "crossings[0].width_m is 6.0; expected at most 2, inside 6"),
        (["closing_s = 9.0"], "crossings[0].closing_s is 9.0; expected at least 10 s, and lowering_s = 8"),
        (["closed_s = 14.0"], "crossings[0].closed_s is 14.0; expected at least 15 s"),
        (['kind = "3"', "closed_s = 19.0"], "crossings[0].closed_s is 19.0; expected at least 20 s"),
        (
            ['kind = "3"', "closing_s = 15.0"],
            'crossings[0].closing_s is 15.0; expected only where kind = "1": nothing else closes',
        ),
        (
            ['control = "contacts"', "start_down_km = 0.3"],
            "crossings[0].start_up_km; expected a place: up trains start the warning by a contact",
        ),
        (
            ['control = "contacts"', "start_down_km = 0.75", "start_up_km = 1.0"],
            "crossings[0].start_down_km is 0.75; expected a place before 0.697, as down trains run",
        ),
        (
            ['kind = "3"', "detector = true"],
            'crossings[0].detector is true; expected false, or kind = "1": it looks while barriers are down',
        ),
        (
            ["protection = true"],
            'crossings[0].protection is true; expected false, or control = "contacts" and a device: by radio a crossing'
            " proves itself closed",
        ),
        *(
            (
                [*keys, "departures = true"],
                'crossings[0].departures is true; expected false, or control = "contacts", a device, and no protection:'
                " whoever asks hears that it is closed",
            )
            for keys in (
                [],
                ['control = "contacts"', "start_down_km = 0.6", "start_up_km = 0.8", "protection = true"],
            )
        ),
        (
            ['kind = "4"', "road = { vehicles_per_h = [60.0] }"],
            'crossings[0].road; expected kind = "1" or "3": drivers stop for lamps and barriers, and there are none',
        ),
        (
            ['kind = "3"', "road = { vehicles_per_h = [60.0], half_barriers = true }"],
            'crossings[0].road.half_barriers is true; expected false, or kind = "1"',
        ),
        (
            ["road = { vehicles_per_h = [60.0], lanes = 2 }"],
            "crossings[0].width_m is 6.0; expected at least 12: lanes = 2 each way",
        ),
        (
            ["road = { vehicles_per_h = [60.0, 70.0] }"],
            "crossings[0].road.vehicles_per_h is [60.0, 70.0]; expected one figure, or 24",
        ),
        (
            ["end_up_km = 0.7"],
            "crossings[0].end_up_km is 0.7; expected a place from 0.697 on, as up trains run",
        ),
    ],
)
def test_what_is_refused(keys: list[str], message: str) -> None:
    with pytest.raises(InputError) as caught:
        crossing(*keys)
    assert str(caught.value) == f"line.toml: {message}"
