"""Leave to come in, on the run of the RTRI test line: asked for before the points, which are kept until it stands."""

import pytest
from msgspec.structs import replace

from network.model import TagPurpose
from onboard.authority.records import RequestKind, SendCommand, SendRequest
from onboard.duty import entering
from onboard.duty.machine import step
from onboard.duty.records import DutyPhase, Event, Looked, MarkRelation, PointsSeen, Stopped, TagBelieved
from tests.onboard.duty.stage import (
    APPROACH,
    NOW_S,
    ON_6,
    ON_SIGHT,
    P5,
    P7,
    PLAN,
    RUNNING,
    STANDING,
    TIMES,
    moved,
)

LEG = replace(PLAN.legs[0], entry=("7",))
GATED = replace(PLAN, legs=(LEG,))
WITHOUT = replace(RUNNING.authority, commandable=())
ON_8 = moved(ON_6, here=4, sure=5, perhaps=5, clear=4, clear_at_mark=4, reach=5)
ARRIVAL = max(i for i, tag in enumerate(PLAN.tags) if tag.purpose is TagPurpose.ARRIVAL)


def _asked(actions: tuple[object, ...]) -> list[tuple[str, ...] | None]:
    requests = [a.request for a in actions if isinstance(a, SendRequest)]
    return [request.section_ids for request in requests if request.ask is RequestKind.ROUTE]


def test_at_the_approach_tag_it_asks_for_leave_and_commands_nothing_without() -> None:
    state = replace(RUNNING, authority=WITHOUT)
    _, actions = step(GATED, TIMES, state, TagBelieved(APPROACH, found=False), ON_6, NOW_S)
    assert _asked(actions) == [("7", "8")]
    assert not [a for a in actions if isinstance(a, SendCommand)]


def test_with_leave_it_commands_the_points_and_asks_for_nothing() -> None:
    _, actions = step(GATED, TIMES, RUNNING, TagBelieved(APPROACH, found=False), ON_6, NOW_S)
    assert _asked(actions) == []
    assert [a.needed for a in actions if isinstance(a, SendCommand)] == [P7]


@pytest.mark.parametrize(("under", "asked"), [(False, [("7", "8")]), (True, [])])
def test_on_sight_its_crew_passes_no_points_without_leave_but_those_under_the_train(
    under: bool, asked: list[tuple[str, ...]]
) -> None:
    state = replace(ON_SIGHT, authority=WITHOUT)
    after, actions = step(GATED, TIMES, state, PointsSeen(P7, under=under), state.place, NOW_S)
    assert _asked(actions) == asked
    assert (P7 in after.authority.proven) is under


@pytest.mark.parametrize(("on_line", "overlaps"), [(True, True), (True, False), (False, True)])
def test_who_may_not_command_what_it_holds_asks_for_leave_though_it_comes_in_nowhere(
    on_line: bool, overlaps: bool
) -> None:
    """Persons spoke for it meanwhile, so the register knows no more that it had leave to go; who signs on hears it."""
    authority = replace(RUNNING.authority, held=("3", "5", "6", "7", "8"), commandable=(), on_line=on_line)
    state = replace(STANDING, authority=authority, wanted=(P5,))
    _, actions = step(replace(PLAN, overlaps=overlaps), TIMES, state, Looked(), state.place, NOW_S)
    assert _asked(actions) == ([("5", "6", "7", "8")] if on_line and overlaps else [])


def _after_the_tag(event: Event, place: object = ON_8) -> tuple[str, ...]:
    """What it holds after the arrival tag and one more event."""
    state = replace(RUNNING, place=ON_8, entered=frozenset({"5", "7"}))
    state, _ = step(GATED, TIMES, state, TagBelieved(ARRIVAL, found=False), ON_8, NOW_S)
    state, _ = step(GATED, TIMES, state, event, place, NOW_S)  # type: ignore[arg-type]
    return state.authority.held


def test_arrival_points_are_kept_until_it_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _after_the_tag(Looked()) == ("7", "8")
    assert _after_the_tag(Stopped(MarkRelation.AT, 0.0), moved(ON_8, stands=True, near=1)) == ("8",)
    monkeypatch.setattr(entering, "KEEPS", False)
    assert _after_the_tag(Looked()) == ("8",)


def test_who_has_its_way_on_gives_them_back_at_the_tag() -> None:
    """It runs through: its overrun is on its own way."""
    through = replace(GATED, legs=(replace(LEG, entry=("5",), section_ids=("5", "6")),))
    state = replace(RUNNING, phase=DutyPhase.RUNNING)
    assert (
        entering.kept_until_stand(
            through, replace(state, authority=replace(state.authority, held=("5", "6")))
        )
        == 1
    )
    held = replace(state.authority, held=("5", "6", "7"))
    assert entering.kept_until_stand(through, replace(state, authority=held)) == len(PLAN.spans)
