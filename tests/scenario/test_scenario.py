"""Scenarios: what a file says, what it takes over from another, and what is refused."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Position
from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.localisation.curvature_map import design_map
from onboard.localisation.curvature_map_file import write_map
from radio.air import DelayShape
from scenario.fleet_file import learned_json
from scenario.layers import merged_tables
from scenario.scenario import find_scenario, load_scenario, shipped_scenarios
from simulation.settings import Sensors
from vehicle.train_file import shipped_train

BASE = 'extends = "rtri_test_line"\nid = "s"\n'


def written(folder: Path, name: str, text: str) -> str:
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, "utf-8")
    return str(file)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_loads_and_is_named_as_its_file(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.id == name
    assert set(scenario.setup.trains) == {d.stock_id for d in scenario.setup.timetable.diagrams}
    assert scenario.inputs.assumed  # no scenario is without something that nobody published


def test_what_a_scenario_leaves_out_has_the_defaults() -> None:
    setup = load_scenario("rtri_test_line").setup
    assert setup.driving == Driving()
    assert setup.sensors == Sensors()
    assert (setup.air.delay_min_s, setup.air.delay_mean_s, setup.air.loss_p) == (0.1, 0.1, 0.0)
    assert setup.unit.dwell_min_s == setup.timetable.head.dwell_min_s == 20.0
    assert (setup.seed, setup.limits.time_limit_s, setup.limits.stall_limit_s) == (1, 3600.0, 3600.0)


def test_the_seed_of_the_command_line_comes_first(tmp_path: Path) -> None:
    file = written(tmp_path, "s.toml", BASE + "seed = 5\n")
    assert load_scenario(file).setup.seed == 5
    assert load_scenario(file, 6).setup.seed == 6
    assert load_scenario(file, 0).setup.seed == 0


def test_a_what_if_changes_what_it_names_and_nothing_else() -> None:
    whole, without = load_scenario("karasuyama_weekday"), load_scenario("karasuyama_without_loop")
    assert whole.inputs.changes == []
    assert {change.file for change in without.inputs.changes} == {"karasuyama.toml"}
    assert set(whole.setup.line.sections) - set(without.setup.line.sections) >= {"OGN.2"}
    assert without.setup.air == whole.setup.air
    assert without.setup.timetable == whole.setup.timetable
    assert without.setup.seed == whole.setup.seed


@pytest.mark.parametrize(
    ("file", "said"),
    [
        (shipped_line("rtri_test_line"), "line file: `branchline new timetable TIMES.toml --line {file} "),
        (shipped_timetable("rtri_test_line"), 'timetable: a scenario has `timetable = "{file}"`'),
        (shipped_train("br642"), 'train file: a scenario has `[trains] default = "{file}"`'),
        (Path("study/sweeps/karasuyama_late.toml"), "sweep: `branchline sweep {file}` runs it"),
        (Path("scenario/examples/station_list.toml"), "list of stations: `branchline new line {file} "),
    ],
)
def test_a_file_of_another_kind_is_named_with_what_is_to_be_given(
    tmp_path: Path, file: Path, said: str
) -> None:
    extending = written(tmp_path, "s.toml", f'extends = "{file.resolve()}"\nid = "s"\n')
    for name in (str(file), extending):
        with pytest.raises(InputError) as refused:
            load_scenario(name)
        named = refused.value.file
        assert Path(named).samefile(file)
        assert f"{named}; expected a scenario; this is a {said.format(file=named)}" in str(refused.value)


def test_tables_are_laid_over_key_by_key(tmp_path: Path) -> None:
    written(tmp_path, "low.toml", BASE + "seed = 3\n[air]\nloss_good_p = 0.25\ndelay_mean_s = 0.4\n")
    top = written(tmp_path, "top.toml", 'extends = "low"\nid = "top"\n[air]\ndelay_mean_s = 0.3\n')
    scenario = load_scenario(top)
    air = scenario.setup.air
    assert (scenario.id, scenario.setup.seed) == ("top", 3)
    assert (air.loss_good_p, air.delay_mean_s, air.delay_shape) == (0.25, 0.3, DelayShape.EXPONENTIAL)
    assert scenario.setup.line.id == "rtri_test_line"


def test_a_scenario_beside_the_file_comes_before_a_shipped_one(tmp_path: Path) -> None:
    written(tmp_path, "karasuyama_weekday.toml", BASE + "seed = 11\n")
    for name in ("karasuyama_weekday", "karasuyama_weekday.toml"):
        file = written(tmp_path, "s.toml", f'extends = "{name}"\nid = "mine"\n')
        assert load_scenario(file).setup.seed == 11


def test_files_are_found_beside_the_scenario_wherever_the_program_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shipped = (
        Path(load_scenario("rtri_test_line").file).parents[2] / "network" / "lines" / "rtri_test_line.toml"
    )
    text = shipped.read_text("utf-8").replace("max_speed_kmh = 45", "max_speed_kmh = 36")
    written(tmp_path / "mine", "line.toml", text)
    file = written(tmp_path / "mine", "s.toml", BASE + 'line = "line.toml"\n')
    monkeypatch.chdir(tmp_path)
    assert load_scenario(file).setup.line.max_speed_mps == pytest.approx(10.0)


def test_each_stock_may_have_its_own_train(tmp_path: Path) -> None:
    text = 'extends = "karasuyama_weekday"\nid = "s"\n[trains.stock]\nV2 = "br642"\n'
    trains = load_scenario(written(tmp_path, "s.toml", text)).setup.trains
    assert {stock: train.id for stock, train in trains.items()} == {
        "V1": "ev_e301",
        "V2": "br642",
        "V3": "ev_e301",
        "V4": "ev_e301",
    }


def test_the_points_of_the_papers_run_lie_the_other_way_at_first() -> None:
    line = load_scenario("rtri_test_line").setup.line
    assert {name: line.points[name].initial for name in ("P5", "P7")} == dict.fromkeys(
        ("P5", "P7"), Position.REVERSE
    )
    assert any("P5 and P7" in text for text in line.assumed)


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("extend = 1", "extend", 1),
        ("[limits]\ntime_limit_s = 0.0", "limits.time_limit_s", 0.0),
        ("[operation]\nchange_ends_s = -1.0", "operation.change_ends_s", -1.0),
        ("[trains]\nload_share_mean = 1.5", "trains.load_share_mean", 1.5),
        ('[air]\ndelay_shape = "gamma"', "air.delay_shape", "gamma"),
        ("[air]\nloss_good_p = nan", "air.loss_good_p", None),
        ("[unit]\ndwell = 3.0", "unit.dwell", 3.0),
        ("[unit]\ntag_accuracy_m = 0.0", "unit.tag_accuracy_m", 0.0),
        ("[sensors]\ntag_read_sigma_m = -0.1", "sensors.tag_read_sigma_m", -0.1),
        ("[driving]\nstanding_brake_share = 1.1", "driving.standing_brake_share", 1.1),
        ("[driving]\nservice_margin_mps = inf", "driving.service_margin_mps", None),
    ],
)
def test_what_cannot_be_is_refused_with_its_key(tmp_path: Path, text: str, key: str, value: object) -> None:
    file = written(tmp_path, "s.toml", BASE + text)
    with pytest.raises(InputError) as refused:
        load_scenario(file)
    assert (refused.value.file, refused.value.key) == (file, key)
    assert value is None or refused.value.value == value


def test_a_list_is_replaced_not_joined(tmp_path: Path) -> None:
    file = written(tmp_path, "s.toml", BASE + 'assumed = ["mine"]\n')
    assumed = load_scenario(file).inputs.assumed
    assert assumed[0] == "mine"
    assert not any("because the paper reports none" in text for text in assumed)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="karasuyama_weekday"):
        find_scenario("karasuyama")


Tables = st.recursive(
    st.integers(0, 9),
    lambda inner: st.dictionaries(st.sampled_from("abcd"), inner, max_size=4),
    max_leaves=12,
)
TABLE = st.dictionaries(st.sampled_from("abcd"), Tables, max_size=4)


def leaves(table: object, path: tuple[str, ...] = ()) -> dict[tuple[str, ...], object]:
    if not isinstance(table, dict):
        return {path: table}
    return {k: v for name, inner in table.items() for k, v in leaves(inner, (*path, name)).items()}


@given(TABLE, TABLE)
def test_laying_over_keeps_all_of_the_upper_and_adds_nothing(
    low: dict[str, object], high: dict[str, object]
) -> None:
    merged = leaves(merged_tables(low, high))
    upper, lower = leaves(high), leaves(low)
    assert upper.items() <= merged.items()
    assert merged.items() <= {**lower, **upper}.items()


@given(TABLE)
def test_laying_over_nothing_changes_nothing(table: dict[str, object]) -> None:
    assert merged_tables(table, {}) == merged_tables({}, table) == merged_tables(table, table) == table


def test_a_name_counts_from_the_file_that_says_it(tmp_path: Path) -> None:
    """A scenario that extends one of another folder takes over the files that lie beside that one."""
    below, above = tmp_path / "base", tmp_path / "above"
    below.mkdir()
    above.mkdir()
    for kind, name in (("lines", "rtri_test_line"), ("timetables", "rtri_test_line")):
        own = shipped_line(name) if kind == "lines" else shipped_timetable(name)
        (below / f"own_{kind}.toml").write_text(own.read_text("utf-8"), "utf-8")
    (below / "own_train.toml").write_text(shipped_train("br642").read_text("utf-8"), "utf-8")
    (below / "base.toml").write_text(
        'id = "base"\nname = "base"\nline = "own_lines.toml"\ntimetable = "own_timetables.toml"\n'
        '[trains]\ndefault = "own_train.toml"\n[belief.trains]\nK1 = "own_train.toml"\n'
        '[curvature]\nmap = "own_map.json"\n[tuning]\nlearned = "own_learned.json"\n',
        "utf-8",
    )
    write_map(design_map(load_scenario("rtri_test_line").setup.line), below / "own_map.json")
    counts = (1,) * 21
    (below / "own_learned.json").write_text(
        learned_json({"K1": Learned("K1", 0.5, counts, counts, 2, (7, 7))})
    )
    text = f'extends = "{below / "base.toml"}"\nid = "above"\nname = "above"\n'
    (above / "above.toml").write_text(text, "utf-8")
    setup = load_scenario(str(above / "above.toml")).setup
    assert {kind.id for kind in setup.trains.values()} == {"br642"}
    assert setup.line == load_scenario(str(below / "base.toml")).setup.line
    assert setup.curvature_map is not None and set(setup.learned) == {"K1"}
    assert setup.belief is not None and set(setup.belief.trains) == {"K1"}
    (above / "own_timetables.toml").write_text("nonsense", "utf-8")
    load_scenario(str(above / "above.toml"))  # what lies beside the upper one is not what the lower one means
