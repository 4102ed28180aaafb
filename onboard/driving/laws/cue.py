"""What a driving law is told in a tick, and the rows of a plan that it may follow."""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from vehicle.record import dtype_of

# plan.mode
PLAN_NONE: Final = 0  # no plan here
PLAN_HOLD: Final = 1  # be at the plan's speed
PLAN_COAST: Final = 2  # neither power nor brake
PLAN_FOLLOW: Final = 3  # as the plan's speed rises or falls from here to the next metre: power or brake


class CueRow(Protocol):
    """What is so in this tick. A law writes `ceiling_mps`, and `late_s` if it follows a plan; nothing else of it."""

    now_s: Annotated[float, "simulated time since midnight"]
    due_s: Annotated[float, "when the front should be at `unit.target_stop_m`; +inf: no matter when"]
    load_share: Annotated[float, "from the load sensor: 0 empty, 1 full"]
    own_mps2: Annotated[float, "what slows the train without any brake: gradient and running resistance"]
    reaction_s: Annotated[float, "until the brake answers"]
    limit_mps: Annotated[
        float, "driving stays under this: limits here and ahead, permitted speed, operating mode"
    ]
    ceiling_mps: Annotated[float, "the law's own: it means to run no faster than this"]
    late_s: Annotated[float, "the law's own: behind its plan by this; negative: ahead of it"]


class PlanRow(Protocol):
    """One metre of a plan, on the grid of the path database."""

    speed_mps: float
    time_left_s: Annotated[float, "from here to the target, by the plan"]
    mode: Annotated[int, "PLAN_NONE, PLAN_HOLD, PLAN_COAST or PLAN_FOLLOW"]


CUE: Final = dtype_of(CueRow)
PLAN: Final = dtype_of(PlanRow)
