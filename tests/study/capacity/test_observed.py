"""Blocking times of runs: whole, never two stocks' at once, and as the table keeps them."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Direction
from scenario.scenario import load_scenario, shipped_scenarios
from simulation.result import RunResult
from simulation.setup import Setup
from study.capacity.blocking_table import blocking_table, read_blocking
from study.capacity.compared import theory_and_run
from study.capacity.occupation import TOUCH_S, Occupation, OccupationPart, Slice, conflicts_of
from study.capacity.passage import PassageStand, SectionPassage, occupation_of
from study.capacity.theory import occupations
from study.drilling.drill import find_drill, shipped_drills
from study.measures import register_holds as module
from study.measures.register_holds import Throwing
from tests.plain import run_on_plain
from tests.study.capacity.by_hand import occupations_of_run

times = st.one_of(st.floats(0.0, 1000.0), st.sampled_from([float("inf"), float("-inf")]))


@given(
    wanted_s=st.floats(0.0, 1000.0),
    moments=st.tuples(*(times for _ in range(9))),
    throws=st.lists(st.tuples(*(st.floats(0.0, 1000.0) for _ in range(4))), max_size=2),
    stands=st.lists(st.tuples(st.sampled_from(list(OccupationPart)), times, times), max_size=4),
    ends_s=st.floats(0.0, 2000.0),
)
def test_any_moments_make_a_whole(
    wanted_s: float,
    moments: tuple[float, ...],
    throws: list[tuple[float, float, float, float]],
    stands: list[tuple[OccupationPart, float, float]],
    ends_s: float,
) -> None:
    """Faults put the moments into any order: the slices touch and make up what lies between the first and the last."""
    passage = SectionPassage(
        *("s", "K1", "T1", Direction.DOWN, "r", wanted_s, *moments),
        throwing=tuple(Throwing(*sorted(each)) for each in throws),
        standing=tuple(PassageStand(*each) for each in stands),
    )
    made = occupation_of(passage, ends_s)
    freed_s = moments[-1]
    end_s = max(min(freed_s, ends_s), wanted_s)
    assert made.begin_s == pytest.approx(wanted_s, abs=20 * TOUCH_S)
    assert made.end_s == pytest.approx(end_s, abs=20 * TOUCH_S)
    assert sum(made.of_part(part) for part in OccupationPart) == pytest.approx(made.length_s, abs=1e-5)


@pytest.fixture(scope="module")
def ran() -> tuple[RunResult, Setup]:
    scenario = load_scenario("rtri_test_line")
    return run_on_plain(scenario).result, scenario.setup


def test_the_paper_s_run_is_as_theory_has_it(ran: tuple[RunResult, Setup]) -> None:
    found = occupations_of_run(*ran)
    both = theory_and_run(occupations(ran[1]), found)
    assert len(both.pairs) == len(found) == 5
    assert (both.only_theory, both.only_run) == ((), ())
    assert (
        max(abs(p.run.of_part(OccupationPart.THROW) - 6.0) for p in both.pairs if p.run.section_id in "57")
        < 0.01
    )
    for pair in both.pairs:
        assert pair.run.length_s == pytest.approx(pair.theory.length_s, abs=1.5)


def test_the_table_keeps_what_was_found(ran: tuple[RunResult, Setup]) -> None:
    found = occupations_of_run(*ran)
    assert read_blocking(blocking_table(found)) == found


@pytest.mark.parametrize(
    ("drill", "waits"),
    [
        ("rtri/03_block_held", {"T3"}),
        ("rtri/09_manager_power", {"T3"}),
        ("rtri/20_route_given_back", {"T1", "T2"}),
        ("rtri/55_unit_dead_for_good", {"T2"}),
    ],
)
def test_what_is_waited_for_is_no_part(drill: str, waits: set[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """A held block, a manager without power, a route set back, a unit that is dead: no section is two trains' at once.

    Switched off, a request counts from when it was first sent, and there are conflicts.
    """
    scenario = load_scenario(str(find_drill(drill)))
    result = run_on_plain(scenario).result
    found = occupations_of_run(result, scenario.setup)
    assert conflicts_of(found) == ()
    assert {one.number for one in found if one.waited_s > 1.0} == waits
    monkeypatch.setattr(module, "COUNTS_WAITING", True)
    assert conflicts_of(occupations_of_run(result, scenario.setup))


@pytest.mark.nightly
def test_theory_names_the_train_that_waits() -> None:
    """On the Isumi line 6D asks for its track before 5D has left it: theory's one conflict, and the run's one wait."""
    scenario = load_scenario("isumi_weekday")
    found = occupations_of_run(run_on_plain(scenario).result, scenario.setup)
    assert {one.number for one in found if one.waited_s > 0.0} == {"6D"}
    assert {c.second.number for c in conflicts_of(occupations(scenario.setup))} == {"6D"}


def test_what_overlaps_is_seen() -> None:
    one = Occupation("s", "K1", "T1", Direction.DOWN, (Slice(OccupationPart.RUN, 0.0, 10.0),), 0.0, 10.0)
    other = replace(one.moved(9.0), stock_id="K2")
    assert [c.overlap_s for c in conflicts_of((one, other))] == [1.0]


@pytest.mark.nightly
@pytest.mark.parametrize("name", shipped_scenarios())
def test_no_shipped_day_has_a_section_twice(name: str) -> None:
    scenario = load_scenario(name)
    assert conflicts_of(occupations_of_run(run_on_plain(scenario).result, scenario.setup)) == ()


@pytest.mark.nightly
@pytest.mark.parametrize("name", shipped_drills())
def test_a_drill_whatever_it_breaks_has_blocking_times(name: str) -> None:
    """Runs cut short, restarts, sections freed by hand: sound occupations, and none of two stocks at once."""
    scenario = load_scenario(str(find_drill(name)))
    found = occupations_of_run(run_on_plain(scenario).result, scenario.setup)
    assert bool(found) is (scenario.setup.line_signals is None)  # by those nobody holds anything
    assert conflicts_of(found) == ()
