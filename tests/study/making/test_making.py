"""New files: they are valid, run as they stand, and leave nothing behind where they cannot be."""

import re
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

from exchange.new_line import NewLineOptions, write_line
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.timetable import CallKind, load_timetable
from scenario.scenario import load_scenario
from study.feasibility.check import feasibility
from study.making.scenario import new_drill, new_scenario
from study.making.timetable import Pattern, new_timetable
from study.making.train import Figures, new_train
from tests.plain import drill_on_plain, run_on_plain
from vehicle.train_file import shipped_train

VALLEY = Path(__file__).parents[2] / "examples" / "line" / "valley.toml"
HOUR_S = 3600


# scenario --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", ["karasuyama_weekday", "rtri_test_line", "busy_line"])
def test_a_new_scenario_changes_nothing(base: str, tmp_path: Path) -> None:
    made = new_scenario(base, tmp_path / "mine.toml")
    assert (made.id, made.inputs.changes) == ("mine", [])
    assert made.setup.timetable == load_scenario(base).setup.timetable


@pytest.mark.parametrize("base", ["karasuyama_weekday", "rtri_test_line", "busy_line"])
def test_every_example_in_a_new_scenario_is_valid_without_its_hash(base: str, tmp_path: Path) -> None:
    out = tmp_path / "mine.toml"
    new_scenario(base, out)
    rows = out.read_text("utf-8").splitlines()
    head = rows.index('id = "mine"')
    wanted = [row for row in rows[head:] if re.match(r"# ([\[\"]|[a-z_]+ = )", row)]
    assert len(wanted) > 12
    text = "\n".join(
        row.removeprefix("# ") if row in wanted and i >= head else row for i, row in enumerate(rows)
    )
    out.write_text(text, "utf-8")
    changed = load_scenario(str(out))
    changes = changed.inputs.changes
    assert {change.file for change in changes} >= {"mine.toml"} or len(changes) > 4
    assert changed.setup.unit.request_lead_s == 60.0
    assert changed.setup.seed == 2


@pytest.mark.parametrize("base", ["karasuyama_weekday", "rtri_test_line", "kururi_weekday"])
def test_each_example_in_a_new_scenario_is_valid_by_itself(base: str, tmp_path: Path) -> None:
    out = tmp_path / "mine.toml"
    new_scenario(base, out)
    text = out.read_text("utf-8")
    head, _, examples = text.partition("# Put `*`")
    said: set[str] = set()
    for block in examples.partition("\n")[2].split("\n\n"):
        plain = "\n".join(row.removeprefix("# ") for row in block.strip().splitlines())
        said |= set(tomllib.loads(plain).get("patch", {}))
        for line_of_it in plain.splitlines():
            assert not line_of_it.startswith("#")
        out.write_text(f"{head}\n{plain}\n", "utf-8")
        made = load_scenario(str(out))
        if "[patch.line.add]" in plain:
            assert made.inputs.changes
    assert said >= {"line", "timetable", "train", "air", "unit"}


def test_a_new_scenario_on_a_file_names_it_from_where_it_stands(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    new_scenario("rtri_test_line", tmp_path / "one.toml")
    made = new_scenario(str(tmp_path / "one.toml"), tmp_path / "below" / "two.toml")
    assert 'extends = "../one.toml"' in (tmp_path / "below" / "two.toml").read_text("utf-8")
    assert made.id == "two"


@pytest.mark.parametrize("name", ["mine.txt", "con.toml", "-x.toml", "nowhere/mine.toml", "there.toml"])
def test_a_file_that_cannot_be_made_is_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "there.toml").write_text("somebody's work", "utf-8")
    for make in (
        lambda out: new_scenario("rtri_test_line", out),
        lambda out: new_drill("rtri_test_line", out),
        lambda out: new_train("br642", out, Figures()),
        lambda out: new_timetable(str(VALLEY), "br642", Pattern(1800, 0, 3600), out, None),
    ):
        with pytest.raises(InputError) as refused:
            make(tmp_path / name)
        assert refused.value.key == "OUT"
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text("utf-8") == "somebody's work"


# drill -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", ["rtri_test_line", "karasuyama_round_trip"])
def test_a_new_drill_runs_and_is_passed(base: str, tmp_path: Path) -> None:
    made = new_drill(base, tmp_path / "mine.toml")
    assert len(made.setup.script.faults) == len(made.setup.script.acts) == 1
    drill = drill_on_plain(tmp_path / "mine.toml")
    assert drill.passed
    late_s = drill.run.summary["late_s_max"]
    assert late_s > 20.0  # the fault did something: the first train waits for its route


# train -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("like", ["ev_e301", "br642", "hitachi_train", "oda_train", "oda_scale_car"])
def test_a_copy_is_the_same_train_with_every_key_explained(like: str, tmp_path: Path) -> None:
    from vehicle.train_file import load_train, shipped_train

    out = tmp_path / "mine.toml"
    made = new_train(like, out, Figures())
    assert made.id == "mine"
    assert (made.row == load_train(shipped_train(like)).row).all()
    text = out.read_text("utf-8").partition("\n[provenance]\n")[0]
    keys = [row for row in text.splitlines() if re.match(r"[a-z0-9_]+ = ", row)]
    assert len(keys) > 30
    assert not [row for row in keys if " # " not in row]


def test_figures_of_ones_own_stand_in_their_places_and_are_named_as_given(tmp_path: Path) -> None:
    out = tmp_path / "mine.toml"
    made = new_train("ev_e301", out, Figures("A railbus", 20.0, 30.0, 1, 200.0, 30.0, 90.0))
    data = tomllib.loads(out.read_text("utf-8"))
    assert made.name == data["name"] == "A railbus"
    assert (data["body"]["length_m"], data["body"]["mass_empty_t"], data["body"]["cars"]) == (20.0, 30.0, 1)
    assert (data["traction"]["power_max_kw"], data["traction"]["force_max_kn"]) == (200.0, 30.0)
    assert data["body"]["speed_max_kmh"] == 90.0
    assert float(made.row[0]["length_m"]) == 20.0
    given = [key for key, text in data["provenance"].items() if text.startswith("given")]
    assert len(given) == 6


BODY_FIRST = ("[body]", "[body] # the body"), ("\nmass_empty_t = ", "\nmass_empty_t=")


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_file_of_ones_own_may_be_laid_out_otherwise(newline: str, tmp_path: Path) -> None:
    """With a comment behind a heading, no room about the sign, `[provenance]` before the figures, other line ends."""
    text = shipped_train("br642").read_text("utf-8")
    for was, becomes in BODY_FIRST:
        assert text.count(was) == 1
        text = text.replace(was, becomes)
    head, _, figures = text.partition("\n[body]")
    figures, _, provenance = figures.partition("[provenance]")
    own = tmp_path / "own.toml"
    own.write_text(f"{head}\n[provenance]{provenance}\n[body]{figures}", "utf-8", newline=newline)
    made = new_train(str(own), tmp_path / "mine.toml", Figures(mass_t=80.0, length_m=50.0))
    row = made.row[0]
    assert (row["mass_empty_kg"], row["length_m"]) == (80_000.0, 50.0)
    assert {"body.mass_empty_t", "body.length_m"} <= {text.partition(":")[0] for text in made.sources}


def test_a_figure_that_could_not_be_put_in_its_place_is_refused(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(shipped_train("br642").read_text("utf-8").replace("\nlength_m", '\n"length_m"'), "utf-8")
    with pytest.raises(InputError, match="line of its own"):
        new_train(str(own), tmp_path / "mine.toml", Figures(length_m=50.0))


def test_a_train_that_cannot_be_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        new_train("ev_e301", tmp_path / "mine.toml", Figures(mass_t=-3.0))
    assert "mass" in refused.value.key
    assert not list(tmp_path.iterdir())


# timetable -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "every_min", "trains"),
    [
        pytest.param("karasuyama", 60, 6, marks=pytest.mark.nightly),
        ("karasuyama", 120, 4),
        ("valley", 30, 12),
        pytest.param("busy_line", 30, 12, marks=pytest.mark.nightly),
    ],
)
def test_a_new_timetable_can_work(line: str, every_min: int, trains: int, tmp_path: Path) -> None:
    name = str(VALLEY) if line == "valley" else line
    pattern = Pattern(60 * every_min, 6 * HOUR_S, 9 * HOUR_S)
    day = new_timetable(name, "ev_e301", pattern, tmp_path / "tt.toml", tmp_path / "run.toml")
    assert day.trains == trains
    scenario = load_scenario(str(tmp_path / "run.toml"))
    found = feasibility(scenario.setup)
    assert found.good
    assert not found.impossible
    departures = sorted(
        train.calls[0].departure_s or 0
        for train in scenario.setup.timetable.trains.values()
        if train.direction > 0
    )
    steps = {after - before for before, after in pairwise(departures)}
    assert steps == {60 * every_min}
    assert departures[0] == 6 * HOUR_S


LINES_WITH_SIGNAL_STATIONS = {
    "one track": "name,km,tracks,kind\nA,0,2,\nK,3,1,signal station\nM,6,2,\nO,12,2,\n",
    "two tracks": "name,km,tracks,kind\nA,0,2,\nK,6,2,signal station\nO,12,2,\n",
    "the only loop": "name,km,tracks,kind\nA,0,1,\nK,6,2,signal station\nO,12,1,\n",
    "three": "name,km,tracks,kind\nA,0,2,\nK,3,2,signal station\nM,6,1,signal station\n"
    "N,9,2,signal station\nO,12,2,\n",
    "at an end": "name,km,tracks,kind\nA,0,2,signal station\nK,3,2,\nO,7,1,\n",
}


def line_file(folder: Path, text: str) -> Path:
    (folder / "list.csv").write_text(text, "utf-8")
    write_line(folder / "list.csv", folder / "drawn.toml", NewLineOptions())
    return folder / "drawn.toml"


@pytest.mark.parametrize(
    ("name", "every_min", "kind"),
    [
        ("one track", 60, CallKind.PASS),
        ("two tracks", 60, CallKind.PASS),
        ("the only loop", 60, CallKind.PASS),
        pytest.param("three", 15, CallKind.OPERATIONAL, marks=pytest.mark.nightly),
        ("at an end", 30, CallKind.OPERATIONAL),
    ],
)
def test_nobody_gets_out_at_a_signal_station(
    name: str, every_min: int, kind: CallKind, tmp_path: Path
) -> None:
    drawn = line_file(tmp_path, LINES_WITH_SIGNAL_STATIONS[name])
    pattern = Pattern(60 * every_min, 6 * HOUR_S, 8 * HOUR_S)
    assert new_timetable(str(drawn), "ev_e301", pattern, tmp_path / "tt.toml", tmp_path / "run.toml")
    setup = load_scenario(str(tmp_path / "run.toml")).setup
    signal = {station.id for station in setup.line.stations.values() if station.is_signal_station}
    calls = [call for train in setup.timetable.trains.values() for call in train.calls]
    inner = {c.kind for t in setup.timetable.trains.values() for c in t.calls if c.station_id in signal}
    assert kind in inner
    assert CallKind.STOP not in inner
    assert {call.kind for call in calls if call.station_id not in signal} == {CallKind.STOP}
    assert feasibility(setup).good


def test_the_examples_in_words_of_a_new_timetable_are_accepted(tmp_path: Path) -> None:
    out = tmp_path / "tt.toml"
    new_timetable("karasuyama", "ev_e301", Pattern(7200, 6 * HOUR_S, 9 * HOUR_S), out, None)
    text = out.read_text("utf-8")
    for word in ("`pass = ", "`operational = true`", "`track`"):
        assert word in text
    line = load_line(shipped_line("karasuyama"))
    call = re.search(r'\{ station = "(OGN)", arrival = "([0-9:]+)", departure = "([0-9:]+)"', text)
    assert call is not None
    track = line.stations["OGN"].tracks[0].name
    for said in (
        f'pass = "{call[3]}"',
        call[0][2:] + ", operational = true",
        call[0][2:] + f', track = "{track}"',
    ):
        begin = said if said.startswith("station") else f'station = "OGN", {said}'
        out.write_text(text.replace(call[0], "{ " + begin, 1), "utf-8")
        load_timetable(out, line)


def test_the_shipped_line_and_the_file_name_one_another(tmp_path: Path) -> None:
    new_timetable(str(VALLEY), "br642", Pattern(1800, 0, 3600), tmp_path / "tt.toml", None)
    timetable = load_timetable(tmp_path / "tt.toml", load_line(VALLEY))
    assert timetable.head.line == load_line(VALLEY).id
    with pytest.raises(InputError):
        load_timetable(tmp_path / "tt.toml", load_line(shipped_line("karasuyama")))


def test_a_new_timetable_runs_on_time(tmp_path: Path) -> None:
    pattern = Pattern(1800, 6 * HOUR_S, 7 * HOUR_S + 1)
    new_timetable(str(VALLEY), "ev_e301", pattern, tmp_path / "tt.toml", tmp_path / "run.toml")
    run = run_on_plain(tmp_path / "run.toml")
    assert not run.broken
    assert run.summary["trains_arrived"] == run.summary["trains_planned"] == 5
    assert run.summary["late_s_max"] < 30.0


def test_an_interval_that_cannot_work_is_refused_with_one_that_can(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        new_timetable(
            "karasuyama", "ev_e301", Pattern(900, 6 * HOUR_S, 12 * HOUR_S), tmp_path / "tt.toml", None
        )
    assert refused.value.key == "--every"
    least_min = int(re.findall(r"\d+", refused.value.expected)[0])
    assert not list(tmp_path.iterdir())
    pattern = Pattern(60 * least_min, 6 * HOUR_S, 12 * HOUR_S)
    assert new_timetable("karasuyama", "ev_e301", pattern, tmp_path / "tt.toml", None)
    assert 'stock = "' in (tmp_path / "tt.toml").read_text("utf-8")


@pytest.mark.parametrize(("every_min", "places"), [(30, 0), (20, 1)])
def test_trains_meet_where_there_is_room_if_some_pattern_has_it(
    tmp_path: Path, every_min: int, places: int
) -> None:
    """One loop, at 9.8 of 16.4 km. Of half-hourly trains the second to try meets there, and the first just before it.

    Two meets an interval, and one loop: at 20 min trains either meet at it and at an end, or nearby.
    """
    listed = "name,km,tracks,kind\nA,0,2,\nM,5.2,1,halt\nS,9.8,2,\nY,16.4,1,station\n"
    pattern = Pattern(60 * every_min, 6 * HOUR_S, 8 * HOUR_S)
    drawn = str(line_file(tmp_path, listed))
    made = new_timetable(drawn, "ev_e301", pattern, tmp_path / "tt.toml", tmp_path / "run.toml")
    setup = load_scenario(str(tmp_path / "run.toml")).setup
    found = feasibility(setup)
    assert found.on_time
    assert (made.tight, len({finding.place for finding in found.findings})) == (places, places)
    assert made.sets == len(setup.timetable.diagrams)


def test_no_more_trains_are_tried_than_are_asked_for(tmp_path: Path) -> None:
    """Every quarter of an hour is too often where the only loop lies 8 km from one end, but not a single time."""
    drawn = str(line_file(tmp_path, "name,km,tracks,kind\nA,0,1,\nK,4,2,signal station\nO,12,1,\n"))
    one = Pattern(900, 6 * HOUR_S, 6 * HOUR_S + 899)
    assert new_timetable(drawn, "ev_e301", one, tmp_path / "one.toml", None).trains == 2
    with pytest.raises(InputError):
        new_timetable(drawn, "ev_e301", Pattern(900, 6 * HOUR_S, 7 * HOUR_S), tmp_path / "more.toml", None)


def test_times_that_make_no_day_are_refused(tmp_path: Path) -> None:
    for pattern, key in ((Pattern(0, 0, 3600), "--every"), (Pattern(3600, 7200, 3600), "--to")):
        with pytest.raises(InputError) as refused:
            new_timetable("karasuyama", "ev_e301", pattern, tmp_path / "tt.toml", None)
        assert refused.value.key == key
