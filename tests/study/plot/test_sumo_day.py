"""A scenario in plain SUMO: it runs to the end without a warning, trains where and when the timetable has them."""

import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from network.errors import InputError
from network.timetable import AtPortal, Timetable
from scenario.scenario import Scenario, load_scenario
from study.plot.sumo_day import SumoDay, export_sumo, setup_as_run, vehicles_of, write_files
from study.record.read_back import read_run
from study.runner.run import PartyLink, execute, write_run
from tests.plain import run_on_plain
from tests.scenario.own import own_scenario

sumo = pytest.importorskip("sumo", reason="the extra net is not installed")
AT_NIGHT = ("busy_line", "kururi_weekday", "isumi_weekday")
SCENARIOS = (
    *("rtri_test_line", "karasuyama_weekday"),
    *(pytest.param(name, marks=pytest.mark.nightly) for name in AT_NIGHT),
)
LATE_S = 60.0


@dataclass(frozen=True)
class Ran:
    """What plain SUMO made of a scenario."""

    folder: Path
    stops: list[dict[str, str]]
    trips: list[dict[str, str]]
    collisions: int


def run_sumo(scenario: Scenario, folder: Path) -> Ran:
    """The scenario as planned."""
    return run_day(export_sumo(scenario.id, scenario.setup, folder))


def run_day(day: SumoDay) -> Ran:
    """As a person runs it, but with everything validated, and nothing may be said on stderr."""
    folder = day.config.parent
    outputs = {name: folder / f"{name}.xml" for name in ("stop", "tripinfo", "collision")}
    command = [
        str(Path(sumo.SUMO_HOME) / "bin" / "sumo"),
        "-c",
        str(day.config),
        "--xml-validation",
        "always",
    ]
    command += ["--xml-validation.net", "always", "--xml-validation.routes", "always"]
    for name, path in outputs.items():
        command += [f"--{name}-output", str(path)]
    done = subprocess.run(
        command,
        env={**os.environ, "SUMO_HOME": str(sumo.SUMO_HOME)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    rows = {name: [dict(e.attrib) for e in ET.parse(path).getroot()] for name, path in outputs.items()}
    return Ran(folder, rows["stop"], rows["tripinfo"], len(rows["collision"]))


@pytest.fixture(scope="module", params=SCENARIOS)
def shown(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Scenario, Ran]:
    scenario = load_scenario(request.param)
    return scenario, run_sumo(scenario, tmp_path_factory.mktemp(request.param))


def test_every_vehicle_arrives_and_none_collides(shown: tuple[Scenario, Ran]) -> None:
    scenario, ran = shown
    assert {trip["id"] for trip in ran.trips} == {v.id for v in vehicles_of(scenario.setup)}
    assert all(float(trip["arrival"]) > 0 and not trip["vaporized"] for trip in ran.trips)
    assert all(float(trip["departDelay"]) == 0 for trip in ran.trips)
    assert ran.collisions == 0


def test_trains_stop_where_and_when_the_timetable_has_them(shown: tuple[Scenario, Ran]) -> None:
    scenario, ran = shown
    for stock_id, planned in stands_of(scenario.setup.timetable).items():
        seen = [stop for stop in ran.stops if stop["id"].partition("#")[0] == stock_id]
        seen.sort(key=lambda stop: float(stop["started"]))
        assert [(s["busStop"].partition(".")[0], s["tripId"]) for s in seen] == [p[:2] for p in planned]
        for stop, (_, _, arrival_s, departure_s) in zip(seen, planned, strict=True):
            if arrival_s is not None:
                assert float(stop["started"]) == pytest.approx(arrival_s, abs=LATE_S)
            if departure_s is not None:
                assert departure_s <= float(stop["ended"]) <= departure_s + LATE_S


def stands_of(timetable: Timetable) -> dict[str, list[tuple[str, str, int | None, int | None]]]:
    """Where each set stands by the timetable: station, the train it leaves as, arrival and departure, s.

    A set that becomes another train stands once, from the arrival of one to the departure of the other.
    """
    stands: dict[str, list[tuple[str, str, int | None, int | None]]] = {}
    for diagram in timetable.diagrams:
        own = stands.setdefault(diagram.stock_id, [])
        leaves = True
        for number in diagram.train_numbers:
            train = timetable.trains[number]
            calls = [call for call in train.calls if call.stops]
            if not leaves and not isinstance(train.begins, AtPortal):
                station, _, arrival_s, _ = own.pop()
                assert station == calls[0].station_id
                own.append((station, number, arrival_s, calls[0].departure_s))
                calls = calls[1:]
            own += [(call.station_id, number, call.arrival_s, call.departure_s) for call in calls]
            leaves = isinstance(train.ends, AtPortal)
    return stands


def test_plain_sumo_says_nothing_where_it_knows_no_home_of_its_own(tmp_path: Path) -> None:
    scenario = load_scenario("rtri_test_line")
    day = export_sumo(scenario.id, scenario.setup, tmp_path)
    homeless = {name: value for name, value in os.environ.items() if name != "SUMO_HOME"}
    program = Path(sumo.SUMO_HOME) / "bin" / "sumo"
    done = subprocess.run(
        [program, "-c", day.config], env=homeless, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
def test_a_train_that_passes_does_not_stand_and_passes_on_time(turn_back: str, tmp_path: Path) -> None:
    times = Path(turn_back).with_name("turn_back_times.toml")
    text = times.read_text("utf-8").replace(
        '{ station = "SHN", arrival = "05:42", departure = "05:43" }', '{ station = "SHN", pass = "05:43" }'
    )
    times.write_text(text, "utf-8")
    ran = run_sumo(load_scenario(turn_back), tmp_path / "out")
    (passed,) = (stop for stop in ran.stops if stop["busStop"] == "SHN.1+")
    assert passed["state"] == "waypoint"
    assert float(passed["started"]) <= 20_580 <= float(passed["ended"]) + LATE_S
    assert float(passed["ended"]) - float(passed["started"]) < 20


def test_a_run_directory_shows_the_day_as_it_ran(tmp_path: Path) -> None:
    """To the second, where the timetable has whole minutes."""
    scenario = load_scenario("karasuyama_round_trip")
    write_run(run_on_plain(scenario), tmp_path / "run")
    run = read_run(tmp_path / "run")
    ran = run_day(export_sumo(scenario.id, setup_as_run(run), tmp_path / "out"))
    as_run = {
        (row["train"], row["station"]): row["arrival_s"]
        for row in run.tables.stops.iter_rows(named=True)
        if row["arrival_s"] is not None
    }
    compared = 0
    for stop in ran.stops:
        key = (stop["tripId"], stop["busStop"].partition(".")[0])
        # A set that comes over the portal starts there at once and is at the station a little early.
        if key in as_run and key != ("321M", "HSK"):
            assert float(stop["started"]) == pytest.approx(as_run[key], abs=3.0)
            compared += 1
    assert compared >= 15
    assert ran.collisions == 0


@pytest.fixture
def crossed(tmp_path: Path) -> Scenario:
    """A day on the test line with a road, of another seed than the default."""
    road = 'id = "C1"\nsection = "6"\nkm = 0.75\nroad = { vehicles_per_h = [600.0] }\n'
    return own_scenario(tmp_path, f"seed = 7\n[[patch.line.add.crossings]]\n{road}", "rtri_test_line")


def test_a_road_is_in_it_and_nothing_stops_on_it(crossed: Scenario, tmp_path: Path) -> None:
    """Signals are off: netconvert's own program would stop the road for 5 s of 90. Of 600 an
    hour in 64 minutes 640 come, and four in a hundred are away from that by chance.
    """
    ran = run_sumo(crossed, tmp_path / "out")
    of_road = [trip for trip in ran.trips if trip["id"].startswith("road.")]
    assert 500 < len(of_road) < 760
    assert {float(trip["waitingTime"]) for trip in of_road} == {0.0}
    assert len(ran.trips) == len(of_road) + 1


def test_a_run_directory_has_the_vehicles_of_the_run(crossed: Scenario, tmp_path: Path) -> None:
    """Each from its departure as drawn; with another seed others come."""
    write_run(execute(crossed, PartyLink.SIMULATED), tmp_path / "run")
    run = read_run(tmp_path / "run")
    of_road = [
        export_sumo(name, setup, tmp_path / name).config.with_name(f"{name}.road.rou.xml")
        for name, setup in (
            ("as_run", setup_as_run(run)),
            ("planned", crossed.setup),
            ("other", replace(crossed.setup, seed=8)),
        )
    ]
    as_run, planned, other = (
        {vehicle.attrib["id"]: vehicle.attrib["depart"] for vehicle in ET.parse(file).iterfind("vehicle")}
        for file in of_road
    )
    both = as_run.keys() & planned.keys()
    assert len(both) > 500
    assert {name: as_run[name] for name in both} == {name: planned[name] for name in both}
    assert other != planned


def test_sumo_gui_opens_it_without_a_word(crossed: Scenario, tmp_path: Path) -> None:
    """Where there is a display to be had; netedit, which nothing ends but a person, reads the same files."""
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("no Xvfb, the display of tests")
    day = export_sumo(crossed.id, crossed.setup, tmp_path)
    read, write = os.pipe()
    with subprocess.Popen(
        [server, "-displayfd", str(write)], pass_fds=[write], stderr=subprocess.DEVNULL
    ) as display:
        os.close(write)
        with os.fdopen(read) as said:
            number = said.readline().strip()
        try:
            done = subprocess.run(
                [Path(sumo.SUMO_HOME) / "bin" / "sumo-gui", "-c", day.config, "--start", "--quit-on-end"],
                env={**os.environ, "SUMO_HOME": str(sumo.SUMO_HOME), "DISPLAY": f":{number}"},
                capture_output=True,
                text=True,
                check=False,
                timeout=120.0,
            )
        finally:
            display.terminate()
    if done.returncode == 127:
        pytest.skip(f"sumo-gui does not start here: {done.stderr.strip()}")
    complaints = [line for line in done.stderr.splitlines() if "Fontconfig" not in line]
    assert (done.returncode, complaints) == (0, [])


def test_a_set_that_leaves_the_line_and_comes_again_is_two_vehicles() -> None:
    setup = load_scenario("karasuyama_weekday").setup
    vehicles = vehicles_of(setup)
    assert {vehicle.id.partition("#")[0] for vehicle in vehicles} == {
        d.stock_id for d in setup.timetable.diagrams
    }
    for vehicle in vehicles:
        assert vehicle.edges[0].startswith(("HSK", "KRS", "OGN"))
        numbers = [stop.number for stop in vehicle.stops]
        assert numbers == sorted(numbers, key=numbers.index)  # each train's stops together


def test_files_are_written_all_or_none(tmp_path: Path) -> None:
    out = tmp_path / "out"
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="OUT"):
        write_files(tmp_path / "file", {"a": b"1"})
    (out / "b").mkdir(parents=True)
    (out / "b" / "own").write_text("somebody's")
    with pytest.raises(InputError, match="OUT"):
        write_files(out, {"b": b"2"})
    assert (out / "b" / "own").read_text() == "somebody's"
    assert write_files(out, {"a": b"1"}) == (out / "a",)
    assert sorted(path.name for path in out.iterdir()) == ["a", "b"]
