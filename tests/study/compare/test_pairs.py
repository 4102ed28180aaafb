"""Five pairs of runs: each difference that is told is the one that a direct computation from the tables gives."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from study.compare.comparison import RunComparison, compare, verdict_of
from study.compare.measures import Measure
from study.compare.meets import MeetFate, meets_of
from study.compare.side import read_sides
from study.compare.times import CallEvent
from study.runner.run import write_run
from tests.nightly import others_nightly
from tests.plain import run_on_plain
from tests.study.compare.pairs import (
    ROUND_TRIP_PAIRS,
    WEEKDAY_PAIRS,
    gap_directly,
    least_left_directly,
    meets_directly,
    moved_directly,
    net_kwh_by_train_directly,
    net_kwh_directly,
    scenario,
    sent_directly,
    share_in_time_directly,
    trains_directly,
)

OVER_S = 1.0
IN_EVERY_RUN = ("slower_points", "one_more")  # what is not as it was, and what was not there
MADE = Callable[[str, str], Path]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> MADE:
    """The run directory of a scenario that extends another, run once."""

    @cache
    def make(base: str, text: str) -> Path:
        folder = tmp_path_factory.mktemp("pair")
        file = scenario(folder, base, "changed", text) if text else base
        run = run_on_plain(file)
        return write_run(run, folder / "run").parent

    return make


def check_against_the_tables(base: Path, new: Path) -> RunComparison:
    """Everything that is told of a pair, worked out a second time."""
    sides = read_sides([base, new])
    found = compare(sides, OVER_S)
    (pair,) = found.pairs
    measures = {(measure.group, measure.name, measure.unit): measure for measure in found.measures}

    def values(group: str, name: str, unit: str = "") -> tuple[float, float]:
        measure: Measure = measures[group, name, unit]
        old, late = measure.values
        assert old is not None and late is not None
        return old, late

    told = {(m.train, m.station, m.what.value, m.by_s) for m in pair.times.moved}
    assert told == moved_directly(base, new, OVER_S)
    trains = trains_directly(base), trains_directly(new)
    assert (set(pair.times.only_base), set(pair.times.only_new)) == (
        trains[0] - trains[1],
        trains[1] - trains[0],
    )
    for index, (side, folder) in enumerate(zip(sides, (base, new), strict=True)):
        meets = meets_of(side.run)
        assert {(meet.down_train, meet.up_train): meet.at[0] for meet in meets} == meets_directly(folder)
        assert all(gap_directly(folder, m.down_train, m.up_train, m.time_s) < 5.0 for m in meets)
        assert values("energy", "net", "kWh")[index] == pytest.approx(net_kwh_directly(folder))
        assert values("telegrams", "sent")[index] == sum(sent_directly(folder).values())
        assert values("margins", "least left as run", "s")[index] == pytest.approx(
            least_left_directly(folder)
        )
        for name, most_s in (
            ("not late (within 5 s)", 5.0),
            ("at most 1 min late", 60.0),
            ("at most 5 min late", 300.0),
        ):
            for what in ("arrival", "departure"):
                share = share_in_time_directly(folder, what, most_s)
                assert values(f"{what}s", name, "%")[index] == pytest.approx(share)
    check_rows(pair, base, new)
    return pair


def check_rows(pair: RunComparison, base: Path, new: Path) -> None:
    """Energy by train and telegrams by kind: what is listed, and that nothing else differs."""
    for table, column, directly in (
        ("energy", "net_kwh", net_kwh_by_train_directly),
        ("telegrams", "sent", sent_directly),
    ):
        listed = {row.names[0]: row.values[column] for row in pair.rows[table]}
        old, late = directly(base), directly(new)
        for name in {*old, *late}:
            expected = old.get(name), late.get(name)
            if name in listed:
                assert listed[name] == pytest.approx(expected)
            else:
                assert expected[0] == expected[1]


@pytest.mark.parametrize("name", others_nightly(ROUND_TRIP_PAIRS, IN_EVERY_RUN))
def test_a_pair_of_round_trips(made: MADE, name: str) -> None:
    base = made("karasuyama_round_trip", "")
    pair = check_against_the_tables(base, made("karasuyama_round_trip", ROUND_TRIP_PAIRS[name]))
    keys = {change.key for change in pair.inputs}
    by = {label for change in pair.inputs for label in change.by}
    verdict = " ".join(verdict_of(pair))
    match name:
        case "slower_points":
            assert keys == {"points.OGN.11.throw_time_s", "points.OGN.21.throw_time_s"}
            assert by == {pair.new}
            assert all(change.old == 6.0 and change.new == 45.0 for change in pair.inputs)
            assert pair.times.moved
        case "radio_of_2_s":
            (change,) = pair.inputs
            assert (change.key, change.old, change.new) == ("air.delay_mean_s", 0.2, 2.0)
            assert pair.times.moved
        case "restriction":
            (change,) = pair.inputs
            assert (change.file, change.key) == ("karasuyama.toml", "alignments.main.limits")
            # Between Konoyama and Ogane: who comes from there comes later, and nobody leaves earlier anywhere.
            assert {"321M", "322M", "324M"} >= {moved.train for moved in pair.times.moved} != set()
            assert all(moved.by_s > 0.0 for moved in pair.times.moved if moved.what.value == "departure")
        case "one_more":
            assert pair.times.only_new == ("323M",)
            assert f"Only in {pair.new}: train 323M." in verdict
            (meet,) = (change for change in pair.meets if change.fate is MeetFate.NEW)
            assert (meet.down_train, meet.up_train) == ("323M", "324M")
            assert meet.new is not None and meet.new.at == ("OGN",)
            assert meet.why.en == "323M did not run in the base run"
        case _:
            assert "trains.default" in keys
            assert {"energy", "margins"} <= {table for table, rows in pair.rows.items() if rows}


def test_a_run_and_itself_again_differ_in_nothing(made: MADE, tmp_path: Path) -> None:
    base = made("karasuyama_round_trip", "")
    run = run_on_plain("karasuyama_round_trip")
    again = write_run(run, tmp_path / "again").parent
    pair = check_against_the_tables(base, again)
    assert pair.nothing_differs and pair.same_inputs
    assert (pair.inputs, pair.times.moved, pair.times.once, pair.meets) == ((), (), (), ())
    assert not any(pair.rows.values())
    assert pair.times.largest_s == 0.0
    assert verdict_of(pair)[0].startswith("Nothing differs at all, from the same inputs")


@pytest.mark.nightly
@pytest.mark.parametrize("name", WEEKDAY_PAIRS)
def test_a_pair_of_weekdays(made: MADE, name: str) -> None:
    check_against_the_tables(made("karasuyama_weekday", ""), made("karasuyama_weekday", WEEKDAY_PAIRS[name]))


SLOWER_S = 20.0 - 6.0
SLOW_POINTS = """
[patch.line.set]
"points.OGN.11.throw_time_s" = 20.0
"points.OGN.21.throw_time_s" = 20.0
"""


@pytest.mark.nightly
def test_the_slow_points_of_the_planners_page_move_arrivals_there_alone(made: MADE) -> None:
    """Of trains for which they are thrown as they come; by less than the points take longer."""
    base, new = made("karasuyama_weekday", ""), made("karasuyama_weekday", SLOW_POINTS)
    moved = check_against_the_tables(base, new).times.moved
    assert {(time.station, time.what) for time in moved} == {("OGN", CallEvent.ARRIVAL)}
    assert all(1.0 < time.by_s < SLOWER_S for time in moved)
