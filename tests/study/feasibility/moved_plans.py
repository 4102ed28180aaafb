"""Good plans with something in them moved by chance: some still work, some do not, and nobody has said which."""

from dataclasses import replace

from network.errors import InputError
from tests.study.feasibility.good_plans import good_plan
from tests.study.feasibility.plans import Plan, later
from tests.system.chaos.draw import Draw


def moved_plan(seed: int) -> Plan | None:
    """The plan of a seed; None where what came out is no timetable."""
    draw = Draw(seed, ("moved plan",))
    plan = good_plan(seed)
    for k in range(draw.whole(1, 2)):
        plan = _moved(plan, draw.of(str(k)))
    try:
        plan.setup()
    except InputError:
        return None
    return plan if plan.trains else None


def _moved(plan: Plan, draw: Draw) -> Plan:
    if not plan.trains:
        return plan
    train = draw.one_of(plan.trains)
    station = draw.one_of(train.calls).station
    how = draw.one_of(("set", "later", "sooner", "track"))
    if how == "set":  # its whole day
        by_s = draw.whole(-900, 900)
        for other in plan.trains:
            plan = plan.with_train(later(other, by_s)) if other.stock == train.stock else plan
        return plan
    if how == "track":
        calls = tuple(
            replace(c, track={"1": "2", "2": "1"}[c.track]) if c.station == station else c
            for c in train.calls
        )
        return plan.with_train(replace(train, calls=calls))
    by_s = draw.whole(10, 600) if how == "later" else -draw.whole(10, 200)
    return plan.with_train(later(train, by_s, station))
