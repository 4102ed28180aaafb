"""How a planner's wish becomes times: windows by the timetable, margins at the end, spread, or where they save most."""

import math

import numpy as np
import pytest

from network.model import Direction
from network.profile import profile_of
from network.timetable import CallKind
from onboard.driving.pattern import limit_for_train, lowered_by
from onboard.driving.planner.allocation import allocated
from onboard.driving.planner.arrivals import ArrivalAims, TrainOnMap, arrivals_s, up_to_fixed
from onboard.driving.planner.windows import journey_stops, made_possible
from onboard.driving.planner.wish import Margin, Planning
from onboard.mission import Mission, Target
from scenario.scenario import load_scenario
from simulation.world.roster import drawn_up
from vehicle.optimum import least_time
from vehicle.optimum.journey import JourneyStop, TimeWindow, WindowMissed, journey_times
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of
from vehicle.resistance import climb_m
from vehicle.running_time import laid_down_s


def hop(least_s: float, scale_j: float) -> HopCurve:
    return curve_of(
        ParetoPoint(least_s * r, scale_j * (1.0 + 1.0 / r), scale_j / (least_s * r * r))
        for r in (1.0, 1.03, 1.1, 1.2, 1.4, 2.0)
    )


HOPS = [hop(97.0, 1e6), hop(198.0, 2e7), hop(101.0, 2e6)]
FREE = (
    JourneyStop("a", departure=TimeWindow(0.0, 0.0)),
    JourneyStop("b", dwell_min_s=20.0),
    JourneyStop("c", dwell_min_s=20.0),
    JourneyStop("d", TimeWindow(latest_s=500.0)),
)


def test_margin_at_the_end_runs_standard_times_and_arrives_with_the_reserve_in_hand() -> None:
    journey = allocated(HOPS, FREE, Margin.END).journey
    assert journey.running_s == pytest.approx((100.0, 200.0, 105.0))
    assert journey.stops[-1].arrival_s == pytest.approx(445.0)


def test_margin_spread_is_in_proportion_to_the_least_times() -> None:
    journey = allocated(HOPS, FREE, Margin.SPREAD).journey
    assert [t / h.least_s for t, h in zip(journey.running_s, HOPS, strict=True)] == pytest.approx(
        [460.0 / 396.0] * 3
    )


def test_margin_where_it_saves_costs_least() -> None:
    energies = {
        margin: sum(
            h.energy_j(t) for h, t in zip(HOPS, allocated(HOPS, FREE, margin).journey.running_s, strict=True)
        )
        for margin in Margin
    }
    assert energies[Margin.SAVING] < energies[Margin.SPREAD] < energies[Margin.END]


@pytest.mark.parametrize("margin", list(Margin))
def test_a_late_train_is_no_later_than_its_least_times_make_it(margin: Margin) -> None:
    stops = (*FREE[:2], JourneyStop("c", TimeWindow(latest_s=300.0), TimeWindow(330.0, 330.0), 20.0), FREE[3])
    with pytest.raises(WindowMissed):
        journey_times(HOPS, stops)
    found = allocated(HOPS, stops, margin)
    assert found.late_s == pytest.approx(15.0)
    times = found.journey.stops
    assert (times[2].arrival_s, times[2].departure_s) == (pytest.approx(315.0), pytest.approx(335.0))
    assert (times[3].arrival_s or 0.0) <= 500.0 + 1e-6


def mission_of(number: str) -> tuple[Mission, float]:
    setup = load_scenario("karasuyama_weekday").setup
    duties = (duty for duties in drawn_up(setup, setup.line).values() for duty in duties)
    return next(
        duty.mission for duty in duties if duty.train.number == number
    ), setup.timetable.head.dwell_min_s


def test_windows_keep_the_departures_and_where_trains_meet_the_tolerance_is_none() -> None:
    mission, dwell_s = mission_of("321M")
    at = next(i for i, target in enumerate(mission.targets) if target.station_id is not None)
    strict = journey_stops(mission, at, 0.0, dwell_s, 10.0)
    loose = journey_stops(mission, at, 0.0, dwell_s, 10.0, tolerance_s=40.0)
    assert [stop.name for stop in strict] == ["HSK", "SHN", "NIT", "KNY", "OGN", "KBN", "TAK", "KRS"]
    for target, tight, wide in zip(mission.targets[at:], strict, loose, strict=True):
        assert tight.departure.earliest_s == wide.departure.earliest_s
        over_s = 0.0 if target.station_id in {"HSK", "OGN", "KRS"} else 40.0
        if target.departure_s is not None:
            assert tight.departure.earliest_s == tight.departure.latest_s == target.departure_s
            assert wide.departure.latest_s == target.departure_s + over_s
        latest_s = target.latest_arrival_s(dwell_s)
        if tight is not strict[0] and latest_s is not None:
            assert tight.arrival.latest_s == latest_s - 10.0
            assert wide.arrival.latest_s == latest_s - 10.0 + over_s


def test_a_train_held_back_departs_when_it_can() -> None:
    mission, dwell_s = mission_of("321M")
    at = next(i for i, target in enumerate(mission.targets) if target.station_id is not None)
    departure_s = mission.targets[at].departure_s
    assert departure_s is not None
    held = journey_stops(mission, at, departure_s + 90.0, dwell_s, 10.0)
    assert held[0].departure == TimeWindow(departure_s + 90.0, departure_s + 90.0)
    _, late_s = made_possible(held, [250.0] * (len(held) - 1))
    assert late_s > 0.0


def test_the_latest_arrival_leaves_the_least_dwell() -> None:
    def at(
        arrival_s: float | None, departure_s: float | None, kind: CallKind = CallKind.STOP
    ) -> float | None:
        return Target("A", "1", "A1", 0.0, arrival_s, departure_s, (), kind).latest_arrival_s(20.0)

    assert at(100.0, 110.0) == 90.0
    assert at(100.0, 110.0, CallKind.OPERATIONAL) == 100.0
    assert at(None, 110.0) == 90.0
    assert at(100.0, None) == 100.0
    assert at(None, None) is None


def test_directions_do_not_matter_to_where_trains_can_meet() -> None:
    for number in ("321M", "322M"):
        mission, _ = mission_of(number)
        assert mission.direction in Direction
        crossing = {target.station_id for target in mission.targets if target.crossing}
        assert "OGN" in crossing and "TAK" not in crossing
    assert math.isfinite(mission.targets[-1].mark_m)


def on_map_of(mission: Mission) -> TrainOnMap:
    setup = load_scenario("karasuyama_weekday").setup
    kind = next(iter(setup.trains.values()))
    train = kind.row.view(np.recarray)[0]
    profile = profile_of(setup.line, mission.path)
    driving_mps = lowered_by(limit_for_train(profile["limit_mps"], train), setup.driving.driving_margin_mps)
    climbs_m = np.ascontiguousarray(climb_m(train, profile["elevation_m"], profile["turn_rad"]))
    return TrainOnMap(kind.row[0], 0.2, climbs_m, driving_mps, setup.driving.stop_deceleration_mps2)


@pytest.mark.parametrize("margin", [Margin.SPREAD, Margin.SAVING])
def test_with_fixed_departures_every_arrival_is_the_latest(margin: Margin) -> None:
    mission, dwell_s = mission_of("321M")
    on_map, times = on_map_of(mission), ArrivalAims(dwell_s, 10.0)
    for at, target in enumerate(mission.targets[1:-1], 1):
        latest_s = mission.targets[at + 1].latest_arrival_s(dwell_s)
        if target.departure_s is not None and latest_s is not None:
            due_s = arrivals_s(Planning(margin=margin), on_map, mission, at, 0.0, times)
            assert due_s == (latest_s - 10.0,)


def test_a_tolerance_gives_time_to_the_hop_that_has_too_little_up_to_where_trains_meet() -> None:
    mission, dwell_s = mission_of("321M")
    on_map, times = on_map_of(mission), ArrivalAims(dwell_s, 10.0)
    names = [target.station_id for target in mission.targets]
    at, meets = names.index("SHN"), names.index("OGN")
    planning = Planning(plan_tolerance_s=40.0)
    due_s = arrivals_s(planning, on_map, mission, at, 0.0, times)
    assert len(due_s) == meets - at
    latest_s = [target.latest_arrival_s(dwell_s) or 0.0 for target in mission.targets[at + 1 : meets + 1]]
    assert latest_s[0] - 10.0 < due_s[0] <= latest_s[0] + 30.0
    assert due_s[-1] == pytest.approx(latest_s[-1] - 10.0)


def test_margin_at_the_end_arrives_after_the_standard_time() -> None:
    mission, dwell_s = mission_of("321M")
    on_map, times = on_map_of(mission), ArrivalAims(dwell_s, 10.0)
    at = [target.station_id for target in mission.targets].index("NIT")
    departure_s = mission.targets[at].departure_s
    assert departure_s is not None
    (due_s,) = arrivals_s(Planning(margin=Margin.END), on_map, mission, at, 0.0, times)
    course = on_map.course(mission.targets[at].mark_m, mission.targets[at + 1].mark_m)
    assert due_s - departure_s == laid_down_s(float(least_time(course).time_s[-1]))


def test_where_there_is_no_time_there_is_no_arrival_to_mean() -> None:
    mission, dwell_s = mission_of("322M")
    at = len(mission.targets) - 2
    assert mission.targets[at + 1].station_id is None
    due_s = arrivals_s(Planning(), on_map_of(mission), mission, at, 0.0, ArrivalAims(dwell_s, 10.0))
    assert due_s == (math.inf,)


def test_a_stop_without_a_time_takes_none_from_the_stop_before_it() -> None:
    """A train that goes on from its last station to a portal, which has no time, is due at the station all the same."""
    here = JourneyStop("A", departure=TimeWindow(0.0, 0.0))
    station = JourneyStop("B", TimeWindow(latest_s=300.0), TimeWindow(), 20.0)
    portal = JourneyStop("portal", TimeWindow(), TimeWindow())
    found = up_to_fixed((here, station, portal))
    assert [stop.name for stop in found] == ["A", "B"]
    assert found[-1].arrival.latest_s == 300.0
    alone = up_to_fixed((here, portal))
    assert math.isinf(alone[-1].arrival.latest_s)
