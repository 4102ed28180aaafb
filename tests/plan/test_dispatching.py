"""The dispatcher's model against orders found by trying all, and the checker against solutions that are none."""

from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.json import encode
from msgspec.structs import replace
from ortools.sat.python.cp_model import CpSolver
from ortools.sat.python.cp_model_helper import Literal

from network.errors import InputError
from plan.dispatching import model, solver
from plan.dispatching.checker import cost_of, objections
from plan.dispatching.instance import (
    Instance,
    OperationDelay,
    ResourceUsage,
    Solution,
    StartEvent,
    Train,
    TrainOperation,
    read_instance,
    read_solution,
)
from plan.dispatching.model import DispatchModel
from plan.dispatching.solver import Answer, solve
from tests.nightly import others_nightly

WORK = 5.0
SHARED = Path(__file__).resolve().parents[2] / "../shared/data/displib"


def way(*legs: tuple[int, str], release: int = 0) -> Train:
    """A train that runs through these resources one after the other, so long each, and is gone."""
    uses = [tuple(ResourceUsage(name, release) for name in names.split()) for _, names in legs]
    running = [
        TrainOperation(lasts, (i + 1,), used)
        for i, ((lasts, _), used) in enumerate(zip(legs, uses, strict=True))
    ]
    return (*running, TrainOperation(0, ()))


def in_time(*trains: Train) -> Instance:
    """Each minute until a train is gone costs one."""
    delays = (OperationDelay("op_delay", a, len(train) - 1, coeff=1) for a, train in enumerate(trains))
    return Instance(trains, tuple(delays))


def with_loop(first: str, then: str) -> Train:
    """A single track with a loop of two tracks in its middle."""
    return (
        TrainOperation(10, (1, 2), (ResourceUsage(first),), start_ub=0),
        TrainOperation(1, (3,), (ResourceUsage("loop 1"),)),
        TrainOperation(1, (3,), (ResourceUsage("loop 2"),)),
        TrainOperation(10, (4,), (ResourceUsage(then),)),
        TrainOperation(0, ()),
    )


MEETING = in_time(with_loop("west", "east"), with_loop("east", "west"))


def test_two_trains_meet_in_the_loop() -> None:
    """Each runs 10 to the loop, stops for 1 on a track of its own, and runs 10 on."""
    answer = solve(MEETING, WORK)
    assert answer.proven
    assert answer.solution is not None
    assert (answer.solution.objective_value, answer.bound) == (42, 42)
    assert objections(MEETING, answer.solution) == []


def test_without_the_loop_neither_passes_the_other() -> None:
    """Each stands where the other has to go: they would change places in one instant."""
    answer = solve(in_time(way((10, "west"), (10, "east")), way((10, "east"), (10, "west"))), WORK)
    assert answer.solution is not None
    assert answer.solution.objective_value == 20 + 40  # one waits outside until the other is gone
    both_inside = tuple(
        (replace(train[0], start_ub=0), *train[1:])
        for train in (way((10, "west"), (10, "east")), way((10, "east"), (10, "west")))
    )
    assert solve(in_time(*both_inside), WORK).impossible


def overlooked(_dispatch: DispatchModel, _solver: CpSolver) -> list[Literal]:
    """No circle is found."""
    return []


def test_a_circle_of_three_is_cut_though_times_allow_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three trains in a ring of three resources cannot all move at once; no pair of them shares two in a row."""
    ring = [
        (replace(way((5, one), (5, other))[0], start_ub=0), *way((5, one), (5, other))[1:])
        for one, other in (("a", "b"), ("b", "c"), ("c", "a"))
    ]
    assert solve(in_time(*ring), WORK).impossible
    monkeypatch.setattr(solver, "_circle", overlooked)
    with pytest.raises(ValueError, match="cycle"):
        solve(in_time(*ring), WORK)


def test_a_circle_by_one_path_forbids_no_other() -> None:
    """A train may go straight on or by a siding beside its track, which another wants at 2 for no time at all.

    Straight on it would let go of the track and have it again in one instant. By the siding nobody waits.
    """
    track = (ResourceUsage("track"),)
    by_siding = (
        TrainOperation(0, (1, 2), track, start_ub=0),
        TrainOperation(1, (2,)),
        TrainOperation(0, (), track, start_ub=2),
    )
    other = (TrainOperation(0, (1,), track, start_lb=2), TrainOperation(0, ()))
    answer = solve(in_time(by_siding, other), WORK)
    assert answer.solution is not None
    assert answer.proven
    assert answer.solution.objective_value == 2 + 2


def test_a_released_resource_is_to_be_had_after_its_release_time() -> None:
    answer = solve(in_time(way((10, "x"), release=7), way((10, "x"), release=7)), WORK)
    assert answer.solution is not None
    assert answer.solution.objective_value == 10 + 27


def test_a_late_start_costs_its_increment_once() -> None:
    instance = replace(
        in_time(way((10, "x")), way((10, "x"))),
        objective=(OperationDelay("op_delay", 0, 1, 11, 5), OperationDelay("op_delay", 1, 1, 11, 3)),
    )
    answer = solve(instance, WORK)
    assert answer.solution is not None
    assert answer.solution.objective_value == 3
    assert [OperationDelay("op_delay", 0, 1, 11, 5, 2).cost(start) for start in (10, 11, 12)] == [0, 5, 7]


def test_little_work_is_told_from_a_proof() -> None:
    answer = solve(MEETING, 1e-9)
    assert not answer.proven
    assert not Answer(Solution(7, ()), 6, impossible=False, work=0.0).proven  # one from its bound
    assert not answer.impossible


def test_what_was_found_is_no_bound_until_it_is_proven() -> None:
    """Trains that want one track are gone soonest in all if the shortest goes first (Smith's rule)."""
    lasts = (19, 7, 13, 5, 17, 11, 3, 2)
    least, instance = sum(accumulate(sorted(lasts))), in_time(*(way((one, "x")) for one in lasts))
    little, enough = solve(instance, 0.002), solve(instance, 0.05)
    assert little.solution is not None and enough.solution is not None
    assert little.bound <= least < little.solution.objective_value and not little.proven
    assert enough.proven and enough.solution.objective_value == least


# every order tried ------------------------------------------------------------------------------------------------


def least_by_trying(instance: Instance) -> int | None:
    """The least cost over all paths and all orders of events, each as early as may be; independent of the model."""
    best: list[int] = []

    def go_on(events: tuple[StartEvent, ...], at: dict[int, StartEvent]) -> None:
        if all(a in at and at[a].operation == len(train) - 1 for a, train in enumerate(instance.trains)):
            best.append(cost_of(instance, events))
            return
        now = events[-1].time if events else 0
        for event in _next(instance, at, now, events):
            go_on((*events, event), {**at, event.train: event})

    go_on((), {})
    return min(best, default=None)


def _next(
    instance: Instance, at: dict[int, StartEvent], now: int, events: tuple[StartEvent, ...]
) -> Iterator[StartEvent]:
    for a, train in enumerate(instance.trains):
        before = at.get(a)
        choices = (0,) if before is None else train[before.operation].successors
        earliest = 0 if before is None else before.time + train[before.operation].min_duration
        for i in choices:
            had_by_others = {
                u.resource for b, e in at.items() if b != a for u in instance.trains[b][e.operation].resources
            }
            needs = {use.resource for use in train[i].resources}
            if needs & had_by_others:
                continue
            freed = max((_freed(instance, events, a, name) for name in needs), default=0)
            time = max(now, earliest, train[i].start_lb, freed)
            latest = train[i].start_ub
            if latest is None or time <= latest:
                yield StartEvent(time, a, i)


def _freed(instance: Instance, events: tuple[StartEvent, ...], train: int, resource: str) -> int:
    """When the last other train has let go of a resource for good."""
    free = 0
    last: dict[int, StartEvent] = {}
    for event in events:
        ended = last.get(event.train)
        if ended is not None and event.train != train:
            for use in instance.trains[event.train][ended.operation].resources:
                if use.resource == resource:
                    free = max(free, event.time + use.release_time)
        last[event.train] = event
    return free


USES = st.lists(st.sampled_from("abcd"), max_size=2, unique=True)


@st.composite
def trains(draw: st.DrawFn) -> Train:
    """Up to three operations, of which the second may be one of two, or be left out."""

    def operation(*successors: int) -> TrainOperation:
        release = draw(st.sampled_from((0, 0, 2)))
        used = tuple(ResourceUsage(name, release) for name in draw(USES))
        late = draw(st.sampled_from((None, None, None, 6)))
        early = draw(st.sampled_from((0, 0, 3)))
        return TrainOperation(draw(st.integers(0, 4)), successors, used, early, late)

    if draw(st.booleans()):
        return (operation(1), operation(2), TrainOperation(0, ()))
    if draw(st.booleans()):
        return (operation(1, 2), operation(2), operation(3), TrainOperation(0, ()))
    return (operation(1, 2), operation(3), operation(3), TrainOperation(0, ()))


@given(st.lists(trains(), min_size=2, max_size=3))
def test_it_costs_no_more_than_the_best_of_all_orders(drawn: list[Train]) -> None:
    instance = in_time(*drawn)
    answer, best = solve(instance, WORK), least_by_trying(instance)
    assert answer.impossible is (best is None)
    assert (None if answer.solution is None else answer.solution.objective_value) == best


@st.composite
def delays(draw: st.DrawFn, drawn: list[Train]) -> tuple[OperationDelay, ...]:
    """Costs of any operation, steps and slopes, of which one train may have several."""
    found: list[OperationDelay] = []
    for _ in range(draw(st.integers(1, 4))):
        train = draw(st.integers(0, len(drawn) - 1))
        operation = draw(st.integers(0, len(drawn[train]) - 1))
        threshold, increment, coeff = (draw(st.integers(0, most)) for most in (9, 20, 3))
        found.append(OperationDelay("op_delay", train, operation, threshold, increment, coeff))
    return tuple(found)


@given(st.data())
def test_steps_and_slopes_of_any_operation_are_weighed(data: st.DataObject) -> None:
    drawn = data.draw(st.lists(trains(), min_size=2, max_size=3))
    instance = Instance(tuple(drawn), data.draw(delays(drawn)))
    answer, best = solve(instance, WORK), least_by_trying(instance)
    assert (None if answer.solution is None else answer.solution.objective_value) == best
    if answer.solution is not None:
        assert not list(objections(instance, answer.solution))


@given(st.lists(trains(), min_size=2, max_size=3))
def test_one_answer_for_many_questions_loses_nothing(drawn: list[Train]) -> None:
    instance = in_time(*drawn)
    together = solve(instance, WORK)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(model, "ALIKE_COUNTS", False)
        apart = solve(instance, WORK)
    assert together.impossible is apart.impossible
    assert together.bound == apart.bound


# the checker ------------------------------------------------------------------------------------------------------


def solved() -> Solution:
    solution = solve(MEETING, WORK).solution
    assert solution is not None
    return solution


def moved(solution: Solution, event: int, **changes: int) -> Solution:
    events = list(solution.events)
    events[event] = replace(events[event], **changes)
    return replace(solution, events=tuple(events))


def test_the_checker_refuses_what_is_none() -> None:
    right = solved()
    assert objections(MEETING, right) == []
    assert "cost" in objections(MEETING, replace(right, objective_value=41))[0]
    assert "no such operation" in objections(MEETING, moved(right, 0, operation=9))[0]
    assert "comes after" in objections(MEETING, moved(right, 3, time=0))[0]
    assert any("not its exit" in o for o in objections(MEETING, replace(right, events=right.events[:-1])))
    assert any("does not begin" in o for o in objections(MEETING, replace(right, events=right.events[1:])))


def test_at_equal_times_the_order_of_events_counts() -> None:
    instance = in_time(way((10, "x")), way((10, "x")))
    first, gone = StartEvent(0, 0, 0), StartEvent(10, 0, 1)
    second, end = StartEvent(10, 1, 0), StartEvent(20, 1, 1)
    assert objections(instance, Solution(30, (first, gone, second, end))) == []
    wrong = objections(instance, Solution(30, (first, second, gone, end)))
    assert wrong == ["train 1, operation 0, at 10: takes x, which train 0, operation 0, at 0 still has"]


@pytest.mark.parametrize(
    ("second_s", "release", "said"), [(9, 0, "still has"), (16, 7, "leaves at 17"), (17, 7, None)]
)
def test_a_resource_is_had_by_one_train_until_it_is_released(
    second_s: int, release: int, said: str | None
) -> None:
    instance = in_time(way((10, "x"), release=release), way((10, "x"), release=release))
    events = [
        StartEvent(0, 0, 0),
        StartEvent(10, 0, 1),
        StartEvent(second_s, 1, 0),
        StartEvent(second_s + 10, 1, 1),
    ]
    events.sort(key=lambda event: event.time)
    found = objections(instance, Solution(20 + second_s, tuple(events)))
    assert found == [] if said is None else any(said in one for one in found)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('{"trains": [[]], "objective": []}', "trains[0]"),
        (
            '{"trains": [[{"min_duration": 1, "successors": [0]}]], "objective": []}',
            "trains[0][0].successors",
        ),
        (
            '{"trains": [[{"min_duration": -1, "successors": []}]], "objective": []}',
            "trains[0][0].min_duration",
        ),
        (
            '{"trains": [[{"min_duration": 1, "successors": [2]}, {"min_duration": 1, "successors": [2]},'
            ' {"min_duration": 0, "successors": []}]], "objective": []}',
            "trains[0][1]",
        ),
        (
            '{"trains": [[{"min_duration": 1, "successors": []}]],'
            ' "objective": [{"type": "op_delay", "train": 1, "operation": 0}]}',
            "objective[0].train",
        ),
    ],
)
def test_what_is_no_instance_is_told_by_its_place(tmp_path: Path, text: str, key: str) -> None:
    file = tmp_path / "instance.json"
    file.write_text(text)
    with pytest.raises(InputError) as error:
        read_instance(file)
    assert (error.value.file, error.value.key) == (str(file), key)


def test_who_has_a_resource_twice_lets_go_of_it_once_for_all(tmp_path: Path) -> None:
    uses = [(ResourceUsage("x", release),) for release in (20, 0)]
    twice = (*(TrainOperation(5, (i + 1,), used) for i, used in enumerate(uses)), TrainOperation(0, ()))
    events = [StartEvent(5 * i, 0, i) for i in range(3)] + [StartEvent(24, 1, 0), StartEvent(34, 1, 1)]
    instance = in_time(twice, way((10, "x")))
    assert "leaves at 25" in objections(instance, Solution(44, tuple(events)))[0]
    (tmp_path / "meeting.json").write_bytes(encode(MEETING))
    assert read_instance(tmp_path / "meeting.json") == MEETING  # earliest and latest at the same time


def test_numbers_that_no_solver_can_add_up_are_no_lack_of_an_order() -> None:
    row = (TrainOperation(10**18, (1,)), TrainOperation(10**18, ()))
    with pytest.raises(InputError, match="below"):
        solve(Instance((row,), (OperationDelay("op_delay", 0, 1, coeff=10**12),)), 0.1)


# published instances ----------------------------------------------------------------------------------------------

PROVEN = {
    "nor1_critical_4": 1506,
    "nor1_critical_5": 2677,
    "smi_close_0": 679,
    "swi_1": 0,
    "nor1_critical_1": 2416,
}


@pytest.mark.skipif(not SHARED.exists(), reason="the published instances are not beside this checkout")
@pytest.mark.parametrize("name", others_nightly(PROVEN, ["nor1_critical_4", "swi_1"]))
def test_published_instances_cost_what_is_best_known_and_no_less(name: str) -> None:
    """The best known costs are those of the library's solutions (2025); the solver reads none of them."""
    instance = read_instance(SHARED / "problems" / f"{name}.json")
    answer = solve(instance, 60.0)
    assert answer.proven
    assert answer.solution is not None
    assert answer.solution.objective_value == PROVEN[name]
    (published,) = (SHARED / "solutions").glob(f"{name}_*.json")
    best = read_solution(published)
    assert objections(instance, best) == []
    assert best.objective_value == PROVEN[name]
    assert objections(instance, replace(best, objective_value=best.objective_value + 1)) != []
