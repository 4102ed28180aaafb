"""Plays of who goes and who waits, played by hand: places for one, A to D, and lines between them or off them."""

from typing import Final

import pytest

from plan.dispatching import chances
from plan.dispatching.asked import answer_to
from wayside.order_question import OrderMove, OrderQuestion, OrderTrain

OFF, A, B, C, D, WEST, EAST, OTHER, FAR, AWAY = -1, 0, 1, 2, 3, 10, 11, 12, 13, 14
# When one comes that is overdue by 30 s: 150 (2k + 1) / (15 - 2k)
RESIDUES_S: Final = (10, 35, 68, 117, 193, 330, 650, 1800)
Leg = tuple[int, int, int, int]  # the line, where it ends, how long it runs, when it is due


def train(
    *moves: Leg, at: int = OFF, comes_s: int = 0, ready_s: int = 0, stays_s: int = 0, stood_s: int = 0
) -> OrderTrain:
    """The last move counts."""
    made = list[OrderMove]()
    for line, to, runs_s, due_s in moves:
        end, counts = (to,) * (to >= 0), len(made) + 1 == len(moves)
        made.append(OrderMove((line, *end), end, 0, runs_s, stays_s, due_s, counts))
    return OrderTrain((WEST,) * (comes_s > 0), comes_s, (at,) * (at >= 0), ready_s, tuple(made), stood_s)


ALONE: Final = train((AWAY, OFF, 10, 10))  # in nobody's way: it loses nothing, and held for a minute that
LATE: Final = train((EAST, OFF, 60, 60), stood_s=30)
SLOW: Final = train((WEST, OFF, 1800, 1900), ready_s=600)
FAST: Final = train((WEST, OFF, 60, 60), ready_s=1200)
TO_B, TO_C, FROM_C = (WEST, B, 100, 100), (EAST, C, 100, 100), (FAR, OFF, 100, 200)
# Trains, the first asks; what is lost in the mean if it goes, and if it is held for a minute.
PLAYS: Final = {
    "there at 150": ([ALONE, train((EAST, OFF, 100, 100), comes_s=30, ready_s=20)], (50, 110)),
    "the line is another's until 30": ([train((WEST, OFF, 9, 9)), train(at=A, comes_s=30)], (30, 60)),
    "40 s are lost already, and 100 more": ([train((WEST, OFF, 100, -40))], (140, 200)),
    "B counts nothing": ([train((WEST, B, 100, 0), (EAST, OFF, 100, 200), stays_s=30)], (30, 90)),
    "50 s late, and another early": ([train((WEST, OFF, 100, 50)), train((OTHER, OFF, 50, 100))], (50, 110)),
    "A is free once it is at B, at 100": ([train(TO_B, at=A), train((OTHER, A, 40, 40))], (100, 60 + 160)),
    "it asks, so it is there": ([train((AWAY, OFF, 10, 10), stood_s=600)], (0, 60)),
    "face to face, an hour for each": ([train(TO_B, at=A), train((WEST, A, 9, 9), at=B)], (7200, 7200)),
    # From D to C first, and A, B and C were full in a circle. B is left at 50, A at 150, and then D, at 250.
    "three in a circle": (
        [
            ALONE,
            train(TO_B, FROM_C, at=A, ready_s=50),
            train(TO_C, FROM_C, at=B, ready_s=50),
            train((OTHER, C, 100, 100), (WEST, A, 100, 200), at=D),
        ],
        (150 + 50 + 250, 60 + 150 + 50 + 250),
    ),
    # A is free for the other at 100, and then C for the first at 200.
    "in turns": ([train(TO_B, (EAST, C, 100, 200), at=A), train((OTHER, A, 100, 100), at=C)], (200, 320)),
    # Either has B, C and D to itself for 400 s.
    "no room to pass": (
        [
            train(TO_B, TO_C, (OTHER, D, 100, 0), (FAR, OFF, 100, 400)),
            train((FAR, D, 100, 0), (OTHER, C, 100, 0), (EAST, B, 100, 0), (WEST, OFF, 100, 400)),
        ],
        (400, 400),
    ),
    # At 100 two may go. The second has asked at 50, the third at 20: it goes first, from 100 to 110.
    # While the first is held, the third goes at 20, the second at 50, and the first at 1,050.
    "who asked first": (
        [
            train((WEST, OFF, 100, 100)),
            train((WEST, OFF, 1000, 1000), ready_s=50),
            train((WEST, OFF, 10, 20), ready_s=20),
        ],
        (110 + 90, 1050 + 50 + 10),
    ),
    # A slow one waits from 600 to 1,260 for one and from 3,060 to 3,720 for another, with which all lose 1,820, 1,200
    # and 3,660. It never waits: 500, 2,400, 4,200; not for the second: 1,160, 1,200, 4,860.
    "eleven minutes of waiting, twice": (
        [
            ALONE,
            train((WEST, B, 1800, 1900), (EAST, OFF, 1800, 3700), ready_s=600),
            *(FAST, train((EAST, OFF, 60, 60), ready_s=3660)),
        ],
        (6680, 6740),
    ),
    # Who is held asks again 5 s after the other has come at 10 or 35, and else after a minute.
    "one is overdue": ([ALONE, LATE], (sum(RESIDUES_S) // 8, (sum(RESIDUES_S) + 15 + 40 + 6 * 60) // 8)),
    # It pays to wait on the one line (1,160 and 1,200 for 500 and 2,400), and not for who is overdue by 1,500 s on the
    # other: that comes after 108, 374, 736, 1,260, 1,800, and goes at 1,200 at the earliest.
    "who is overdue is not waited for, another is": (
        [ALONE, SLOW, FAST, train((EAST, OFF, 1200, 1201)), train((EAST, OFF, 60, 60), stood_s=1500)],
        (2360 + (3 * 1200 + 1260 + 4 * 1800) // 8, 2420 + (3 * 1200 + 1260 + 4 * 1800) // 8),
    ),
}


def lost_s(*trains: OrderTrain) -> tuple[tuple[int, ...], int, int | None]:
    """Who goes, up to the one that asks; what is lost, and what if it were done otherwise."""
    answer = answer_to(OrderQuestion(trains, (), 7200, 1.0, asks=0))
    return answer.order, answer.delay_s, answer.otherwise_s


@pytest.mark.parametrize("name", PLAYS)
def test_a_play_loses_what_it_does_on_paper(name: str) -> None:
    trains, means_s = PLAYS[name]
    assert lost_s(*trains) == ((0,), *means_s)


@pytest.mark.parametrize(("ready_s", "found"), [(504, ((1, 0), 1058, 1000)), (505, ((0,), 1000, 1060))])
def test_it_goes_out_of_turn_to_save_a_minute(ready_s: int, found: object) -> None:
    """The other is fast, first by the plan and ready after r: 1,000 are lost by going, r and r + 50 by waiting."""
    assert lost_s(train((WEST, OFF, 1000, 1010)), train((WEST, OFF, 60, 60), ready_s=ready_s)) == found


def test_who_is_overdue_is_waited_for_while_that_pays_in_the_mean() -> None:
    """To wait costs r and r + 50 up to 650 s; then the slow one goes at 960. If it goes now, the other at 1,200."""
    waits_s, goes_s = 2 * sum(RESIDUES_S[:-1]) + 7 * 50 + 950 + 2160, 7 * 1200 + 1800
    found = lost_s(train((WEST, OFF, 1200, 1210)), train((WEST, OFF, 60, 60), stood_s=30))
    assert found == ((1, 0), waits_s // 8, goes_s // 8)


def test_where_it_is_much_work_the_middle_way_alone_is_played(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chances, "WORK_MAX", -1)
    assert lost_s(ALONE, LATE) == ((0,), 117, 117 + 60)


def test_who_is_overdue_does_not_come_with_the_other_each_time() -> None:
    """In all of eight ways two would want one line together, for 9 s. They come all of these times, one by one."""
    late = train((EAST, OFF, 9, 9), stood_s=30)
    assert 2 * sum(RESIDUES_S) // 8 <= lost_s(ALONE, late, late)[1] < 2 * sum(RESIDUES_S) // 8 + 8
