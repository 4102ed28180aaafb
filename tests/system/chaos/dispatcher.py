"""What cases of the wide family draw besides faults: what trains carry, a LiDAR among it, and its air; what the
dispatcher may do by himself; and what is said and done at a desk meanwhile: trains kept back, let go, ended
early, driven by hand.
"""

from typing import Any, Final

from network.model import SectionKind
from simulation.setup import Setup
from tests.system.chaos.draw import Draw
from wayside.config import DispatcherMeans, OrderRule

LIDAR_P: Final = 0.6  # where there are markers
CARRIES: Final = (("tags", "lidar"), ("lidar",), ("gnss", "lidar"), ("lidar", "curvature"))
WEATHER_P, VISIBILITY_M, DIRT_MAX = 0.5, (30.0, 20_000.0), 0.5
DISPATCH_P: Final = 0.7
LATE_MIN: Final = (0.0, 0.5, 1.0, 4.0)  # short days: little makes them late
# what a cut call counts, and what a cut must gain
CUTS_MIN: Final = ((0.1, 0.0), (0.5, 0.0), (5.0, 1.0), (60.0, 10.0))
HOLD_P, END_P, BY_HAND_P = 0.35, 0.3, 0.25
HOLD_S: Final = (20.0, 600.0)
NOTCHES: Final = (-7, 4)
Row = dict[str, Any]


def carried(setup: Setup, draw: Draw) -> Row:
    """The tables `[sensors]` and `[lidar]`, of which one set or all have a LiDAR; none without markers."""
    if not setup.line.markers or not draw.chance(LIDAR_P):
        return {}
    carries = list(draw.one_of(CARRIES))
    stock_id = draw.of("stock").one_of(sorted(setup.trains))
    sensors: Row = {"carries_of": {stock_id: carries}} if draw.of("one").chance(0.5) else {"carries": carries}
    weather = draw.of("weather")
    if not weather.chance(WEATHER_P):
        return {"sensors": sensors}
    lidar = {
        "visibility_m": weather.by_size(*VISIBILITY_M),
        "dirt_share": weather.of("dirt").between(0.0, DIRT_MAX, 2),
    }
    return {"sensors": sensors, "lidar": lidar}


def means(setup: Setup, draw: Draw) -> Row:
    """The table `[dispatch]`; none where it stays as the ground has it."""
    if not draw.chance(DISPATCH_P):
        return {}
    some = draw.of("some")
    stations = [station.id for station in setup.line.stations.values() if not station.is_halt]
    cancelled_min, gain_min = draw.of("cuts").one_of(CUTS_MIN)
    table = {
        "certificate": True,
        "order": draw.one_of([order.value for order in OrderRule]),
        "may": [one.value for one in DispatcherMeans if some.of(one.value).chance(0.6)],
        "turn_back_at": [name for name in stations if some.of("at", name).chance(0.6)],
        "cancel_trains": [number for number in setup.timetable.trains if some.of("cut", number).chance(0.5)],
        "keep_order_below_min": draw.one_of(LATE_MIN),
        "cancelled_min": cancelled_min,
        "cut_gain_min": gain_min,
        "overtaken_max": draw.of("overtaken").whole(1, 3),
    }
    return {"dispatch": table}


def said(setup: Setup, when: dict[str, Any], draw: Draw) -> tuple[Row, ...]:
    """What a dispatcher says from this time on; nothing of it for longer than a few minutes."""
    units = sorted(setup.trains)
    unit_id = draw.one_of(units)
    rows: list[Row] = []
    if draw.of("hold").chance(HOLD_P):
        held = {"kind": "hold_train", "target": unit_id, "hold_s": draw.of("hold").between(*HOLD_S, 0)}
        others = [one for one in units if one != unit_id]
        if others and draw.of("order").chance(0.5):
            over = [s.id for s in setup.line.sections.values() if s.kind is SectionKind.BETWEEN]
            held |= {"behind": draw.of("other").one_of(others), "place": draw.of("over").one_of(over)}
        rows.append(held | when)
        if draw.of("let go").chance(0.3):
            rows.append(
                {"kind": "let_go", "target": unit_id}
                | later(when, draw.of("let go", "s").between(5.0, 120.0, 1))
            )
    end = draw.of("end")
    sets = [d for d in setup.timetable.diagrams if len(d.train_numbers) > 1]
    # Nobody proves that all can finish after what a person says (decision 176): at an end of one track they may not.
    can_pass = all(len(station.tracks) > 1 for station in setup.line.stations.values() if not station.is_halt)
    if sets and can_pass and end.chance(END_P):
        diagram = end.one_of(sets)
        train = end.one_of(diagram.train_numbers[1:])
        rows.append({"kind": "end_train", "target": diagram.stock_id, "train": train} | when)
    return tuple(rows)


def driven(setup: Setup, when: dict[str, Any], draw: Draw) -> tuple[Row, ...]:
    """A crew that drives by hand for a while, by one notch after the other."""
    if not draw.chance(BY_HAND_P):
        return ()
    crew = {"target": draw.one_of(sorted(setup.trains)), "person": "crew"}
    rows: list[Row] = []
    after_s = 0.0
    for k in range(draw.whole(1, 3)):
        notch = draw.of("notch", str(k)).whole(*NOTCHES)
        rows.append({"kind": "drive", "notch": notch} | crew | later(when, after_s))
        after_s += draw.of("for", str(k)).by_size(2.0, 60.0)
    return (*rows, {"kind": "drive_by_ato"} | crew | later(when, after_s))


def later(when: dict[str, Any], by_s: float) -> dict[str, Any]:
    """The same beginning, so much later."""
    return when | {"after_s": round(when.get("after_s", 0.0) + by_s, 1)}
