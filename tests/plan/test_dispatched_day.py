"""A late day as a dispatching problem: what stands in it is of the line, and its solution is the order of a run."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from typer.testing import CliRunner

from branchline.cli import app
from network.errors import InputError
from plan.dispatching import day
from plan.dispatching.checker import objections
from plan.dispatching.day import DispatchedDay, day_of, moves_of
from plan.dispatching.instance import TrainOperation, read_instance, read_solution
from plan.dispatching.solver import solve
from scenario.scenario import load_scenario
from simulation.late.entry import entry_late_s
from simulation.late.settings import Late
from simulation.late_day import DrawnStay, late_day
from simulation.setup import Setup
from study.capacity.legs import follows_on, stand_of
from study.feasibility.planned import planned_day
from study.runner.journeys import journeys_of

SEED = 7
WORK = 1.0


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario("karasuyama_late", SEED).setup


@pytest.fixture(scope="module")
def punctual(setup: Setup) -> DispatchedDay:
    return day_of(replace(setup, late=Late()))


@pytest.fixture(scope="module")
def late(setup: Setup) -> DispatchedDay:
    return day_of(setup)


def test_a_punctual_day_costs_nothing(punctual: DispatchedDay) -> None:
    """All trains of the plan arrive as printed: they run with more time than they need."""
    answer = solve(punctual.instance, WORK)
    assert answer.proven
    assert answer.solution is not None and answer.solution.objective_value == 0


def test_a_train_that_comes_late_sets_out_so_much_later(
    setup: Setup, punctual: DispatchedDay, late: DispatchedDay
) -> None:
    moved: dict[str, int] = {}
    for index, legs in enumerate(late.legs):
        for leg, operation in zip(legs, late.departs[index], strict=True):
            ours = late.instance.trains[index][operation]
            if leg.start is not None and leg.start.section_id in {"HSK.MD"}:
                theirs = punctual.instance.trains[index][operation]
                moved[leg.number] = ours.start_lb - theirs.start_lb
    drawn = {
        n: entry_late_s(setup.late, SEED, setup.today, train) for n, train in setup.timetable.trains.items()
    }
    assert len(moved) > 5 and max(moved.values()) > 500
    assert all(abs(late_s - drawn[number]) <= 1.0 for number, late_s in moved.items())


def test_people_lengthen_a_stand_and_doors_put_off_a_departure(
    setup: Setup, punctual: DispatchedDay, late: DispatchedDay
) -> None:
    """As the late day draws them for its seed, to the second that times are rounded up to."""
    stays = late_day(setup).stays
    people_s, doors_s = 0.0, 0.0
    for index, legs in enumerate(late.legs):
        ours, theirs = late.instance.trains[index], punctual.instance.trains[index]
        for before, (leg, operation) in zip(
            (None, *legs), zip(legs, late.departs[index], strict=True), strict=False
        ):
            if leg.start is None or before is None or not follows_on(before, leg):
                continue
            station_id = setup.line.sections[leg.start.section_id].station_id or ""
            drawn = stays.get((leg.number, station_id), DrawnStay())
            sets_out_s = ours[operation].start_lb - theirs[operation].start_lb
            stands_s = ours[operation - 1].min_duration - theirs[operation - 1].min_duration
            assert sets_out_s == pytest.approx(drawn.doors_s, abs=1.0)
            # A late train's doors hold it as well (`simulation.platforms.held_until`).
            assert stands_s == pytest.approx(drawn.people_s + drawn.doors_s, abs=1.0)
            people_s, doors_s = people_s + drawn.people_s, doors_s + drawn.doors_s
    assert people_s > 60.0 and doors_s > 5.0


def test_what_halts_take_longer_is_time_on_the_way(
    setup: Setup, late: DispatchedDay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five of seven stations of the line are halts, where most of what a day draws is lost."""
    halts = {station.id for station in setup.line.stations.values() if station.is_halt}
    drawn_s = sum(
        stay.people_s + stay.doors_s
        for (_, station_id), stay in late_day(setup).stays.items()
        if station_id in halts
    )
    monkeypatch.setattr(day, "HALTS_COUNT", False)
    without = day_of(setup)
    lasts_s = [
        sum(operation.min_duration for train in problem.instance.trains for operation in train)
        for problem in (late, without)
    ]
    legs = sum(map(len, late.legs))
    assert drawn_s > 1000.0
    assert lasts_s[0] - lasts_s[1] == pytest.approx(drawn_s, abs=legs)  # each is rounded up


def turn_at_the_terminus(problem: DispatchedDay) -> tuple[TrainOperation, ...]:
    """Of 322M, which leaves the terminus: its stand there, the claim of its way, and the departure."""
    ((index, operation),) = [
        (index, operation)
        for index, legs in enumerate(problem.legs)
        for leg, operation in zip(legs, problem.departs[index], strict=True)
        if leg.number == "322M" and leg.start is not None and leg.start.section_id == "KRS.1"
    ]
    return problem.instance.trains[index][operation - 1 : operation + 2]


def test_each_set_has_what_its_way_needs_before_it_sets_out(
    setup: Setup, late: DispatchedDay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the request on, 45 s before the departure, it has the place and its way; without that, from then on."""
    _, claim, departure = turn_at_the_terminus(late)
    assert 45 <= departure.start_lb - claim.start_lb <= 50
    monkeypatch.setattr(day, "CLAIMS_COUNT", False)
    _, claim, _ = turn_at_the_terminus(day_of(setup))
    assert claim.min_duration > 300


def longest_beyond_its_stand_s(setup: Setup, problem: DispatchedDay) -> float:
    """By how much a train leaves later than its stand and its doors have it, that has its way set at once."""
    stays, found = late_day(setup).stays, list[float]()
    for index, legs in enumerate(problem.legs):
        train = problem.instance.trains[index]
        for (before, leg), operation in zip(pairwise(legs), problem.departs[index][1:], strict=True):
            if leg.start is None or not follows_on(before, leg) or not train[operation + 1].start_lb:
                continue  # its way is claimed as it leaves
            drawn = stays.get(
                (leg.number, setup.line.sections[leg.start.section_id].station_id or ""), DrawnStay()
            )
            least_s = stand_of(leg.start, setup.unit.dwell_min_s).least_s + drawn.people_s + drawn.doors_s
            stands_s, claims_s = (train[at].min_duration for at in (operation - 1, operation))
            assert stands_s + claims_s >= least_s
            found.append(stands_s + claims_s - least_s)
    return max(found)


def test_a_way_that_is_waited_for_is_set_in_the_time_that_that_takes(
    setup: Setup, late: DispatchedDay, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two telegrams before the terminus, which has no points, not the 45 s by which units ask; and within the stand."""
    _, claim, _ = turn_at_the_terminus(late)
    assert 0 < claim.min_duration <= 4
    assert longest_beyond_its_stand_s(setup, late) <= 2.0  # both are rounded up
    monkeypatch.setattr(day, "SET_IN_A_STAND", False)
    assert longest_beyond_its_stand_s(setup, day_of(setup)) > 40.0


def test_a_solution_names_each_move_of_the_manager_once(setup: Setup, late: DispatchedDay) -> None:
    answer = solve(late.instance, WORK)
    assert answer.solution is not None
    assert objections(late.instance, answer.solution) == []
    legs = late.order(answer.solution)
    order = moves_of(setup, legs)
    stocks = journeys_of(setup, planned_day(setup))
    assert {s.unit_id: len(s.moves) for s in stocks} == {s.unit_id: order.count(s.unit_id) for s in stocks}
    with pytest.raises(InputError):
        moves_of(setup, legs[:-5])


def test_one_late_train_goes_out_as_a_problem_and_comes_back_as_a_scenario(tmp_path: Path) -> None:
    """Its doors stay open for ten minutes longer, of which the plan has less to spare."""
    late = 'extends = "rtri_test_line"\n[late.doors.all]\nshare = 1.0\nsource = "made up"\n'
    (tmp_path / "late.toml").write_text(f'{late}seconds = {{ distribution = "fixed", mean_s = 600.0 }}\n')
    names = ("late.toml", "day.json", "solution.json", "ordered.toml")
    scenario, problem, solved, ordered = (str(tmp_path / name) for name in names)
    commands = (
        ["export", "displib", scenario, problem, "--json"],
        ["best", "displib", problem, "--work", "1", "--out", solved],
        ["import", "displib", scenario, solved, ordered],
    )
    out, _, back = (CliRunner().invoke(app, command).stdout for command in commands)
    (train,), told = read_instance(Path(problem)).trains, json.loads(out)
    assert (told["sets"], told["operations"], told["delays"]) == (1, len(train), 1)
    promised_s = read_solution(Path(solved)).objective_value
    assert 300 < promised_s <= 600 and f"promised {promised_s / 60.0:.1f} min late" in back
    assert load_scenario(ordered).setup.dispatch.given == ("K1",)


@pytest.mark.nightly
def test_export_solve_import(tmp_path: Path) -> None:
    problem, solved, ordered = (str(tmp_path / n) for n in ("day.json", "solution.json", "ordered.toml"))
    for command in (
        ["export", "displib", "karasuyama_late", problem, "--seed", "7"],
        ["best", "displib", problem, "--work", "1", "--out", solved],
        ["import", "displib", "karasuyama_late", solved, ordered, "--seed", "7"],
    ):
        assert CliRunner().invoke(app, command).exit_code == 0
    assert len(read_instance(Path(problem)).trains) == 4
    scenario = load_scenario(ordered)
    assert scenario.setup.seed == SEED
    assert len(scenario.setup.dispatch.given) > 50
    text = Path(ordered).read_text("utf-8")
    for out, said in ((ordered, "another name"), (problem, "NAME.toml"), (str(tmp_path / "a"), "NAME.toml")):
        again = CliRunner().invoke(app, ["import", "displib", ordered, solved, out, "--seed", "7"])
        assert isinstance(again.exception, InputError)
        assert said in str(again.exception)
    assert Path(ordered).read_text("utf-8") == text
    ordered = str(tmp_path / "other.toml")
    other = CliRunner().invoke(app, ["import", "displib", "karasuyama_late", solved, ordered, "--seed", "8"])
    assert isinstance(other.exception, InputError)
