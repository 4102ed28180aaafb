"""A sweep file: the points it makes, what is drawn, and what is refused before anything is written."""

from collections.abc import Callable
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.files.toml_input import parse_table
from network.files.toml_text import put_value, steps_of, toml_of
from scenario.scenario import load_scenario
from scenario.sweep_file import DrawTable
from study.sweep.digest import inputs_digest
from study.sweep.draws import check_draw, drawn_value, value_at
from study.sweep.plan import SweepPlan, load_plan
from study.sweep.point import scenario_text
from tests.conftest import Ended
from tests.study.sweep.conftest import DRAW, SWEEP


def plan_of(folder: Path, text: str, carrier: str | None = None) -> SweepPlan:
    file = folder / "sweep.toml"
    file.write_text(text, "utf-8")
    return load_plan(str(file), carrier=carrier)


def test_points_and_days(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, SWEEP + DRAW)
    assert [point.label for point in plan.points] == ["radio delay 0.1 s", "radio delay 0.5 s"]
    first, second = (plan.spec(point, 4) for point in plan.points)
    assert first.seed == second.seed == 5
    assert first.drawn == second.drawn  # the same chance at every point
    assert first.key != second.key
    assert plan.spec(plan.points[0], 5).drawn != first.drawn
    assert [plan.runs_twice(index) for index in (0, 1, 9, 10)] == [True, False, False, True]
    assert not plan_of(tmp_path, SWEEP, carrier="sumo").runs_twice(0)


def test_the_last_day_has_the_greatest_seed_and_none_a_greater(tmp_path: Path) -> None:
    """Twelve days from 2^63 - 12; 63 bits hold 2^63 - 1."""
    plan = plan_of(tmp_path, SWEEP.replace("first = 1", f"first = {2**63 - 12}"))
    assert plan.spec(plan.points[0], 11).seed == 2**63 - 1
    with pytest.raises(InputError, match=r"seeds\.first"):
        plan_of(tmp_path, SWEEP.replace("first = 1", f"first = {2**63 - 11}"))


def test_point_is_the_scenario_written_by_hand(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, SWEEP + DRAW)
    spec = plan.spec(plan.points[1], 2)
    by_hand = tmp_path / "by_hand.toml"
    by_hand.write_text(
        f"""
        extends = "rtri_test_line"
        id = "by_hand"
        name = "by hand"
        seed = 3
        air.delay_mean_s = 0.5
        unit.dwell_min_s = {spec.drawn[0][1]}
        """,
        "utf-8",
    )
    made = tmp_path / "made.toml"
    made.write_text(scenario_text(spec), "utf-8")
    expected, found = (load_scenario(str(file)).setup for file in (by_hand, made))
    assert inputs_digest(found) == inputs_digest(expected)
    assert found.seed == expected.seed == 3


def test_digest_tells_what_a_day_is_made_of(tmp_path: Path) -> None:
    base = load_scenario("rtri_test_line").setup
    assert inputs_digest(base) == inputs_digest(load_scenario("rtri_test_line", 9).setup)
    plan = plan_of(tmp_path, SWEEP)
    assert plan.points[0].inputs == inputs_digest(base)  # 0.1 s is what the scenario has
    assert plan.points[1].inputs != plan.points[0].inputs


WRONG: list[tuple[str, Callable[[str], str], str]] = [
    ("no such scenario", lambda text: text.replace("rtri_test_line", "rtri_test_lime"), "scenario"),
    ("no such figure", lambda text: text.replace('"mean_late_s"', '"mean_lateness"'), r"watch\[0\]"),
    ("no such key", lambda text: text.replace("air.delay_mean_s", "air.delay_meam_s"), "air.delay_meam_s"),
    ("no key path", lambda text: text.replace("air.delay_mean_s", "air..delay"), r"axis\[0\].* key path"),
    ("value out of range", lambda text: text.replace("[0.1, 0.5]", "[0.1, -5.0]"), "air.delay_mean_s is -5.0"),
    ("labels too few", lambda text: text.replace('"0.1 s", ', ""), "2 labels"),
    ("same label", lambda text: text.replace('"0.1 s"', '"0.5 s"'), "called differently"),
    ("a key twice", lambda text: text + DRAW + DRAW.replace("shortest", "other"), "a key that is said once"),
    ("a table and its key", lambda text: text + DRAW.replace("unit.dwell_min_s", "air"), "a key that is said once"),
    ("seed as an axis", lambda text: text.replace("air.delay_mean_s", "seed"), "which each day has its own"),
    ("draw of nothing", lambda text: text + DRAW.replace("high = 40.0", ""), r"draw\[0\].high"),
    ("draw with more", lambda text: text + DRAW + "sigma = 1.0\n", "no such key of uniform"),
    ("drawn out of range", lambda text: text + DRAW.replace("40.0", "1e9"), "unit.dwell_min_s"),
    ("no days", lambda text: text.replace("days = 12", "days = 0"), "seeds.days"),
    ("stop that never", lambda text: text + '[stop]\nfigure = "mean_late_s"\nnarrower_than = 0.0\n', "more than 0"),
]  # fmt: skip


@pytest.mark.parametrize(("what", "damage", "told"), WRONG, ids=[name for name, _, _ in WRONG])
def test_refused_by_one_message(
    what: str, damage: Callable[[str], str], told: str, tmp_path: Path, main: Callable[..., Ended]
) -> None:
    (tmp_path / "sweep.toml").write_text(damage(SWEEP), "utf-8")
    with pytest.raises(InputError, match=told):
        load_plan(str(tmp_path / "sweep.toml"))
    if what in ("no such key", "no days"):
        ended = main("sweep", "sweep.toml", "--out", "out")
        assert (ended.code, ended.out) == (2, "")
        assert ended.err.count("\n") == 1
        assert [path.name for path in tmp_path.iterdir()] == ["sweep.toml"]


def test_places_that_say_several_things(tmp_path: Path) -> None:
    head, _, _ = SWEEP.partition("[[axis]]")
    plan = plan_of(
        tmp_path,
        head
        + """
[[axis]]
name = "radio"
[[axis.point]]
label = "as it is"
[[axis.point]]
label = "slow and lossy"
set = { "air.delay_mean_s" = 1.0, "air.loss_good_p" = 0.05 }
""",
    )
    assert [point.label for point in plan.points] == ["radio as it is", "radio slow and lossy"]
    assert plan.points[0].said == ()
    assert "delay_mean_s = 1.0\nloss_good_p = 0.05" in scenario_text(plan.spec(plan.points[1], 0))


def draw(**settings: object) -> DrawTable:
    return DrawTable.model_validate({"name": "x", "key": "unit.dwell_min_s", **settings})


@pytest.mark.parametrize(
    ("table", "of", "spread"),
    [
        (draw(distribution="uniform", low=10.0, high=20.0), 15.0, 2.89),
        (draw(distribution="normal", mean=5.0, sigma=2.0), 5.0, 2.0),
        (draw(distribution="exponential", mean=4.0), 4.0, 4.0),
        (draw(distribution="lognormal", median=10.0, sigma=0.5), 11.33, 6.04),
        (draw(distribution="triangular", low=0.0, high=6.0, mode=0.0), 2.0, 1.414),
        (draw(distribution="choice", values=[1.0, 3.0], weights=[3.0, 1.0]), 1.5, 0.866),
    ],
    ids=lambda value: value.distribution if isinstance(value, DrawTable) else "",
)
def test_draws_are_as_stated(table: DrawTable, of: float, spread: float) -> None:
    values = [drawn_value(table, seed) for seed in range(800)]
    assert mean(values) == pytest.approx(of, rel=0.08)
    assert stdev(values) == pytest.approx(spread, rel=0.15)
    assert values == [drawn_value(table, seed) for seed in range(800)]


def test_draws_are_cut_and_whole() -> None:
    table = draw(distribution="normal", mean=5.0, sigma=20.0, low=0.0, high=7.0, whole=True)
    values = {drawn_value(table, seed) for seed in range(200)}
    assert values <= set(range(8))
    assert {0, 7} <= values
    die = draw(distribution="uniform", low=1.0, high=6.0, whole=True)
    thrown = [value_at(die, (i + 0.5) / 600) for i in range(600)]
    assert thrown == sorted(thrown)
    assert [thrown.count(pips) for pips in range(8)] == [0, *[100] * 6, 0]
    with pytest.raises(InputError, match=r"low is 0.5; expected a whole number"):
        check_draw("sweep.toml", "draw[0]", die.model_copy(update={"low": 0.5}))


keys = st.text(min_size=1, max_size=8)
leaves = st.one_of(st.integers(-(2**62), 2**62), st.booleans(), st.floats(-1e9, 1e9), st.text(max_size=8))
tables = st.recursive(
    leaves, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(keys, inner, max_size=4))
)


@given(st.dictionaries(keys, tables, max_size=5))
def test_text_of_tables_reads_back(table: dict[str, Any]) -> None:
    assert parse_table(toml_of(table), "x") == table


def test_put_lays_tables_over_one_another() -> None:
    table: dict[str, Any] = {"a": {"b": 1, "c": {"d": 2}}}
    put_value(table, steps_of('a.c."e.f"', "", ""), 3)
    put_value(table, ("a",), {"b": {"x": 1}, "g": 4})
    assert table == {"a": {"b": {"x": 1}, "c": {"d": 2, "e.f": 3}, "g": 4}}
