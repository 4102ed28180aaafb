"""The recipes of docs/make-a.md, all followed in one clone: what they touch, what checks it, and what each is for."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from onboard.driving.laws.hold_speed import HOLD_BAND_MPS
from tests.examples.conftest import CODE, RECIPES, Clone, cloned, files_of

HERE = Path(__file__).parent
LINE_SPEED_MPS = 45.0 / 3.6
ADDED_MAX = 400  # lines, by all recipes
FILES_AT_MOST = {"column": 2, "command": 2, "paper": 2, "sensor": 6, "table of settings": 2}
# What is asked of everything that an example can belong to.
TESTS = (
    "tests/branchline/test_cli.py::test_every_command_stands_in_a_group_and_its_help_begins_with_one_short_sentence",
    "tests/documents/test_faults.py",
    "tests/documents/test_files.py",
    "tests/documents/test_reproductions.py",
    "tests/documents/test_sensors.py",
    "tests/papers/test_reproduction.py",
    "tests/scenario/test_key_examples.py",
    "tests/simulation/faults/test_table.py",
    "tests/study/measures/test_driving.py",
    "tests/study/record/test_tables.py",
)
PAGES = {
    "faults": ("`weak_traction`", "`radar_knocked`"),
    "files/scenario": ("`[radar]`", "\n## `[patience]`\n"),
    "reproductions": ("| `one-beacon` | never run",),
    "sensors": ("## Radar",),
}
COLUMN = """
import json
from study.measures.driving import driving_sums
from study.record.driving import DrivenHop
from study.record.figure import figures_of, schema_of
from tests.study.measures.test_driving import hops
print(json.dumps({
    "column": list(schema_of(DrivenHop))[-1],
    "heading": figures_of(DrivenHop)["mean_kmh"].heading.en,
    "hops": [hop.mean_kmh for hop in hops()],
    "together": driving_sums(hops())["mean_kmh"],
}))
"""
SETTINGS = """
import json
from scenario.scenario import load_scenario
from network.errors import InputError
from scenario.schemas import schema_of
loaded = load_scenario("with_wait.toml")
try:
    load_scenario("below_range.toml")
except InputError as refused:
    message = str(refused)
print(json.dumps({
    "examples": schema_of("scenario")["$defs"]["WaitSettings"]["properties"]["wait_s"]["examples"],
    "wait_s": loaded.setup.patience.wait_s,
    "changes": [[change.key, change.old, change.new] for change in loaded.inputs.changes],
    "refused": message,
}))
"""
WITH_WAIT = """
extends = "rtri_test_line"
id = "{name}"
name = "With a table of its own"
patience.wait_s = {wait}
"""


@pytest.fixture(scope="module")
def touched() -> dict[str, set[str]]:
    """The files that each recipe touches, by its name."""
    return {}


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory, touched: dict[str, set[str]]) -> Clone:
    """A clone in which all of them have been followed."""
    clone = cloned(tmp_path_factory.mktemp("followed"))
    for name in RECIPES:
        touched[name] = clone.follow(name)
    clone.finish()
    return clone


@pytest.mark.usefixtures("followed")
@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_names_every_file_that_it_touches_and_no_other(
    name: str, touched: dict[str, set[str]]
) -> None:
    assert touched[name] == files_of(name) != set()
    assert len(touched[name]) <= FILES_AT_MOST.get(name, 99)


def test_all_that_is_checked_in_seconds_holds(followed: Clone) -> None:
    followed.tool("ruff", "format", "--check", "--no-cache", *followed.touched)
    followed.tool("ruff", "check", "--no-cache", *followed.touched)
    for page, texts in PAGES.items():
        written = (followed.root / f"docs/{page}.md").read_text("utf-8")
        assert [text for text in texts if text not in written] == []


@pytest.mark.nightly
def test_the_tests_of_what_was_added_to_hold(followed: Clone) -> None:
    followed.succeeds("-m", "pytest", "-p", "no:cacheprovider", "-m", "not nightly", *TESTS)


@pytest.mark.nightly
def test_types_and_everything_generated_hold_too(followed: Clone) -> None:
    followed.tool("mypy")
    (followed.root / ".venv").symlink_to(sys.prefix)
    followed.tool("basedpyright", *CODE)
    ceilings = followed.root / "documents" / "ceilings.toml"
    raised = re.sub(
        r"(\w+_lines) = (\d+)", lambda it: f"{it[1]} = {int(it[2]) + ADDED_MAX}", ceilings.read_text("utf-8")
    )
    ceilings.write_text(raised, "utf-8")
    followed.succeeds("-m", "documents.structure")
    followed.succeeds("-m", "documents.generated")


def test_a_column_has_its_totals_and_words(followed: Clone) -> None:
    found = json.loads(followed.succeeds("-c", COLUMN))
    assert (found["column"], found["heading"]) == ("mean_kmh", "mean speed, km/h")
    # by hand: 1000 m in 100 s, 1500 m in 200 s, 1000 m in 100 s; together weighed by the time
    assert found["hops"] == pytest.approx([36.0, 27.0, 36.0])
    assert found["together"] == pytest.approx(3.6 * 3500.0 / 400.0)


def test_a_command_ends_as_all_others_do(followed: Clone) -> None:
    command = ("-m", "branchline.cli", "train-kilometres")
    # 28 trains between Hoshakuji and Karasuyama, 20.4 km each as published
    found = json.loads(followed.succeeds(*command, "karasuyama_weekday", "--json"))
    assert found["train_km"] == pytest.approx(28 * 20.4, rel=0.01)
    refused = followed.python(*command, "nowhere")
    assert refused.returncode == 2
    assert "nowhere" in refused.stderr


def test_files_patches_and_schema_know_a_table_of_settings(followed: Clone) -> None:
    for name, wait, rest in (
        ("with_wait", 60.0, "[patch.patience]\ntimes = { wait_s = 2.0 }"),
        ("below_range", -1.0, ""),
    ):
        text = WITH_WAIT.format(name=name, wait=wait) + rest
        (followed.root / f"{name}.toml").write_text(text, "utf-8")
    found = json.loads(followed.succeeds("-c", SETTINGS))
    assert found["examples"] == [600.0]
    assert found["wait_s"] == 120.0
    assert found["changes"] == [["patience.wait_s", 600.0, 120.0]]
    for text in ("below_range.toml", "patience.wait_s", "-1.0", "0 to 3600"):
        assert text in found["refused"]


def reproduced(clone: Clone) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and rows of the paper's slice."""
    done = clone.python("-m", "branchline.cli", "reproduce", "one-beacon", "--quick", "--json")
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)["rows"]


@pytest.mark.nightly
def test_a_paper_is_reproduced_and_its_null_method_is_not(followed: Clone) -> None:
    code, rows = reproduced(followed)
    assert (code, [row["passed"] for row in rows]) == (0, [True, True])
    with_beacon, without = rows
    assert with_beacon["ours"] <= 0.5
    # up to 1 % of the kilometre since the last beacon
    assert 2.0 < without["ours"] < 10.0


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("was", "switched", "passed"),
    [
        ("beacons=1", "beacons=0", [False, True]),  # the method without its idea
        ("beacons=0", "beacons=1", [True, False]),  # a null method that has the idea
    ],
)
def test_a_paper_without_its_idea_fails(followed: Clone, was: str, switched: str, passed: list[bool]) -> None:
    place = followed.root / "papers/one_beacon.py"
    text = place.read_text("utf-8")
    assert text.count(was) == 1
    place.write_text(text.replace(was, switched), "utf-8")
    code, rows = reproduced(followed)
    place.write_text(text, "utf-8")
    assert (code, [row["passed"] for row in rows]) == (1, passed)


@pytest.mark.parametrize("scenario", ["law/slow_day", "sensor/radar_knocked"])
def test_a_scenario_can_choose_a_law_and_a_sensor(followed: Clone, scenario: str) -> None:
    followed.succeeds("-m", "branchline.cli", "check", str(HERE / f"{scenario}.toml"))


def test_without_its_row_no_scenario_can_choose_a_law(main: Callable[..., Any]) -> None:
    ended = main("check", str(HERE / "law/slow_day.toml"))
    assert ended.code == 2
    assert "half_limit" in ended.err


@pytest.mark.nightly
def test_a_law_holds_half_the_limit(followed: Clone) -> None:
    figures = followed.run(HERE / "law/slow_day.toml")
    assert (figures["trains_arrived"], figures["invariants_broken"]) == (1, 0)
    fastest_mps = pl.read_parquet(followed.root / "out/trajectory.parquet")["speed_mps"].max()
    assert 0.3 * LINE_SPEED_MPS < fastest_mps <= LINE_SPEED_MPS / 2.0 + HOLD_BAND_MPS  # type: ignore[operator]


def widest_m(out: Path) -> float:
    """The widest interval of the position on the way."""
    rows = pl.read_parquet(out / "trajectory.parquet")
    return float((rows["bound_ahead_m"] + rows["bound_behind_m"]).max())  # type: ignore[arg-type]


@pytest.mark.nightly
def test_a_sensor_with_a_constant_bias_narrows_the_bounds_and_keeps_the_truth_in_them(
    followed: Clone, main: Callable[..., Any]
) -> None:
    """Wheels may be wrong by 2 % of the way, at 12 m/s 0.24 m/s; the radar by 0.06 m/s."""
    figures = followed.run(HERE / "sensor/radar_day.toml")
    # the true position is within the stated bounds, in every step
    assert (figures["trains_arrived"], figures["invariants_broken"]) == (1, 0)
    narrow_m = widest_m(followed.root / "out")
    assert main("run", "rtri_test_line", "--json", "--out", "without").code == 0
    assert narrow_m < 0.7 * widest_m(Path("without"))


@pytest.mark.nightly
def test_a_sensor_that_is_worse_than_it_says_is_found_out(followed: Clone) -> None:
    """0.8 m/s wrong where 0.06 is stated: the truth leaves the bounds, and in the end the rule refuses the reading."""
    figures = followed.run(HERE / "sensor/radar_knocked.toml")
    assert figures["invariants_broken"] > 0
    assert '"fix_refused"' in (followed.root / "out/journal.jsonl").read_text("utf-8")
