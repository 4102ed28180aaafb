"""The air's statistics against its parameters; tolerances are five standard deviations of the estimate."""

import math
from typing import Any

import pytest

from network.errors import InputError
from network.files.toml_input import validate
from radio.air import Air, AirEvent, AirParameters, DelayShape, Delivery, combined, on_average

N = 20_000


def sigma5(p: float, n: int = N) -> float:
    return 5 * math.sqrt(p * (1 - p) / n)


def send(air: Air, count: int = N, every: int = 1, data: bytes = b"x" * 40) -> list[tuple[Delivery, ...]]:
    return [air.transmit(step * every, "a", "b", data, True) for step in range(count)]


def test_the_default_air_delivers_everything_one_step_later() -> None:
    assert send(Air(AirParameters(), 1), 5) == [(Delivery(step + 1, b"x" * 40),) for step in range(5)]


def test_what_is_sent_before_midnight_arrives_before_midnight() -> None:
    assert Air(AirParameters(), 1).transmit(-4800, "a", "b", b"x", True) == (Delivery(-4799, b"x"),)


def test_no_coverage_no_delivery_and_no_draw() -> None:
    parameters = AirParameters(delay_mean_s=1.0)
    one, other = Air(parameters, 1), Air(parameters, 1)
    assert one.transmit(0, "a", "b", b"x", False) == ()
    assert send(one, 50) == send(other, 50)
    assert one.counts[AirEvent.UNCOVERED] == 1


@pytest.mark.parametrize(("delay_s", "steps"), [(0.1, 1), (0.3, 3), (0.31, 4), (2.0, 20)])
def test_delay_is_rounded_up_to_steps(delay_s: float, steps: int) -> None:
    parameters = AirParameters(delay_min_s=delay_s, delay_mean_s=delay_s, delay_shape=DelayShape.CONSTANT)
    assert send(Air(parameters, 1), 3) == [(Delivery(step + steps, b"x" * 40),) for step in range(3)]


def test_exponential_delay_has_the_mean_asked_for() -> None:
    air = Air(AirParameters(delay_min_s=0.2, delay_mean_s=0.7), 3)
    # Far apart, so that keeping the order never holds one back.
    delays_s = [(out[0].step - step * 1000) * 0.1 for step, out in enumerate(send(air, every=1000))]
    assert min(delays_s) >= 0.2
    # Rounding a smooth distribution up adds half a step on average (error below 1 ms at this step and tail).
    assert sum(delays_s) / N == pytest.approx(0.75, abs=5 * 0.5 / math.sqrt(N) + 1e-3)


def test_a_link_keeps_order_unless_reordering_is_asked_for() -> None:
    steps = [out[0].step for out in send(Air(AirParameters(delay_mean_s=1.0), 5), 2000)]
    assert steps == sorted(steps)
    air = Air(AirParameters(reorder_p=0.1, reorder_delay_s=1.0), 5)
    steps = [out[0].step - step for step, out in enumerate(send(air))]
    assert set(steps) == {1, 11}
    assert steps.count(11) / N == pytest.approx(0.1, abs=sigma5(0.1))
    assert air.counts[AirEvent.REORDERED] == steps.count(11)


def test_duplicates() -> None:
    air = Air(AirParameters(duplicate_p=0.05), 6)
    copies = [out for out in send(air) if len(out) == 2]
    assert len(copies) / N == pytest.approx(0.05, abs=sigma5(0.05))
    assert all(second.step > first.step and second.data == first.data for first, second in copies)
    assert air.counts[AirEvent.DUPLICATED] == len(copies)


def test_bit_errors() -> None:
    air = Air(AirParameters(flip_p=1e-3), 7)
    outs = send(air, data=bytes(40))
    flipped = sum(out[0].data != bytes(40) for out in outs)
    expected = 1 - (1 - 1e-3) ** 320
    assert flipped / N == pytest.approx(expected, abs=sigma5(expected))
    assert air.counts[AirEvent.FLIPPED] == flipped
    pairs = send(Air(AirParameters(flip_p=1e-3, duplicate_p=1.0), 7), data=bytes(40))
    both = sum(all(copy.data != bytes(40) for copy in pair) for pair in pairs)  # each on its own
    assert both / N == pytest.approx(expected**2, abs=sigma5(expected**2))
    bits = sum(byte.bit_count() for out in outs for byte in out[0].data)
    assert bits / (320 * N) == pytest.approx(1e-3, abs=sigma5(1e-3, 320 * N))


def test_loss_share_and_burst_length_follow_gilbert_and_elliott() -> None:
    parameters = AirParameters(good_to_bad_per_s=0.1, bad_to_good_per_s=0.4, loss_good_p=0.0, loss_bad_p=1.0)
    assert parameters.bad_share == pytest.approx(0.2)
    lost = [not out for out in send(Air(parameters, 8), 10 * N)]
    # Neighbouring telegrams are alike for about 1/(a+b) = 2 s = 20 steps, so fewer of them count.
    assert sum(lost) / len(lost) == pytest.approx(0.2, abs=sigma5(0.2, len(lost) // 40))
    bursts = sum(now and not before for before, now in zip([False, *lost], lost, strict=False))
    # A bad spell seen at every step lasts 1 / P(bad -> good in one step) steps.
    leave_p = (1 - 0.2) * (1 - math.exp(-0.5 * 0.1))
    assert sum(lost) / bursts == pytest.approx(1 / leave_p, rel=5 / math.sqrt(bursts))


def test_long_pauses_forget_the_state_of_the_link() -> None:
    parameters = AirParameters(good_to_bad_per_s=0.1, bad_to_good_per_s=0.4, loss_bad_p=0.5, loss_good_p=0.1)
    assert parameters.loss_p == pytest.approx(0.18)
    lost = sum(not out for out in send(Air(parameters, 9), every=1000))
    assert lost / N == pytest.approx(0.18, abs=sigma5(0.18))


def test_links_do_not_disturb_each_other() -> None:
    parameters = AirParameters(delay_mean_s=1.0, loss_good_p=0.3, duplicate_p=0.2)
    alone, shared = Air(parameters, 4), Air(parameters, 4)
    expected = send(alone, 200)
    found = []
    for step in range(200):
        shared.transmit(step, "b", "a", b"y", True)
        found.append(shared.transmit(step, "a", "b", b"x" * 40, True))
    assert found == expected


def test_steps_must_not_go_back() -> None:
    air = Air(AirParameters(), 1)
    air.transmit(5, "a", "b", b"x", True)
    with pytest.raises(ValueError, match="before step 5"):
        air.transmit(4, "a", "b", b"x", True)


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        ({"flip_p": 0.6}, "flip_p"),
        ({"loss_good_p": 1.0}, "loss_good_p"),
        ({"good_to_bad_per_s": 0.1, "bad_to_good_per_s": 0.0}, "bad_to_good_per_s"),
        ({"loss_bad_p": -0.1}, "loss_bad_p"),
        ({"duplicate_p": math.nan}, "duplicate_p"),
        ({"delay_min_s": -1.0}, "delay_min_s"),
        ({"delay_min_s": 0.5, "delay_mean_s": 0.4}, "delay_mean_s"),
        ({"bad_to_good_per_s": math.inf}, "bad_to_good_per_s"),
    ],
)
def test_parameters_that_cannot_be(wrong: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as refused:
        validate(wrong, "s.toml", AirParameters)
    assert refused.value.key == key


def both(first: AirParameters, second: AirParameters, seed: int = 1) -> list[tuple[Delivery, ...]]:
    """Telegrams far apart, over two networks at once."""
    one, other = Air(first, seed), Air(second, seed, stream="other")
    data = b"x" * 40
    return [
        combined(*(air.transmit(at, "a", "b", data, True) for air in (one, other)), data)
        for at in range(0, 1000 * N, 1000)
    ]


def test_two_networks_lose_what_both_lose() -> None:
    lost = sum(not out for out in both(AirParameters(loss_good_p=0.3), AirParameters(loss_good_p=0.2))) / N
    assert lost == pytest.approx(0.06, abs=sigma5(0.06))
    assert on_average(AirParameters(loss_good_p=0.3), AirParameters(loss_good_p=0.2)).loss_p == pytest.approx(
        0.06
    )


def test_of_two_networks_the_sooner_counts() -> None:
    """Two exponential tails of mean t end, whichever comes first, after t / 2; rounding up adds half a step."""
    slow = AirParameters(delay_min_s=0.2, delay_mean_s=4.2)
    delays_s = [(out[0].step - at * 1000) * 0.1 for at, out in enumerate(both(slow, slow))]
    assert {len(out) for out in both(slow, slow, 2)[:50]} == {1}
    assert sum(delays_s) / N == pytest.approx(0.2 + 2.0 + 0.05, abs=5 * 2.0 / math.sqrt(N) + 1e-3)
    assert on_average(slow, slow).delay_s == pytest.approx(2.25, abs=1e-3)


def test_of_two_networks_one_that_loses_all_changes_nothing() -> None:
    slow = AirParameters(delay_mean_s=2.0)
    dead = AirParameters().model_copy(update={"loss_good_p": 1.0})
    assert on_average(slow, dead) == pytest.approx(on_average(slow, None))

    alone = Air(slow, 1)
    assert [out[0].step for out in both(slow, dead)[:50]] == [
        alone.transmit(at * 1000, "a", "b", b"x" * 40, True)[0].step for at in range(50)
    ]


def test_of_two_networks_a_damaged_copy_does_not_stand_in_for_a_whole_one() -> None:
    soon, late = Delivery(3, b"damaged"), Delivery(9, b"whole")
    assert combined((soon,), (late,), b"whole") == (late,)
    assert combined((late,), (soon,), b"damaged") == (soon,)
    assert combined((late,), (soon,), b"neither") == (soon, late)
    twice = (Delivery(2, b"whole"), Delivery(4, b"whole"))
    assert combined((late,), twice, b"whole") == twice
