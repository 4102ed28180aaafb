"""The machine of line signals: what it lets, what its detectors hold, and what it does not see."""

from collections import deque
from typing import Final

import pytest

from simulation.line_signals.machine import Aspect, Contact, SignalMachine, SignalsState
from simulation.line_signals_settings import LineSignals, SignalDeed

Told = tuple[SignalDeed | Contact, str, str]


def pulled(name: str) -> Told:
    return SignalDeed.SET, name, ""


def passed(name: str, unit: str) -> Told:
    return Contact.PASSED, name, unit


FIRST: Final[Told] = (SignalDeed.LEVER, "down-first", "")
RELEASED: Final[Told] = (SignalDeed.RELEASE_LEVER, "down-first", "")
OUT: Final[Told] = (Contact.COUNTED_OUT, "O-S", "A")
LOOP: Final = {
    "signal": [
        {"id": "12R", "at": "O.1", "runs": "down", "block": "O-S"},
        {"id": "22L", "at": "S.1", "runs": "up", "block": "O-S"},
        {"id": "inner", "at": "HALT", "runs": "down", "block": "O-S"},
    ],
    "lever": [{"id": "down-first", "runs": "down", "blocks": ["O-S"]}],
    "detector": [{"signal": "22L", "holds": ["12R"]}],
}
EVENTS: Final[tuple[Told, ...]] = (
    pulled("12R"),
    pulled("22L"),
    FIRST,
    RELEASED,
    passed("12R", "A"),
    passed("22L", "B"),
    OUT,
    (Contact.COUNTED_OUT, "O-S", "B"),
)


def machine(**changed: object) -> SignalMachine:
    return SignalMachine(LineSignals.model_validate(LOOP | changed))


def after(own: SignalMachine, *events: Told) -> SignalsState:
    state = SignalsState()
    for event in events:
        state = own.after(state, *event)
    return state


def shown(own: SignalMachine, *events: Told) -> dict[str, Aspect]:
    state = after(own, *events)
    return {signal_id: own.aspect(state, signal_id) for signal_id in ("12R", "22L")}


def key(state: SignalsState) -> tuple[object, ...]:
    counted = tuple(sorted((s, u) for s, u in state.counted.items() if u))
    directions = tuple(sorted(state.directions.items()))
    return state.wanted, state.levers, directions, counted, state.held


def test_in_no_state_are_both_ends_clear_nor_one_while_a_train_counted_in_comes_from_the_other() -> None:
    own, first = machine(), SignalsState()
    seen, queue = {key(first)}, deque([first])
    while queue:
        state = queue.popleft()
        clear = {s for s in ("12R", "22L") if own.aspect(state, s) is Aspect.CLEAR}
        assert len(clear) < 2
        assert not (clear and state.counted.get("22L" if "12R" in clear else "12R"))
        for event in EVENTS:
            following = own.after(state, *event)
            if key(following) not in seen:
                seen.add(key(following))
                queue.append(following)
    assert len(seen) > 50


def test_a_signal_clears_when_its_lever_is_pulled_and_falls_back_behind_the_train() -> None:
    own = machine()
    assert shown(own)["12R"] is Aspect.STOP
    assert shown(own, pulled("12R"))["12R"] is Aspect.CLEAR
    assert shown(own, pulled("12R"), passed("12R", "A"))["12R"] is Aspect.STOP
    assert shown(own, pulled("12R"), passed("12R", "A"), pulled("12R"))["12R"] is Aspect.STOP


def test_who_was_pulled_first_goes_first_and_the_other_once_the_train_is_counted_out() -> None:
    own = machine()
    events = (pulled("12R"), pulled("22L"), passed("12R", "A"))
    assert shown(own, *events) == {"12R": Aspect.STOP, "22L": Aspect.STOP}
    assert shown(own, *events, OUT)["22L"] is Aspect.CLEAR


def test_a_direction_lever_keeps_the_other_end_at_stop() -> None:
    own = machine()
    assert shown(own, FIRST, pulled("22L"))["22L"] is Aspect.STOP
    assert shown(own, FIRST, pulled("22L"), pulled("12R"))["12R"] is Aspect.CLEAR
    released = (FIRST, pulled("22L"), RELEASED)
    assert shown(own, *released)["22L"] is Aspect.CLEAR


@pytest.mark.parametrize(("works", "shows"), [(True, Aspect.STOP), (False, Aspect.CLEAR)])
def test_a_detector_puts_the_other_end_to_stop_if_it_works(works: bool, shows: Aspect) -> None:
    own = machine(detector=[{"signal": "22L", "holds": ["12R"], "works": works}])
    assert shown(own, pulled("12R"), passed("22L", "B"))["12R"] is shows
    assert shown(own, passed("22L", "B"), pulled("12R"))["12R"] is shows


def test_a_train_that_leaves_at_stop_is_not_counted_in() -> None:
    own = machine(detector=[])
    assert after(own, passed("22L", "B")).counted == {}
    assert shown(own, passed("22L", "B"), pulled("12R"))["12R"] is Aspect.CLEAR


def test_the_substitute_aspect_is_not_checked_and_goes_out_behind_the_train() -> None:
    own = machine()
    against = (pulled("22L"), (SignalDeed.SUBSTITUTE, "12R", ""))
    assert shown(own, *against) == {"12R": Aspect.SUBSTITUTE, "22L": Aspect.CLEAR}
    assert shown(own, *against, passed("12R", "A"))["12R"] is Aspect.STOP


def test_a_train_further_on_in_a_section_is_counted_where_it_passed_last() -> None:
    own = machine()
    state = after(own, pulled("12R"), passed("12R", "A"), pulled("inner"), passed("inner", "A"))
    assert state.counted == {"12R": (), "inner": ("A",)}
