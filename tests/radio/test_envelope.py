"""Each threat of EN 50159 (repetition, deletion, insertion, re-sequencing, corruption, delay, masquerade)."""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radio.envelope import (
    AGE_MAX_S,
    CLOCK_SKEW_MAX_S,
    SEQUENCE_WINDOW,
    TELEGRAM_BYTES_MAX,
    Dropped,
    DropReason,
    Endpoint,
    Envelope,
    Received,
    encode,
)
from radio.keys import MAC_BYTES, KeyRing, key_ring, pair_key
from radio.messages import ClaimQuery, HoldingReport, RouteRequest

MASTER = b"m" * 32
REPORT = HoldingReport(("a",), 7)


def endpoint(owner: str, *peers: str, epoch: int = 1) -> Endpoint:
    return Endpoint(key_ring(MASTER, owner, peers), epoch)


def pair() -> tuple[Endpoint, Endpoint]:
    return endpoint("train", "manager", "terminal"), endpoint("manager", "train", "other")


def reason(result: Received | Dropped) -> DropReason:
    assert isinstance(result, Dropped), result
    return result.reason


def received(result: Received | Dropped) -> Received:
    assert isinstance(result, Received), result
    return result


def test_a_telegram_arrives_as_it_was_sent() -> None:
    train, manager = pair()
    got = received(manager.open(train.seal("manager", REPORT, 1.0, correlation=9), 1.5))
    assert (got.source, got.epoch, got.correlation, got.sent_s, got.message) == ("train", 1, 9, 1.0, REPORT)
    assert not got.fresh
    assert got.round_trip_s is None
    answer = received(train.open(manager.seal("train", ClaimQuery(), 1.75, 9), 2.0))
    assert answer.fresh
    assert answer.round_trip_s == 1.0  # since the train sent at 1.0


def test_repetition() -> None:
    train, manager = pair()
    data = train.seal("manager", REPORT, 0.0)
    received(manager.open(data, 0.1))
    assert reason(manager.open(data, 0.2)) is DropReason.REPEATED
    received(manager.open(train.seal("manager", REPORT, 0.3), 0.3))
    assert reason(manager.open(data, 0.4)) is DropReason.REPEATED
    assert manager.dropped == {DropReason.REPEATED: 2}


def test_deletion_is_counted_and_answered_by_a_request_with_the_same_correlation() -> None:
    train, manager = pair()
    request = RouteRequest("train", "R", ("a",))
    received(manager.open(train.seal("manager", request, 0.0, 4), 0.1))
    train.seal("manager", request, 1.0, 4)  # lost
    again = received(manager.open(train.seal("manager", request, 2.0, 4), 2.1))
    assert (again.correlation, again.message, again.missing, manager.missing) == (4, request, 1, 1)


def test_insertion_from_an_unknown_source_or_for_another() -> None:
    train, manager = pair()
    stranger = endpoint("stranger", "manager")
    assert reason(manager.open(stranger.seal("manager", REPORT, 0.0), 0.0)) is DropReason.UNKNOWN_SOURCE
    assert reason(manager.open(train.seal("terminal", REPORT, 0.0), 0.0)) is DropReason.WRONG_DESTINATION


def test_insertion_of_what_was_meant_for_an_earlier_boot() -> None:
    train, manager = pair()
    received(train.open(manager.seal("train", ClaimQuery(), 0.0), 0.0))
    again = endpoint("manager", "train", epoch=2)
    dropped = again.open(train.seal("manager", REPORT, 0.1), 0.1)
    assert isinstance(dropped, Dropped) and dropped.envelope is not None
    assert (dropped.reason, dropped.envelope.source) == (DropReason.EARLIER_BOOT, "train")
    received(train.open(again.seal("train", ClaimQuery(), 0.2), 0.2))
    assert received(again.open(train.seal("manager", REPORT, 0.3), 0.3)).fresh


def test_resequencing_within_a_boot() -> None:
    train, manager = pair()
    first, second = train.seal("manager", REPORT, 0.0), train.seal("manager", REPORT, 0.0)
    received(manager.open(second, 0.1))
    assert reason(manager.open(first, 0.2)) is DropReason.OUT_OF_ORDER


def test_resequencing_over_a_restart_of_the_source() -> None:
    old, manager = pair()
    late = old.seal("manager", REPORT, 0.0)
    new = endpoint("train", "manager", epoch=2)
    received(manager.open(new.seal("manager", REPORT, 0.1), 0.1))
    assert reason(manager.open(late, 0.2)) is DropReason.OLD_EPOCH


def test_far_behind_the_window_is_out_of_order() -> None:
    train, manager = pair()
    first = train.seal("manager", REPORT, 0.0)
    received(manager.open(first, 0.0))
    later = [train.seal("manager", REPORT, 0.0) for _ in range(SEQUENCE_WINDOW + 1)]
    received(manager.open(later[-1], 0.0))
    assert reason(manager.open(first, 0.0)) is DropReason.OUT_OF_ORDER


@given(bit=st.integers(min_value=0), sections=st.lists(st.text(max_size=8), max_size=4))
def test_corruption_of_any_bit(bit: int, sections: list[str]) -> None:
    train, manager = pair()
    data = bytearray(train.seal("manager", HoldingReport(tuple(sections), 7), 1.0))
    bit %= 8 * len(data)
    data[bit // 8] ^= 1 << bit % 8
    assert isinstance(manager.open(bytes(data), 1.0), Dropped)
    assert manager.peers == {}


@given(st.binary(min_size=MAC_BYTES + 1, max_size=300))  # shorter ones are looked at no further
def test_noise_is_dropped_and_raises_nothing(data: bytes) -> None:
    assert isinstance(pair()[1].open(data, 0.0), Dropped)


@pytest.mark.parametrize("size", [0, 16, TELEGRAM_BYTES_MAX + 1])
def test_sizes_that_no_telegram_has(size: int) -> None:
    assert reason(pair()[1].open(bytes(size), 0.0)) is DropReason.CORRUPTED


def test_delay_beyond_the_age_limit() -> None:
    train, manager = pair()
    data = train.seal("manager", REPORT, 10.0)
    assert reason(manager.open(data, 15.1)) is DropReason.STALE
    received(manager.open(data, 15.0))


@pytest.mark.parametrize("sent_s", [10.0 + CLOCK_SKEW_MAX_S + 0.01, math.inf, math.nan])
def test_time_that_cannot_be(sent_s: float) -> None:
    train, manager = pair()
    data = train.seal("manager", REPORT, sent_s)
    assert reason(manager.open(data, 10.0)) is DropReason.IMPLAUSIBLE_TIME
    assert manager.peers == {}


@pytest.mark.parametrize("ahead_s", [-AGE_MAX_S, -CLOCK_SKEW_MAX_S, CLOCK_SKEW_MAX_S])
def test_clocks_that_differ_by_no_more_than_they_may_hear_each_other(ahead_s: float) -> None:
    train, manager = pair()
    received(manager.open(train.seal("manager", REPORT, 10.0 + ahead_s), 10.0))


def test_the_age_limit_moves_by_no_more_than_the_clocks_may_differ() -> None:
    train, manager = pair()
    data = train.seal("manager", REPORT, 10.0 + CLOCK_SKEW_MAX_S)
    assert reason(manager.open(data, 10.0 + CLOCK_SKEW_MAX_S + AGE_MAX_S + 0.01)) is DropReason.STALE


def test_two_whose_clocks_both_were_ahead_hear_each_other_when_they_are_set_right() -> None:
    train, manager = pair()
    received(manager.open(train.seal("manager", REPORT, 110.0), 110.1))
    received(train.open(manager.seal("train", ClaimQuery(), 110.2), 110.3))
    again = received(manager.open(train.seal("manager", REPORT, 11.0), 11.1))
    assert again.round_trip_s is None  # by a clock that was set since nothing is measured
    received(train.open(manager.seal("train", ClaimQuery(), 11.2), 11.3))


def test_masquerade_with_the_keys_of_another_party() -> None:
    _, manager = pair()
    stolen = key_ring(MASTER, "other", ["manager"])
    impostor = Endpoint(KeyRing("train", stolen.pairs, {}), 1)
    assert reason(manager.open(impostor.seal("manager", REPORT, 0.0), 0.0)) is DropReason.CORRUPTED


def test_reflection_of_ones_own_telegram() -> None:
    train, _ = pair()
    assert reason(train.open(train.seal("manager", REPORT, 0.0), 0.0)) is DropReason.WRONG_DESTINATION


def test_an_authentic_header_around_an_unknown_message_is_dropped() -> None:
    _, manager = pair()
    payload = msgspec.Raw(msgspec.msgpack.encode([99, "x"]))
    envelope = Envelope("train", "manager", 1, 0, 0, 0.0, None, 0, payload)
    data = encode(pair_key(MASTER, "train", "manager"), envelope)
    assert reason(manager.open(data, 0.0)) is DropReason.CORRUPTED
    assert manager.peers == {}


def test_an_epoch_below_one_would_mean_never_heard() -> None:
    with pytest.raises(ValueError, match="expected 1 or more"):
        endpoint("train", epoch=0)


@given(st.lists(st.integers(0, 80), max_size=120))
def test_each_telegram_takes_effect_at_most_once_and_in_order(order: list[int]) -> None:
    train, manager = pair()
    sent = [train.seal("manager", HoldingReport((), number), 0.0) for number in range(81)]
    tokens = []
    for index in order:
        result = manager.open(sent[index], 0.0)
        if isinstance(result, Received) and isinstance(result.message, HoldingReport):
            tokens.append(result.message.token)
    assert tokens == sorted(set(tokens))
