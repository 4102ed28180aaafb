"""Level crossings with their roads in whole runs: trains run as without one, and what stands on a closed crossing is
seen in time, or struck at the speed that braking leaves.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import pytest

from onboard.notes import Intervention
from scenario.scenario import Scenario
from simulation.events import CrossingEntered, CrossingLamps, VehicleStruck
from simulation.faults.crossing_road import StalledVehicle
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.result import Ending, RunResult
from simulation.setup import STEPS_PER_S, Setup
from simulation.world.crossings import CrossingsOnTrack
from study.collect.crossings import hours_run
from study.collect.road import road_table
from study.runner.outcome import broken_rules
from study.runner.run import CarrierKind, PartyLink, execute, simulation_of
from tests.scenario.own import own_scenario

ROAD: Final = "road = { vehicles_per_h = [600.0] }"
EMPTY: Final = "road = { vehicles_per_h = [0.0] }"
DETECTOR: Final = "detector = true"
CONTACTS: Final = 'control = "contacts"\nstart_down_km = 0.46\nstart_up_km = 1.2'
TEN_S: Final = 36_000.0


def scenario_of(folder: Path, base: str, crossing: str, patch: str = "", more: str = "") -> Scenario:
    """The scenario `base` with a crossing C1."""
    text = f'{more}\n{patch}\n[[patch.line.add.crossings]]\nid = "C1"\n{crossing}\n'
    return own_scenario(folder, text, base)


def on_test_line(folder: Path, *keys: str, more: str = "") -> Scenario:
    crossing = "\n".join(('section = "6"', "km = 0.75", *keys))
    return scenario_of(folder, "rtri_test_line", crossing, more=more)


def run(setup: Setup) -> RunResult:
    with simulation_of(setup) as simulation:
        return simulation.run()


def digests(result: RunResult) -> tuple[str, str]:
    return result.digest, result.motion_digest


def test_trains_and_devices_do_as_without_a_road_and_on_plain_track(tmp_path: Path) -> None:
    """A detector that sees nothing changes nothing either."""
    scenario = on_test_line(tmp_path, DETECTOR, ROAD)
    busy = execute(scenario, PartyLink.SIMULATED)
    plain = execute(scenario, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    assert digests(busy.result) == digests(plain.result)
    assert digests(busy.result) == digests(run(on_test_line(tmp_path).setup))
    assert plain.tables.road.is_empty()
    assert busy.tables.road["hour"].to_list() == list(hours_run(busy.result))  # one crossing, every hour
    assert busy.tables.road["passages"].sum() > 100
    assert busy.tables.road["queue"].max() >= 3  # in some 42 s seven come in each lane


def closed_s(result: RunResult) -> float:
    """From when the lamps begin to shine until they go out, s."""
    lamps = {e.event.lit: e.t_s for e in result.journal.entries if isinstance(e.event, CrossingLamps)}
    return lamps[False] - lamps[True]


def test_the_road_waits_by_how_long_it_is_closed(tmp_path: Path) -> None:
    """By contacts the slow train closes it for longer than by radio. Arrivals are the same; who comes while it is
    closed waits half of the closure on average, so the waiting grows with its square.
    """
    by_radio = run(on_test_line(tmp_path, ROAD).setup)
    by_contacts = run(on_test_line(tmp_path, CONTACTS, ROAD).setup)
    radio_s, contacts_s = closed_s(by_radio), closed_s(by_contacts)
    assert contacts_s > radio_s + 3.0
    waited_h = [road_table(each.road)["waited_h"].sum() for each in (by_radio, by_contacts)]
    assert waited_h[0] > 0.0
    assert waited_h[1] > waited_h[0] * contacts_s / radio_s


def test_each_day_of_learning_has_its_own_vehicles(tmp_path: Path) -> None:
    """On the second day others come than on the first, in the same net."""
    learns = "[tuning]\ndays = 2\n"
    first = execute(on_test_line(tmp_path, ROAD), PartyLink.SIMULATED)
    second = execute(on_test_line(tmp_path, ROAD, more=learns), PartyLink.SIMULATED)
    assert second.tables.road["passages"].sum() > 100
    assert second.tables.road["passages"].to_list() != first.tables.road["passages"].to_list()


# A train of the Karasuyama line at 62 km/h, and what stalls before it -----------------------------------------------

KM: Final = 4.9
PATH_M: Final = 1000.0  # where kilometrage 0 is on the path of a train that comes through the portal
UNTIL_S: Final = 20_900.0
VEHICLE_M: Final = 1000.0 * KM + 1.5 - 0.9  # the near side of a car in the lane on the left of the road
# The train's emergency brake (m/s2, s), and by hand its resistance at 60 km/h, 3.2 N/kN, and the gradient, 1 permille,
# with 8 % more mass in what rotates.
BRAKE_MPS2, DEAD_S, LAG_S = 1.25, 0.5, 0.4
DRAG_MPS2: Final = (3.2 + 1.0) / 1000.0 * 9.81 / 1.08


def braked(speed_mps: float, room_m: float) -> tuple[float, float]:
    """Speed (m/s) after `room_m` of emergency braking, from its command on, and the way (m), which may end before."""
    step_s, at_m, brake_mps2, t_s = 0.001, 0.0, 0.0, 0.0
    while speed_mps > 0.0 and at_m < room_m:
        t_s += step_s
        if t_s > DEAD_S:
            brake_mps2 += (BRAKE_MPS2 - brake_mps2) / LAG_S * step_s
        speed_mps -= (brake_mps2 + DRAG_MPS2) * step_s
        at_m += speed_mps * step_s
    return max(speed_mps, 0.0), at_m


@dataclass(frozen=True, slots=True)
class Approach:
    """A train's run towards the crossing while nothing is on it."""

    setup: Setup
    there_s: float  # at the vehicle's place
    speed_mps: float

    def stalled_s(self, to_go_m: float) -> float:
        """When the train has still so far to go, s."""
        return round(self.there_s - to_go_m / self.speed_mps, 1)

    def stalls(self, to_go_m: float, for_s: float | None = None) -> Setup:
        """The setup in which a vehicle stalls when the train has still so far to go."""
        fault = ScriptedFault(StalledVehicle(target="C1"), Trigger(at_s=self.stalled_s(to_go_m)), for_s)
        return replace(self.setup, script=Script((fault,)))


@pytest.fixture(scope="module")
def approach(tmp_path_factory: pytest.TempPathFactory) -> Approach:
    """V2, at an even speed for the last 350 m."""
    covered = '[patch.line]\nset = { "alignments.main.coverage" = [{ from_km = -1.0, to_km = 20.304 }] }'
    crossing = f'section = "HSK-OGN"\nkm = {KM}\n{DETECTOR}\n{EMPTY}'
    folder = tmp_path_factory.mktemp("kara")
    setup = scenario_of(folder, "karasuyama_weekday", crossing, covered).setup
    setup = replace(setup, until_s=UNTIL_S)
    result = run(setup)
    (entered,) = [e for e in result.journal.entries if isinstance(e.event, CrossingEntered)]
    assert isinstance(entered.event, CrossingEntered)
    edge_m, speed_mps = 1000.0 * KM - 3.0, entered.event.speed_mps
    return Approach(setup, entered.t_s + (VEHICLE_M - edge_m) / speed_mps, speed_mps)


def struck(result: RunResult) -> list[float]:
    """Speeds at which vehicles were struck, km/h."""
    return [3.6 * e.event.speed_mps for e in result.journal.entries if isinstance(e.event, VehicleStruck)]


def test_200_m_ahead_of_its_braking_distance_a_train_stops_short(approach: Approach) -> None:
    """It goes on when the vehicle has, and nothing was struck."""
    _, braking_m = braked(approach.speed_mps, 1000.0)
    assert 115.0 < braking_m < 145.0  # 17.1^2 / (2 x 1.25), and a second of 17 m
    result = run(approach.stalls(braking_m + 200.0, 60.0))
    assert struck(result) == []
    assert list(broken_rules(result)) == []
    (entered,) = [e for e in result.journal.entries if isinstance(e.event, CrossingEntered)]
    assert entered.t_s > approach.stalled_s(braking_m + 200.0) + 60.0
    assert result.ended_because is Ending.PART_OVER


@pytest.mark.parametrize("inside_m", [50.0, 25.0])
def test_inside_its_braking_distance_it_strikes_at_the_speed_that_is_left(
    approach: Approach, inside_m: float, record_property: Callable[[str, object], None]
) -> None:
    """The detector looks twice a second, and two parties and a telegram come between it and the brake."""
    _, braking_m = braked(approach.speed_mps, 1000.0)
    setup = approach.stalls(braking_m - inside_m)
    stalled_s = approach.stalled_s(braking_m - inside_m)
    result = run(setup)
    (at_kmh,) = struck(result)
    brakes = [
        e.t_s for e in result.journal.entries if isinstance(e.event, Intervention) and e.t_s > stalled_s
    ]
    assert brakes[0] - stalled_s < 1.2
    rows = result.trace[result.trace["slot"] == result.stock_ids.index("V2")]
    before = rows[rows["step"] <= round(stalled_s * STEPS_PER_S)][-1]
    even_mps, even_s = float(before["speed_mps"]), brakes[0] - float(before["step"]) / STEPS_PER_S
    room_m = PATH_M + VEHICLE_M - float(before["position_m"]) - even_mps * even_s
    left_mps, _ = braked(even_mps, room_m)
    record_property("figures", f"struck at {at_kmh:.2f} km/h, computed {3.6 * left_mps:.2f} km/h")
    assert at_kmh == pytest.approx(3.6 * left_mps, abs=0.5)
    assert result.ended_because is Ending.COLLISION


def test_without_its_detector_nobody_tells_the_train(approach: Approach) -> None:
    """What stops it above is the detector."""
    blind = {key: replace(each, has_detector=False) for key, each in approach.setup.line.crossings.items()}
    setup = approach.stalls(300.0)
    result = run(replace(setup, line=replace(setup.line, crossings=blind)))
    (at_kmh,) = struck(result)
    assert at_kmh == pytest.approx(3.6 * approach.speed_mps, abs=0.5)


def test_a_driver_does_not_creep_onto_what_he_sees(
    approach: Approach, monkeypatch: pytest.MonkeyPatch
) -> None:
    """He has stood there for longer than he takes to get leave; one that does not look strikes it at a crawl."""
    setup = approach.stalls(300.0, 200.0)
    assert struck(run(setup)) == []
    monkeypatch.setattr(CrossingsOnTrack, "is_blocked", lambda *_: False)
    (at_kmh,) = struck(run(setup))
    assert 0.0 < at_kmh < 20.0
