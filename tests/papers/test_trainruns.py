"""Running times of another simulator by its own assumptions, each of which is needed; and what its files may hold."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from papers import trainruns_model
from papers.reference_data import BESIDE, VARIABLE, reference_folder
from papers.reproduction import Options
from papers.specification import reproduction
from papers.trainruns import FOLDER, OWN, PUBLISHED, WITHIN_S, as_theirs, converged_s, way_of
from papers.trainruns_files import ReferencePath, read_path, read_train
from papers.trainruns_model import ReferenceTrain, Stalled, UniformSection, running_time_s
from vehicle.train_file import load_train, shipped_train

DATA = BESIDE / FOLDER
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"reference data ../shared/data/{FOLDER} absent")
PATHS = ("const", "slope", "speed", "realworld")
TRAIN = ReferenceTrain(
    length_m=40.0,
    mass_kg=88_000.0,
    driving_kg=45_000.0,
    carrying_kg=23_000.0,
    cars_kg=0.0,
    mass_factor=1.08,
    limit_mps=120.0 / 3.6,
    braking_mps2=0.4,
    freight=False,
    driving_permille=3.0,
    carrying_permille=1.4,
    air_permille=3.9,
    cars_base_permille=0.0,
    cars_rolling_permille=0.0,
    cars_air_permille=0.0,
    effort=((0.0, 90_000.0), (10.0, 40_000.0), (40.0, 10_000.0)),
)


def case(train: str, path: str) -> tuple[ReferenceTrain, ReferencePath]:
    return read_train(DATA / "trains" / f"{train}.yaml"), read_path(DATA / "paths" / f"{path}.yaml")


@needs_data
@pytest.mark.parametrize(("train", "path"), PUBLISHED)
def test_its_running_times_within_2_hundredths(train: str, path: str) -> None:
    theirs, way = case(train, path)
    assert running_time_s(theirs, way.sections(theirs)) == pytest.approx(PUBLISHED[train, path], abs=WITHIN_S)


@needs_data
@pytest.mark.parametrize(
    "off",
    [
        "steps of 20 m",
        "refined steps",
        "its gravity",
        "wind",
        "empty mass rolls",
        "whole train under a limit",
    ],
)
def test_each_of_its_assumptions_is_needed(off: str, monkeypatch: pytest.MonkeyPatch) -> None:
    theirs, way = case(OWN, "realworld")
    step_m, refined = trainruns_model.STEP_M, trainruns_model.REFINED
    match off:
        case "steps of 20 m":
            step_m = 10.0
        case "refined steps":
            refined = 0
        case "its gravity":
            monkeypatch.setattr(trainruns_model, "GRAVITY_MPS2", 9.81)
        case "wind":
            monkeypatch.setattr(trainruns_model, "WIND_MPS", 0.0)
        case "empty mass rolls":
            theirs = replace(theirs, carrying_kg=theirs.mass_kg - theirs.driving_kg)
        case _:
            theirs = replace(theirs, length_m=0.0)
    time_s = running_time_s(theirs, way.sections(theirs), step_m, refined)
    assert abs(time_s - PUBLISHED[OWN, "realworld"]) > WITHIN_S


@needs_data
@pytest.mark.parametrize("path", PATHS)
def test_our_laws_by_its_assumptions_come_to_what_its_model_converges_to(path: str) -> None:
    theirs, way = case(OWN, path)
    fine_s = running_time_s(theirs, way.sections(theirs), 0.5, 1)
    kind = load_train(shipped_train("br642"))
    ours_s = converged_s(as_theirs(kind, theirs), way_of(way), theirs.braking_mps2)
    assert ours_s == pytest.approx(fine_s, abs=0.3)  # the train's length on gradients
    assert converged_s(kind.row, way_of(way), theirs.braking_mps2) > ours_s + 1.0  # its load rolls


@given(
    limits=st.lists(st.floats(4.0, 40.0), min_size=4, max_size=8),
    permille=st.lists(st.floats(-20.0, 20.0), min_size=8, max_size=8),
    step_m=st.sampled_from([20.0, 5.0]),
)
def test_it_is_no_faster_than_its_limits_and_finer_steps_change_little(
    limits: list[float], permille: list[float], step_m: float
) -> None:
    sections = [
        UniformSection(500.0 * i, 500.0 * (i + 1), min(limit, TRAIN.limit_mps), grade, (500.0 * (i + 1),))
        for i, (limit, grade) in enumerate(zip(limits, permille, strict=False))
    ]
    time_s = running_time_s(TRAIN, sections, step_m)
    assert time_s > sum(500.0 / section.limit_mps for section in sections)
    assert running_time_s(TRAIN, sections, 1.0, 1) == pytest.approx(time_s, rel=0.03)


def test_a_train_that_cannot_climb_is_told() -> None:
    steep = [
        UniformSection(0.0, 500.0, 20.0, 0.0, (500.0,)),
        UniformSection(500.0, 5000.0, 20.0, 200.0, (5000.0,)),
    ]
    with pytest.raises(Stalled):
        running_time_s(TRAIN, steep)


PATH_FILE = """\
schema: https://railtoolkit.org/schema/running-path.json
paths:
  - name: "two"
    points_of_interest:
      - [ 300.0, signal, rear ]  # of the rear
    characteristic_sections:
      - [ 0.0, 160, 0.0 ]
      - [ 500.0, 60, 2.0 ]
      - [ 1000.0, 60, 2.0 ]
"""


def test_a_path_is_cut_where_limit_or_gradient_change_and_at_its_points(tmp_path: Path) -> None:
    file = tmp_path / "path.yaml"
    file.write_text(PATH_FILE)
    first, second = read_path(file).sections(TRAIN)
    assert (first.begin_m, first.end_m, first.points_m) == (0.0, 500.0, (340.0, 500.0))
    assert (first.limit_mps, second.limit_mps) == (TRAIN.limit_mps, 60.0 / 3.6)
    assert (second.permille, second.points_m) == (2.0, (1000.0,))


TRAIN_FILE = """\
schema: https://railtoolkit.org/schema/rolling-stock.json
trains:
  - name: one
    id: T
    formation: [motor,car,car]
vehicles:
  - name: with motors
    id: motor
    vehicle_type: traction unit
    length: 20.0
    mass: 80
    mass_traction: 40
    speed_limit: 100
    rotation_mass: 1.1
    air_resistance: 10
    tractive_effort:
      - [0.0, 200000]
      - [100.0, 50000]
  - name: "without" # motors
    id: car
    vehicle_type: freight
    length: 15.0
    mass: 20
    load_limit: 40
    rotation_mass: 1.0
    base_resistance: 1.4
"""


def test_a_train_is_the_sum_of_its_vehicles(tmp_path: Path) -> None:
    file = tmp_path / "train.yaml"
    file.write_text(TRAIN_FILE)
    train = read_train(file)
    assert (train.length_m, train.mass_kg, train.cars_kg) == (50.0, 200_000.0, 120_000.0)
    assert (train.driving_kg, train.carrying_kg, train.freight) == (40_000.0, 40_000.0, True)
    assert train.mass_factor == pytest.approx((1.1 * 80 + 2 * 20) / 120)
    assert (train.cars_base_permille, train.limit_mps) == (1.4, 100.0 / 3.6)
    assert train.pull_n(50.0 / 3.6) == pytest.approx(125_000.0)
    assert train.pull_n(200.0 / 3.6) == 50_000.0


@pytest.mark.parametrize(
    ("read", "text", "changed", "key"),
    [
        (read_path, PATH_FILE, ("running-path", "rolling-stock"), "schema"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 500.0, fast, 2.0 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 500.0, nan, 2.0 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 500.0, 60 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 500.0, -60, 2.0 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 500.0, .inf, 2.0 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("[ 500.0, 60, 2.0 ]", "[ 0.0, 60, 2.0 ]"), "characteristic_sections"),
        (read_path, PATH_FILE, ("rear ]", "middle ]"), "points_of_interest"),
        (read_path, PATH_FILE, ("characteristic_sections", "characteristic"), "characteristic_sections"),
        (read_train, TRAIN_FILE, ("[motor,car,car]", "[motor,ghost]"), "formation"),
        (read_train, TRAIN_FILE, ("[motor,car,car]", "[car]"), "formation"),
        (read_train, TRAIN_FILE, ("[motor,car,car]", "[motor,motor]"), "formation"),
        (read_train, TRAIN_FILE, ("mass: 80", "mass: heavy"), "mass"),
        (read_train, TRAIN_FILE, ("    mass: 80\n", ""), "mass"),
        (read_train, TRAIN_FILE, ("speed_limit: 100", "speed_limit: 100\n    a_braking: 0.3"), "a_braking"),
        (read_train, TRAIN_FILE, ("[100.0, 50000]", "[0.0, 50000]"), "tractive_effort"),
        (read_train, TRAIN_FILE, ("vehicles:", "cars:"), "vehicles"),
    ],
)
def test_nonsense_in_a_path_or_a_train_is_bad_input(
    tmp_path: Path, read: Callable[[Path], object], text: str, changed: tuple[str, str], key: str
) -> None:
    file = tmp_path / "file.yaml"
    file.write_text(text.replace(*changed))
    with pytest.raises(InputError) as caught:
        read(file)
    assert key in str(caught.value)


def test_data_lies_beside_the_project_where_nobody_says_where() -> None:
    """Where every other test looks for it: one folder off, and all that need it are skipped."""
    root = Path(__file__).resolve().parents[2]
    assert BESIDE.resolve() == (root.parent / "shared/data").resolve()


def test_data_that_is_not_there_is_asked_for_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="--data or BRANCHLINE_DATA"):
        reference_folder(Options(data=str(tmp_path)), FOLDER)
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    with pytest.raises(InputError, match=VARIABLE):
        reference_folder(Options(), FOLDER)
    (tmp_path / FOLDER).mkdir()
    assert reference_folder(Options(), FOLDER) == (tmp_path / FOLDER).resolve()


@needs_data
def test_every_row_passes_and_what_is_between_the_two_is_taken_apart() -> None:
    result = reproduction("trainruns")(Options())
    assert [row.case for row in result.rows if not row.passed] == []
    own = [row for row in result.rows if not row.case.startswith(result.null.case(""))]
    assert [row.paper for row in own] == [PUBLISHED[OWN, path] for path in PATHS]
    by_name = {figure.name: figure.value for figure in result.figures}
    for path, row in zip(PATHS, own, strict=True):
        parts = [by_name[f"{path}: {part}, s"] for part in ("steps", "laws", "load")]
        assert row.beside == pytest.approx(row.ours + sum(parts), abs=0.03)
        assert by_name[f"{path}: plant, s"] > 0.0  # no whole train is faster than the least running time
