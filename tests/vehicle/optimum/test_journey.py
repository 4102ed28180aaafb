"""Times of a journey: least energy within all windows, its prices, its bound, and what cannot be kept."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from vehicle.optimum.journey import (
    JourneyStop,
    ProvenHop,
    TimedJourney,
    TimeWindow,
    WindowMissed,
    earliest_times,
    journey_bound_j,
    journey_times,
)
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of, proportional_curve


def analytic(
    least_s: float, scale_j: float, stretches: Sequence[float] = (1.0, 1.05, 1.1, 1.2, 1.4, 1.8, 2.5)
) -> HopCurve:
    """E(T) = scale least / T + scale: exact energies, prices and bounds at a few running times."""
    return curve_of(
        ParetoPoint(
            least_s * r, scale_j * (1.0 + 1.0 / r), scale_j / (least_s * r * r), scale_j * (1.0 + 1.0 / r)
        )
        for r in stretches
    )


hops_of = st.lists(
    st.tuples(st.floats(60.0, 600.0), st.floats(1e6, 1e8)).map(lambda given: analytic(*given)),
    min_size=1,
    max_size=5,
)


@st.composite
def journeys(draw: st.DrawFn) -> tuple[list[HopCurve], list[JourneyStop]]:
    hops = draw(hops_of)
    at_s = 1000.0
    stops = [JourneyStop("0", departure=TimeWindow(at_s, at_s + draw(st.floats(0.0, 60.0))))]
    for number, hop in enumerate(hops, 1):
        at_s += hop.least_s * draw(st.floats(1.0, 1.6))
        dwell_s = draw(st.floats(0.0, 40.0))
        arrival = (
            TimeWindow(at_s - draw(st.floats(0.0, 100.0)), at_s + draw(st.floats(0.0, 100.0)))
            if draw(st.booleans())
            else TimeWindow()
        )
        at_s += dwell_s
        stands = draw(st.booleans())
        if not stands:
            at_s -= dwell_s
        departure = (
            TimeWindow(at_s, at_s + draw(st.floats(0.0, 100.0))) if draw(st.booleans()) else TimeWindow()
        )
        stops.append(JourneyStop(str(number), arrival, departure, dwell_s, stands or number == len(hops)))
    latest_s = min(stops[-1].arrival.latest_s, at_s + 100.0)
    stops[-1] = JourneyStop(stops[-1].name, TimeWindow(stops[-1].arrival.earliest_s, latest_s))
    return hops, stops


def energy_j(hops: Sequence[HopCurve], running_s: Sequence[float]) -> float:
    return sum(hop.energy_j(time_s) for hop, time_s in zip(hops, running_s, strict=True))


def broken_by_s(stops: Sequence[JourneyStop], journey: TimedJourney) -> float:
    """By how much the worst window or dwell is missed."""
    worst = 0.0
    for stop, times in zip(stops, journey.stops, strict=True):
        for time_s, window in ((times.arrival_s, stop.arrival), (times.departure_s, stop.departure)):
            if time_s is not None:
                worst = max(worst, window.earliest_s - time_s, time_s - window.latest_s)
        if times.arrival_s is not None and times.departure_s is not None:
            stand_s = times.departure_s - times.arrival_s
            worst = max(worst, stop.dwell_min_s - stand_s if stop.stands else abs(stand_s))
    return worst


@given(journeys())
def test_windows_and_dwell_are_kept_and_the_prices_prove_the_optimum(
    given_journey: tuple[list[HopCurve], list[JourneyStop]],
) -> None:
    hops, stops = given_journey
    try:
        journey = journey_times(hops, stops)
    except WindowMissed:
        assume(False)
        return
    assert broken_by_s(stops, journey) <= 1e-5
    assert all(t >= hop.least_s - 1e-5 for t, hop in zip(journey.running_s, hops, strict=True))
    # KKT: at each price the hop's time is one of those that the price asks for
    for hop, time_s, price_w in zip(hops, journey.running_s, journey.prices_w, strict=True):
        low, high = hop.graph.prices_w(time_s + 1e-6)[0], hop.graph.prices_w(time_s - 1e-6)[1]
        slack_w = 1e-4 * max(abs(price_w), 1.0)
        assert low - slack_w <= price_w <= high + slack_w
    for stop, times, before, after in zip(
        stops[1:-1], journey.stops[1:-1], journey.prices_w, journey.prices_w[1:], strict=False
    ):
        assert times.arrival_s is not None and times.departure_s is not None
        at_latest = (
            times.arrival_s >= stop.arrival.latest_s - 1e-5
            or times.departure_s >= stop.departure.latest_s - 1e-5
        )
        at_earliest = (
            times.arrival_s <= stop.arrival.earliest_s + 1e-5
            or times.departure_s <= stop.departure.earliest_s + 1e-5
        )
        scale_w = 1e-4 * max(before, after, 1.0)
        if before > after + scale_w:  # later would save: a latest time forbids it
            assert at_latest or times.departure_s <= stop.departure.earliest_s + 1e-5
        if before < after - scale_w:
            assert at_earliest or times.departure_s - times.arrival_s > stop.dwell_min_s
    assert price_gap(hops, stops, journey) <= 1e-5 * energy_j(hops, journey.running_s) + 1.0


def price_gap(hops: Sequence[HopCurve], stops: Sequence[JourneyStop], journey: TimedJourney) -> float:
    """Energy of the plan over the bound that its own prices prove for these very curves, J."""
    if any(price < -1e-6 for price in journey.prices_w):  # a passing not before its time: no price of energy
        return 0.0
    prices = [max(price, 0.0) for price in journey.prices_w]
    lines = [
        ProvenHop((*tangents(hop), ParetoPoint(time_s, hop.energy_j(time_s), price_w, hop.energy_j(time_s))))
        for hop, time_s, price_w in zip(hops, journey.running_s, prices, strict=True)
    ]
    return energy_j(hops, journey.running_s) - journey_bound_j(lines, stops, prices)


def tangents(hop: HopCurve) -> list[ParetoPoint]:
    """Lines that lie below the curve at every time, touching it here and there."""
    times = np.linspace(hop.least_s, hop.longest_s, 15).tolist()
    flat = ParetoPoint(hop.longest_s, hop.energy_j(hop.longest_s), 0.0, hop.energy_j(hop.longest_s))
    return [*(ParetoPoint(t, hop.energy_j(t), hop.price_w(t), hop.energy_j(t)) for t in times), flat]


def open_journey(hops: Sequence[HopCurve], stretch: float) -> list[JourneyStop]:
    """No windows inside, in `stretch` times the least time."""
    end_s = stretch * sum(hop.least_s for hop in hops) + 20.0 * (len(hops) - 1)
    middle = [JourneyStop(str(i), dwell_min_s=20.0) for i in range(1, len(hops))]
    return [
        JourneyStop("0", departure=TimeWindow(0.0)),
        *middle,
        JourneyStop("end", TimeWindow(latest_s=end_s)),
    ]


@given(hops_of, st.floats(1.001, 2.0))
def test_without_windows_inside_all_prices_are_one(hops: list[HopCurve], stretch: float) -> None:
    prices_w = journey_times(hops, open_journey(hops, stretch)).prices_w
    assert max(prices_w) - min(prices_w) <= 1e-6 * max(prices_w)
    assert min(prices_w) > 0.0


@given(hops_of, st.floats(1.001, 2.0))
def test_proportional_curves_stretch_every_hop_alike(hops: list[HopCurve], stretch: float) -> None:
    stops = open_journey(hops, stretch)
    journey = journey_times([proportional_curve(hop.least_s) for hop in hops], stops)
    shares = [time_s / hop.least_s for hop, time_s in zip(hops, journey.running_s, strict=True)]
    assert shares == pytest.approx([stretch] * len(hops), rel=1e-6)


@given(journeys(), st.data())
def test_no_journey_within_the_windows_is_cheaper_nor_below_the_bound_of_any_prices(
    given_journey: tuple[list[HopCurve], list[JourneyStop]], data: st.DataObject
) -> None:
    hops, stops = given_journey
    try:
        best = journey_times(hops, stops)
        # any other within the windows: of least cost for other curves
        factors = data.draw(st.lists(st.floats(0.05, 20.0), min_size=len(hops), max_size=len(hops)))
        others = [
            analytic(hop.least_s, hop.points[0].energy_j * f) for hop, f in zip(hops, factors, strict=True)
        ]
        other = journey_times(others, stops)
    except WindowMissed:
        assume(False)
        return
    assert broken_by_s(stops, other) <= 1e-5
    other_j, best_j = energy_j(hops, other.running_s), energy_j(hops, best.running_s)
    assert best_j <= other_j * (1.0 + 1e-9) + 1e-3
    if all(math.isfinite(min(stop.arrival.latest_s, stop.departure.latest_s)) for stop in stops[1:]):
        prices = data.draw(st.lists(st.floats(0.0, 1e6), min_size=len(hops), max_size=len(hops)))
        proven = [
            ProvenHop(tuple(tangents(hop)), hop.least_s * data.draw(st.sampled_from([0.0, 1.0])))
            for hop in hops
        ]
        assert journey_bound_j(proven, stops, prices) <= best_j * (1.0 + 1e-9) + 1e-3


@given(journeys(), st.data())
def test_moving_any_time_within_its_windows_never_saves(
    given_journey: tuple[list[HopCurve], list[JourneyStop]], data: st.DataObject
) -> None:
    hops, stops = given_journey
    try:
        best = journey_times(hops, stops)
    except WindowMissed:
        assume(False)
        return
    base = [t for stop in best.stops for t in (stop.arrival_s, stop.departure_s) if t is not None]
    for _ in range(20):
        at = data.draw(st.integers(0, len(base) - 1))
        to = data.draw(st.integers(at, len(base) - 1))
        step = data.draw(st.floats(-30.0, 30.0))
        times = [t + step if at <= i <= to else t for i, t in enumerate(base)]
        moved = TimedJourney(
            tuple(
                type(stop)(
                    stop.name, times[2 * i - 1] if i else None, times[2 * i] if 2 * i < len(times) else None
                )
                for i, stop in enumerate(best.stops)
            ),
            best.prices_w,
        )
        if broken_by_s(stops, moved) <= 0.0:
            assert energy_j(hops, best.running_s) <= energy_j(hops, moved.running_s) + 1e-3


def test_against_every_journey_on_a_grid() -> None:
    hops = [analytic(100.0, 3e6), analytic(200.0, 9e6), analytic(80.0, 1e6)]
    stops = [
        JourneyStop("a", departure=TimeWindow(0.0)),
        JourneyStop("b", TimeWindow(latest_s=130.0), TimeWindow(125.0), 20.0),
        JourneyStop("c", TimeWindow(), TimeWindow(395.0), 10.0),
        JourneyStop("d", TimeWindow(latest_s=500.0)),
    ]
    best_j = energy_j(hops, journey_times(hops, stops).running_s)
    tables = [[hop.energy_j(float(second)) for second in range(501)] for hop in hops]
    found_j = math.inf
    for at_b, from_b, at_c in itertools.product(range(100, 131), range(125, 200), range(325, 450)):
        from_c = max(at_c + 10, 395)
        if from_b >= at_b + 20 and from_c < 500:
            found_j = min(found_j, tables[0][at_b] + tables[1][at_c - from_b] + tables[2][500 - from_c])
    assert best_j <= found_j + 1e-6
    assert best_j == pytest.approx(found_j, rel=1e-4)


def test_a_window_that_cannot_be_kept_is_named_with_its_seconds() -> None:
    hops = [analytic(100.0, 1e6), analytic(100.0, 1e6)]
    stops = [
        JourneyStop("a", departure=TimeWindow(0.0, 10.0)),
        JourneyStop("b", departure=TimeWindow(130.0, 140.0), dwell_min_s=20.0),
        JourneyStop("c", TimeWindow(latest_s=222.5)),
    ]
    with pytest.raises(WindowMissed) as missed:
        journey_times(hops, stops)
    assert (missed.value.stop, missed.value.event) == ("c", "arrival")
    assert missed.value.late_s == pytest.approx(7.5)
    with pytest.raises(WindowMissed, match=r"arrival at c 7\.5 s after its latest time"):
        earliest_times([105.0, 105.0], [100.0, 100.0], stops)
    passing = [
        stops[0],
        JourneyStop("b", TimeWindow(300.0, 400.0), stands=False),
        JourneyStop("c", TimeWindow(latest_s=900.0)),
    ]
    slow = [curve_of(hop.points, may_wait=False) for hop in hops]
    with pytest.raises(WindowMissed) as early:
        journey_times(slow, passing)
    assert (early.value.stop, early.value.late_s) == ("b", pytest.approx(-40.0))


def test_reserve_at_the_end_runs_as_fast_as_told_and_waits_for_the_timetable() -> None:
    stops = [
        JourneyStop("a", departure=TimeWindow(0.0)),
        JourneyStop("b", TimeWindow(latest_s=160.0), TimeWindow(180.0), 20.0),
        JourneyStop("c", TimeWindow(latest_s=400.0), TimeWindow(), 20.0),
        JourneyStop("d", TimeWindow(latest_s=700.0)),
    ]
    wanted, least = [100.0, 100.0, 100.0], [90.0, 90.0, 90.0]
    times = [(stop.arrival_s, stop.departure_s) for stop in earliest_times(wanted, least, stops).stops]
    assert times == [(None, 0.0), (100.0, 180.0), (280.0, 300.0), (400.0, None)]
    stops[-1] = JourneyStop("d", TimeWindow(latest_s=385.0))
    times = [(stop.arrival_s, stop.departure_s) for stop in earliest_times(wanted, least, stops).stops]
    assert times == [(None, 0.0), (100.0, 180.0), (275.0, 295.0), (385.0, None)]


def test_of_times_that_cost_the_same_the_earliest() -> None:
    journey = journey_times(
        [analytic(100.0, 1e6)],
        [JourneyStop("a", departure=TimeWindow(0.0, 50.0)), JourneyStop("b", TimeWindow(latest_s=900.0))],
    )
    assert (journey.stops[0].departure_s, journey.stops[1].arrival_s) == (0.0, pytest.approx(250.0))
