"""The certificate: it refuses exactly the grants after which not all could finish; without it some lines are lost."""

import random
from collections.abc import Sequence

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from msgspec.structs import replace

from radio.messages import RefusalReason, RouteGranted, RouteRefused, SignOnRefused
from tests.wayside.loop_line import Play, can_finish, config_of, random_case
from wayside.certificate import CertificateProof, finishing_order, follows
from wayside.journeys import LastCertificate
from wayside.moves import Move, Train
from wayside.said import Certified, Granted, HeldBack, NoOrderKnown

# One siding, S: two from the west are to use either track of it, one from the east the second (SUMO, report 17834).
ONE_SIDING = ([2, 1, 2, 1, 2], [["0.1", "1.1", "2.1", "3.1", "4.1"], ["0.2", "1.1", "2.2", "3.1", "4.2"]])
NIGHT_S = 36_000.0
FROM_EAST = ["4.2", "3.1", "2.2", "1.1", "0.1"]


def play_of(seed: int, *, certificate: bool) -> Play:
    """A random line and its trains, from which all can finish."""
    tracks, ways = random_case(random.Random(seed))
    return Play(config_of(tracks, ways, certificate=certificate), ways)


def run_through(play: Play, chance: random.Random, *, watched: bool) -> bool:
    """Stocks ask in random order until all have finished, or none is let on any more; whether all have."""
    while not all(map(play.done, range(len(play.ways)))):
        going = [k for k in range(len(play.ways)) if not play.done(k)]
        chance.shuffle(going)
        if not any(asked(play, k, watched=watched) for k in going):
            return False
    return True


def asked(play: Play, k: int, *, watched: bool) -> bool:
    """One stock asks; whether it was let on. What the certificate says is held against the exhaustive search."""
    place, outside = play.at[k], play.outside[k]
    answer = play.asks(k)
    if not isinstance(answer, RouteRefused | SignOnRefused):
        assert not watched or play.finishes(), "a grant after which not all can finish"
        return True
    if watched and answer.reason is RefusalReason.NO_WAY_ON:
        at = [p + (j == k and not outside) for j, p in enumerate(play.at)]
        out = [o and j != k for j, o in enumerate(play.outside)]
        assert (play.at[k], play.outside[k]) == (place, outside)
        assert not can_finish(play.ways, at, out), "a refusal although all could finish"
    return False


@given(st.integers(0, 10**6), st.integers(0, 10**6))
def test_the_certificate_refuses_what_loses_the_line_and_nothing_else(seed: int, order: int) -> None:
    play = play_of(seed, certificate=True)
    assume(play.finishes())
    assert run_through(play, random.Random(order), watched=True)
    assert not any(isinstance(note, NoOrderKnown) for note in play.notes)


def test_without_the_certificate_lines_are_lost() -> None:
    lost = 0
    for seed in range(300):
        play = play_of(seed, certificate=False)
        lost += play.finishes() and not run_through(play, random.Random(seed), watched=False)
    assert lost > 0


@given(st.data())
def test_the_search_finds_an_order_exactly_where_there_is_one(data: st.DataObject) -> None:
    tracks = data.draw(st.integers(2, 6))
    bits = st.integers(0, tracks - 1).map(lambda bit: 1 << bit)
    starts = data.draw(st.lists(st.integers(0, tracks - 1), unique=True, max_size=min(5, tracks)))
    ends = st.one_of(st.just(0), bits)

    def move(end: int, via: bool, due_s: float) -> Move:
        return Move(end | via << tracks, end, due_s)

    moves = st.builds(move, ends, st.booleans(), st.floats(0, 9))
    trains = [Train(1 << bit, tuple(data.draw(st.lists(moves, max_size=4)))) for bit in starts]
    found = finishing_order(trains)
    assert found.proof is not CertificateProof.UNKNOWN
    assert (found.proof is CertificateProof.ORDER) is _exists(trains, (0,) * len(trains), {})
    if found.proof is CertificateProof.ORDER:
        assert follows(trains, found.order)
        assert [found.order.count(k) for k in range(len(trains))] == [len(train.ahead) for train in trains]
    else:
        assert len(set(found.circle)) > 1


@given(st.data())
def test_the_search_finds_a_choice_of_tracks_exactly_where_there_is_one(data: st.DataObject) -> None:
    tracks = data.draw(st.integers(2, 5))
    starts = data.draw(st.lists(st.integers(0, tracks - 1), unique=True, min_size=1, max_size=min(4, tracks)))
    ends = st.one_of(st.just(0), st.integers(0, tracks - 1).map(lambda bit: 1 << bit))
    trains: list[Train] = []
    for bit in starts:
        keeps = data.draw(st.lists(ends, min_size=1, max_size=5))
        later = [list(range(place, len(keeps))) for place in range(len(keeps) + 1)]
        chosen = [data.draw(st.lists(st.sampled_from(m), unique=True)) if m else [] for m in later]
        moves = tuple(Move(keep | (k % 2) << tracks, keep) for k, keep in enumerate(keeps))
        trains.append(Train(1 << bit, moves, tuple(map(tuple, chosen))))
    found = finishing_order(trains)
    assert (found.proof is CertificateProof.ORDER) is _chooses(trains, (0,) * len(trains), {})
    if found.proof is CertificateProof.ORDER:
        at = [0] * len(trains)
        for index, move in zip(found.order, found.moves, strict=True):
            assert move in trains[index].choices[at[index]]
            assert not any(trains[index].ahead[move].needs & held for held in _others(trains, at, index))
            at[index] = move + 1
        assert not any(train.choices[place] for train, place in zip(trains, at, strict=True))


def _others(trains: list[Train], at: Sequence[int], index: int) -> list[int]:
    places = zip(trains, at, strict=True)
    return [t.ahead[a - 1].keeps if a else t.holds for k, (t, a) in enumerate(places) if k != index]


def _chooses(trains: list[Train], at: tuple[int, ...], known: dict[tuple[int, ...], bool]) -> bool:
    """Whether all can come to their ends, by looking at all places."""
    if at not in known:
        known[at] = not any(t.choices[a] for t, a in zip(trains, at, strict=True)) or any(
            not any(trains[k].ahead[move].needs & held for held in _others(trains, at, k))
            and _chooses(trains, (*at[:k], move + 1, *at[k + 1 :]), known)
            for k, a in enumerate(at)
            for move in trains[k].choices[a]
        )
    return known[at]


def _exists(trains: list[Train], at: tuple[int, ...], known: dict[tuple[int, ...], bool]) -> bool:
    if at not in known:
        holds = [t.ahead[a - 1].keeps if a else t.holds for t, a in zip(trains, at, strict=True)]
        known[at] = all(a == len(t.ahead) for t, a in zip(trains, at, strict=True)) or any(
            a < len(trains[k].ahead)
            and not any(trains[k].ahead[a].needs & held for j, held in enumerate(holds) if j != k)
            and _exists(trains, (*at[:k], a + 1, *at[k + 1 :]), known)
            for k, a in enumerate(at)
        )
    return known[at]


def test_the_siding_of_report_17834_is_lost_without_and_not_with_it() -> None:
    tracks, ways = ONE_SIDING[0], [*ONE_SIDING[1], FROM_EAST]
    for certificate in (False, True):
        play = Play(config_of(tracks, ways, certificate=certificate), ways)
        for k in (0, 0, 2):  # the first stands in the siding, the third before it, the second asks
            play.asks(k)
        answer = play.asks(1)
        assert isinstance(answer, RouteRefused) is certificate
        assert play.finishes() is certificate
    play = Play(config_of(tracks, ways, certificate=True), ways)
    for k in (0, 0, 2):
        play.asks(k)
    # an order that led on from other places is none from here
    play.register = replace(play.register, kept=LastCertificate((0, 0, 0), (0, 0, 0), (1, 0, 2)))
    answer = play.asks(1)
    assert isinstance(answer, RouteRefused)
    assert (answer.reason, answer.section_id, answer.holder) == (RefusalReason.NO_WAY_ON, "0.1", "u2")
    (held,) = [note for note in play.notes if isinstance(note, HeldBack)]
    assert held.why == "1 at 0.2 waits for 2 to come to 0.1: if it went now, 1 and 2 could not all finish"
    play.asks(1)  # the same again: the journal has it once
    assert sum(isinstance(note, HeldBack) for note in play.notes) == 1


def day_that_fails_late(*, certificate: bool) -> Play:
    """The siding, and far to the east two stocks that are to change places at night, where there is no siding."""
    tracks, ways = [*ONE_SIDING[0], 1, 1], [*ONE_SIDING[1], FROM_EAST, ["5.1", "6.1"], ["6.1", "5.1"]]
    config = config_of(tracks, ways, certificate=certificate)
    *by_day, first, second = config.dispatch.journeys
    night = [
        replace(
            journey,
            moves=tuple(
                replace(m, departs_s=m.departs_s + NIGHT_S, arrives_s=m.arrives_s + NIGHT_S)
                for m in journey.moves
            ),
        )
        for journey in (first, second)
    ]
    dispatch = replace(config.dispatch, journeys=(*by_day, *night))
    return Play(replace(config, dispatch=dispatch), ways)


def test_a_day_that_fails_in_the_end_is_certified_until_then() -> None:
    play = day_that_fails_late(certificate=True)
    for k in (0, 0, 2):
        play.asks(k)
    answer = play.asks(1)
    assert isinstance(answer, RouteRefused)
    assert (answer.reason, answer.holder) == (RefusalReason.NO_WAY_ON, "u2")
    said = [note for note in play.notes if isinstance(note, NoOrderKnown)]
    assert {note.unit_ids for note in said} == {("u3", "u4")}
    assert all(note.why.endswith("of what is planned before 10:01:43 all can be run") for note in said)


@given(st.integers(0, 10**6))
def test_who_runs_by_day_arrives_whatever_fails_at_night(order: int) -> None:
    """In whatever order they ask, at whatever times: the two of the night are refused nothing that is free."""
    play, chance = day_that_fails_late(certificate=True), random.Random(order)
    while not all(map(play.done, range(3))):
        play.now_s += chance.uniform(0.0, 90.0)
        going = [k for k in range(3) if not play.done(k)]
        chance.shuffle(going)
        assert any(asked(play, k, watched=False) for k in going)
    assert any(isinstance(note, Certified) for note in play.notes)


def test_without_the_certificate_that_day_is_lost_before() -> None:
    play = day_that_fails_late(certificate=False)
    for k in (0, 0, 2):
        play.asks(k)
    assert isinstance(play.asks(1), RouteGranted)
    assert not can_finish(play.ways[:3], play.at[:3], play.outside[:3])


def test_a_certificate_names_the_tracks_that_every_train_uses() -> None:
    tracks, ways = ONE_SIDING[0], [ONE_SIDING[1][0], FROM_EAST]
    play = Play(config_of(tracks, ways, certificate=True), ways)
    play.asks(0)
    certified, granted = [note for note in play.notes if isinstance(note, Certified | Granted)]
    assert isinstance(certified, Certified)
    assert isinstance(granted, Granted)
    tracks_of = {u: [m.split()[1] for m in certified.moves if m.split()[0] == u] for u in ("u0", "u1")}
    assert tracks_of == {"u0": ways[0][1:], "u1": ways[1][1:]}
    assert certified.beyond == 0


def test_two_trains_that_cannot_finish_are_found_among_many_that_could_go_on_for_long() -> None:
    """Two that are to pass each other where there is one track, and many others that could go on for long."""
    ends = ((1, 2), (2, 1))
    lost = [Train(here, (Move(4, 4, 50.0), Move(there, there, 60.0))) for here, there in ends]
    others = [
        Train(1 << (8 + k), tuple(Move(1 << (8 + k), 1 << (8 + k), float(n)) for n in range(20)))
        for k in range(10)
    ]
    found = finishing_order([*lost, *others])
    assert (found.proof, found.circle) == (CertificateProof.NONE, (0, 1))
    # the others are not tried in all their orders
    assert found.steps < 2 * sum(len(train.ahead) for train in others)


@pytest.mark.parametrize("held", [0, 1])
def test_a_train_that_ends_where_another_must_pass_goes_last(held: int) -> None:
    """Whatever is due first: a stabled train is in the way for ever."""
    stays = Train(held << 1, (Move(4, 4, 0.0),))
    passes = Train(1, (Move(4, 4, 5.0), Move(8, 8, 6.0)))
    found = finishing_order([stays, passes])
    assert found.proof is CertificateProof.ORDER
    assert found.order[-1] == 0


def test_who_leaves_a_queue_that_it_needs_again_is_in_the_way_of_those_that_stay_in_it() -> None:
    """Two wait before a portal. One may stand on a track that the other goes over, and comes back by the queue."""
    queue, track, far, beyond = 1, 2, 4, 8
    comes_again = Train(queue, (Move(0, track), Move(queue, 0)))
    waits = Train(queue, (Move(track | far, 0),))
    ahead = Train(far, (Move(0, beyond),))
    answer = finishing_order([comes_again, waits, ahead])
    assert answer.proof is CertificateProof.ORDER
    assert answer.order == (2, 1, 0, 0)
