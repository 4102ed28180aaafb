"""A unit's reckoning of its charge: what the way to the next charge takes, and whether it may leave."""

import math
from dataclasses import dataclass, field, replace

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable
from onboard.charge import ChargeRules, ChargeWatch
from onboard.duty.unable import NoCharge
from onboard.mission import Mission
from onboard.reach import BatteryHop, Reach, SetWays, charger_at, to_next_charge
from simulation.world.roster import draw_up

KWH = 3.6e6
LINE = load_line(shipped_line("karasuyama"))


@dataclass
class Gauge:
    """A battery that shows what a test wants."""

    has: float
    gains_w: float = 0.0
    now_s: float = 0.0
    connected: bool = False
    full: bool = False
    up: bool = True
    keeps_j: float = 0.0
    ready: bool = False
    asked: list[tuple[float, float]] = field(default_factory=list)

    @property
    def charges(self) -> bool:
        return self.gains_w > 0.0

    def has_j(self, at_s: float) -> float:
        later_s = at_s - self.now_s
        return self.has + (self.gains_w * later_s if 0.0 < later_s < math.inf else 0.0)

    def ask(self, needed_j: float, leaves_s: float, keeps_j: float) -> None:
        self.asked.append((needed_j, leaves_s))
        self.keeps_j = keeps_j


def missions() -> tuple[Mission, Mission]:
    """333M down to Karasuyama and 336M back."""
    timetable = load_timetable(shipped_timetable("karasuyama_weekday"), LINE)
    drawn = draw_up(LINE, timetable, dict.fromkeys(("V1", "V2", "V3", "V4"), 40.0), 210.0)["V4"]
    return next(d.mission for d in drawn if d.train.number == "333M"), next(
        d.mission for d in drawn if d.train.number == "336M"
    )


def ways() -> SetWays:
    """Every hop takes 5 kWh, every stand 1 kWh."""
    hops: list[BatteryHop] = []
    first: dict[str, int] = {}
    for mission in missions():
        first[mission.number] = len(hops)
        for here, there in zip(mission.targets, mission.targets[1:], strict=False):
            hops.append(
                BatteryHop(
                    mission.number,
                    here.place_id,
                    there.place_id,
                    180.0,
                    5.0 * KWH,
                    1.0 * KWH,
                    charger_at(LINE, there),
                    there.station_id is None,
                )
            )
    return SetWays(tuple(hops), first)


def watch(gauge: Gauge, *, waits: bool = True) -> ChargeWatch:
    return ChargeWatch(LINE, ways(), ChargeRules(waits, 10.0 * KWH, 0.1), gauge)


def test_to_the_next_charger_and_past_a_dead_one() -> None:
    ahead = ways().ahead("333M", 1)  # at Hoshakuji: seven hops down
    assert to_next_charge(ahead, ()) == Reach(7 * 5.0 * KWH + 6 * KWH, "KRS", 7)
    assert to_next_charge(ahead, {"KRS"}) == Reach(14 * 5.0 * KWH + 13 * KWH, "HSK", 14)
    assert to_next_charge(ahead, {"KRS", "HSK"}).hops == len(ahead)


def test_what_is_taken_off_the_line_counts_before_the_charge_there() -> None:
    home, later = ways().ahead("336M", 0)[:2], ways().ahead("336M", 2)[:1]
    leaves = replace(home[1], charger="", wire=True, beyond_j=46.8 * KWH)
    assert to_next_charge((home[0], leaves, *later), ()).needed_j == pytest.approx((10.0 + 1.0 + 46.8) * KWH)
    uncharged = to_next_charge((home[0], replace(leaves, wire=False), *later), ())
    assert uncharged.hops == 3 and uncharged.needed_j == pytest.approx((10.0 + 2.0 + 46.8 + 6.0) * KWH)


def test_no_charger_is_left_before_the_day_ends() -> None:
    ahead = ways().ahead("333M", 1)[:8]
    assert to_next_charge(ahead, {"KRS"}) == Reach(8 * 5.0 * KWH + 8 * KWH, None, 8)


def test_at_a_charger_it_keeps_a_reserve_and_elsewhere_it_does_not() -> None:
    down, _ = missions()
    gauge = Gauge(has=1.1 * 41.0 * KWH + 9.9 * KWH)
    why = watch(gauge).why_not(down, 1)
    assert isinstance(why, NoCharge) and why.station == "KRS" and not why.charges
    assert gauge.asked[-1] == (pytest.approx(1.1 * 41.0 * KWH + 10.0 * KWH), down.targets[1].departure_s)
    gauge.has = 1.1 * 41.0 * KWH + 10.1 * KWH
    assert watch(gauge).why_not(down, 1) is None
    gauge.has = 1.1 * 35.0 * KWH + 0.1 * KWH
    assert watch(gauge).why_not(down, 2) is None  # on its way: what is predicted is enough


def test_on_its_way_it_does_without_what_can_wait_and_at_a_charger_it_does_not() -> None:
    """Of the 5 kWh of the five stands before Karasuyama 4 can wait; to stay at a halt for heating helps nobody."""
    down, _ = missions()
    saving = SetWays(tuple(replace(hop, saves_j=0.8 * hop.stand_j) for hop in ways().hops), ways().first)
    gauge = Gauge(has=1.1 * 31.0 * KWH + 0.1 * KWH)
    own = ChargeWatch(LINE, saving, ChargeRules(True, 10.0 * KWH, 0.1), gauge)
    assert own.why_not(down, 2) is None
    assert gauge.asked[-1][0] == pytest.approx(1.1 * 31.0 * KWH)
    assert gauge.keeps_j == pytest.approx(1.1 * 31.0 * KWH + 10.0 * KWH)
    gauge.has -= 0.2 * KWH
    assert own.why_not(down, 2) is not None
    own.why_not(down, 1)
    assert gauge.asked[-1][0] == pytest.approx(1.1 * 41.0 * KWH + 10.0 * KWH)


def test_it_reckons_with_the_charge_it_will_have() -> None:
    down, _ = missions()
    departs_s = down.targets[1].departure_s
    assert departs_s is not None
    lacks_j = 1.1 * 41.0 * KWH + 10.0 * KWH
    gauge = Gauge(has=lacks_j - 100e3 * 60.0, gains_w=110e3, now_s=departs_s - 60.0)
    assert watch(gauge).why_not(down, 1) is None
    gauge.gains_w = 90e3
    why = watch(gauge).why_not(down, 1)
    assert why is not None and "charging" in why.words
    gauge.full = True
    why = watch(gauge).why_not(down, 1)
    assert why is not None and why.words.endswith("and it is full")


def test_told_of_a_dead_charger_it_reckons_anew() -> None:
    down, _ = missions()
    own = watch(Gauge(has=70.0 * KWH))
    assert own.why_not(down, 1) is None
    own.hear_of_dead({"KRS"})
    why = own.why_not(down, 1)
    assert why is not None and why.station == "HSK"
    own.hear_of_dead(())
    assert own.why_not(down, 1) is None


def test_who_leaves_whatever_is_never_kept() -> None:
    down, _ = missions()
    gauge = Gauge(has=0.0)
    assert watch(gauge, waits=False).why_not(down, 1) is None
    assert gauge.asked[-1][0] == 0.0


def test_a_raised_pantograph_keeps_it_too() -> None:
    down, _ = missions()
    own = watch(Gauge(has=90.0 * KWH, connected=True))
    departs_s = down.targets[1].departure_s
    assert departs_s is not None
    own.now_s = departs_s - 1.0
    assert own.why_not(down, 1) is None
    own.now_s = departs_s
    why = own.why_not(down, 1)
    assert why is not None and why.words == "a lowered pantograph"


@pytest.mark.parametrize("waits", [True, False])
def test_whatever_the_rule_a_raised_pantograph_keeps_it_though_its_clock_be_set_back(waits: bool) -> None:
    down, _ = missions()
    gauge = Gauge(has=90.0 * KWH, connected=True)
    own = watch(gauge, waits=waits)
    departs_s = down.targets[1].departure_s
    assert departs_s is not None
    for now_s in (departs_s, departs_s - 600.0):
        own.now_s = now_s
        why = own.why_not(down, 1)
        assert why is not None and why.connected
    gauge.connected = False
    assert own.why_not(down, 1) is None


def test_where_the_plan_has_no_time_it_leaves_with_enough_and_the_pantograph_down() -> None:
    down, _ = missions()
    free = replace(down, targets=tuple(replace(target, departure_s=None) for target in down.targets))
    gauge = Gauge(has=90.0 * KWH, connected=True)
    why = watch(gauge).why_not(free, 1)
    assert why is not None and why.connected and gauge.asked[-1][1] == -math.inf


def test_with_too_little_when_its_time_has_come_it_charges_until_its_way_is_free() -> None:
    """Lowered as soon as it has enough, it would use that up as it waits, and be unable again, and so on."""
    down, _ = missions()
    needed_j, departs_s = 1.1 * 41.0 * KWH + 10.0 * KWH, down.targets[1].departure_s
    gauge = Gauge(has=needed_j - 1.0 * KWH, gains_w=300e3, connected=True)
    own = watch(gauge)
    assert departs_s is not None
    own.now_s = gauge.now_s = departs_s + 100.0
    why = own.why_not(down, 1)
    assert why is not None and not why.connected and not why.stays_up
    assert gauge.asked[-1] == (pytest.approx(needed_j), math.inf)  # it may stay up for as long as it takes
    gauge.has += 2.0 * KWH
    why = own.why_not(down, 1)
    # nothing to spare: no route is held for that
    assert why is not None and why.connected and not why.stays_up
    gauge.ready = True
    why = own.why_not(down, 1)
    assert why is not None and why.connected and why.stays_up
    own.told(None)  # its way is not free
    assert gauge.asked[-1][1] == math.inf
    own.told(why)
    assert gauge.asked[-1][1] == -math.inf
    why = own.why_not(down, 1)
    gauge.ready = False
    why = own.why_not(down, 1)
    assert why is not None and why.connected and why.stays_up  # on its way down
    own.told(why)
    assert len(gauge.asked) == 3  # and told so once
    gauge.connected = False
    assert own.why_not(down, 1) is None


def test_what_it_lacks_is_never_said_to_be_what_it_has() -> None:
    """Both are 55.1 kWh to a tenth."""
    down, _ = missions()
    gauge = Gauge(has=1.1 * 41.0 * KWH + 10.0 * KWH - 100.0)
    why = watch(gauge).why_not(down, 1)
    assert why is not None and why.words.startswith(
        "55.1 kWh to KRS, where it can charge next: it has 55.0 kWh"
    )


def test_on_sight_nothing_is_asked_for_but_the_time_and_afterwards_all_again() -> None:
    down, _ = missions()
    gauge = Gauge(has=10.0 * KWH)
    own = watch(gauge)
    assert own.why_not(down, 1) is not None
    own.on_sight(down, 1)
    assert gauge.asked[-1] == (0.0, down.targets[1].departure_s)
    assert own.why_not(down, 1) is not None and gauge.asked[-1][0] > 0.0


def test_it_charges_only_with_the_pantograph_up() -> None:
    down, _ = missions()
    why = watch(Gauge(has=10.0 * KWH, gains_w=1.0, up=False)).why_not(down, 1)
    assert why is not None and why.words.endswith("and its pantograph is not up")


def test_at_the_last_stop_nothing_is_asked() -> None:
    down, _ = missions()
    assert watch(Gauge(has=0.0)).why_not(down, len(down.targets) - 1) is None


@pytest.mark.parametrize("on_sight", [False, True])
def test_a_stand_is_to_leave_it_what_its_way_takes_and_a_reserve(on_sight: bool) -> None:
    down, _ = missions()
    gauge = Gauge(has=90.0 * KWH)
    own = watch(gauge)
    (own.on_sight if on_sight else own.why_not)(down, 2)
    assert gauge.keeps_j == pytest.approx(1.1 * 35.0 * KWH + 10.0 * KWH)
    (own.on_sight if on_sight else own.why_not)(down, len(down.targets) - 1)
    assert gauge.keeps_j == pytest.approx(10.0 * KWH)
