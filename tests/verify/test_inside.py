"""Runs are inside what was explored, and deliberate defects are not."""

import pytest

from onboard.duty.records import DutyPhase
from scenario.part_of_day import part_of_day
from tests.system import switches_on_board, switches_radio, switches_wayside  # noqa: F401 - they enter themselves
from tests.system.switchboard import FOLDER, SWITCHES
from verify.evidence.inside import InsideFigures
from verify.evidence.inside_runs import (
    LINES,
    OTHER,
    RECOVERS,
    broken_in,
    by_lack,
    explored_views,
    is_by_authority,
    lacking,
    load,
    runs_named,
    watched_run,
)
from verify.explored_line import Budgets, ExploredLine
from verify.pair_view import Believed, GroundView, OthersView, OwnView, PairView, ViewedKind
from wayside.register import UnitStanding

BEYOND_SHARE_MAX = 0.05  # of the events of a day
OTHER_SHARE_MAX = 0.002  # of the states of all drills: release by section, persons who are wrong


@pytest.fixture(scope="module")
def calm_views() -> frozenset[PairView]:
    """Of lines on which telegrams are lost, or points are detected no more."""
    lines = (ExploredLine(budgets=Budgets(loss=1), timed=True), ExploredLine(budgets=Budgets(points=1)))
    return explored_views(lines, lambda _: None)


@pytest.fixture(scope="module")
def late_views(calm_views: frozenset[PairView]) -> frozenset[PairView]:
    """With those of a line on which they are late too, which takes ten seconds."""
    return calm_views | explored_views(
        (ExploredLine(budgets=Budgets(loss=1, delay=1), timed=True),), lambda _: None
    )


# What is done wrong, where, and what is given besides.
DEFECTS = (
    ("grants_what_another_holds", "two_trains", ""),
    ("silence_frees", "two_trains", ""),
    ("runs_beyond_what_it_holds", "two_trains", ""),
    ("believes_any_code", "two_trains", "forges_a_report"),
)


def _figures(views: frozenset[PairView], *names: str) -> InsideFigures:
    figures = InsideFigures()
    for scenario in filter(is_by_authority, map(load, names)):
        watched_run(scenario, views, figures)
    return figures


def test_the_first_hours_of_a_day_lie_inside(calm_views: frozenset[PairView]) -> None:
    figures = InsideFigures()
    watched_run(part_of_day(load("karasuyama_weekday"), None, "07:30"), calm_views, figures)
    assert figures.states > 1000
    lies_inside(figures)


@pytest.mark.nightly
def test_a_day_lies_inside(late_views: frozenset[PairView]) -> None:
    figures = InsideFigures()
    result = watched_run(load("karasuyama_weekday"), late_views, figures)
    assert figures.states > 10_000
    lies_inside(figures)
    assert result.digest.startswith("a5b43903")


def lies_inside(figures: InsideFigures) -> None:
    assert figures.beyond <= BEYOND_SHARE_MAX * figures.events
    assert by_lack(figures)[OTHER] == 0, figures.first


@pytest.mark.parametrize(
    ("standing", "others", "lack"),
    [
        (UnitStanding.REPORTED, UnitStanding.REPORTED, OTHER),
        (UnitStanding.OUTSIDE, None, OTHER),
        (UnitStanding.LEAVING, UnitStanding.REPORTED, OTHER),
        (UnitStanding.REPORTED, UnitStanding.OUTSIDE, OTHER),
        (UnitStanding.UNKNOWN, None, RECOVERS),
        (UnitStanding.REPORTED, UnitStanding.BY_HAND, RECOVERS),
        (UnitStanding.DISPUTED, UnitStanding.DISPUTED, RECOVERS),
    ],
)
def test_only_what_troubles_lead_to_is_excused_by_them(
    standing: UnitStanding, others: UnitStanding | None, lack: str
) -> None:
    """A train that runs in a section which the register, whole, has as free: it was said to be outside."""
    runs = OwnView(DutyPhase.RUNNING, Believed.IN, holds=True)
    ground = GroundView(True, standing, others)
    assert lacking(PairView(ViewedKind.PLAIN, runs, OthersView(within=False), ground)) == lack
    undefined = ground._replace(defined=False)
    assert lacking(PairView(ViewedKind.PLAIN, runs, OthersView(within=False), undefined)) == RECOVERS


def test_two_trains_that_meet_lie_inside(calm_views: frozenset[PairView]) -> None:
    assert by_lack(_figures(calm_views, str(FOLDER / "two_trains.toml")))[OTHER] == 0


@pytest.mark.parametrize(("off", "scenario", "given"), DEFECTS)
def test_a_defect_falls_outside(
    calm_views: frozenset[PairView], off: str, scenario: str, given: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in filter(None, (off, given)):
        SWITCHES[name](monkeypatch)
    assert by_lack(_figures(calm_views, str(FOLDER / f"{scenario}.toml")))[OTHER] > 0


def test_a_run_that_breaks_a_rule_is_not_good_whatever_lies_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    """Persons who are wrong may break one where their drill says so and judges it: of that nothing is said here."""
    wrong, meets = load("rtri/53b_two_wrong_persons"), load(str(FOLDER / "two_trains.toml"))
    result = watched_run(wrong, frozenset(), InsideFigures())
    assert result.violations and not broken_in(wrong, result)
    assert not broken_in(meets, watched_run(meets, frozenset(), InsideFigures()))
    SWITCHES["grants_what_another_holds"](monkeypatch)
    assert broken_in(meets, watched_run(meets, frozenset(), InsideFigures()))


def test_most_of_what_could_be_said_of_two_units_is_no_view(calm_views: frozenset[PairView]) -> None:
    """The set says something: nowhere do both hold a section, but where one has left and is still to be told so by its
    driver; and none is in what it does not hold.
    """
    defined = [view for view in calm_views if view.ground.defined]
    both = [view.ground for view in defined if view.own.holds and view.other.holds]
    gone = {UnitStanding.OUTSIDE, UnitStanding.LEAVING}
    assert all(gone & {ground.standing, ground.others_standing} for ground in both)
    assert not any(view.own.believed is Believed.IN and not view.own.holds for view in defined)


@pytest.mark.nightly
def test_every_drill_and_shipped_day(late_views: frozenset[PairView]) -> None:
    views = explored_views(LINES, lambda _: None) | late_views
    figures = _figures(views, *runs_named(("rtri", "karasuyama", "sidings")))
    assert figures.states >= 1_000_000
    assert by_lack(figures)[OTHER] <= OTHER_SHARE_MAX * figures.states, figures.first
