"""Substitute working in cases of the wide family: the block manager is off for long, and people work the line."""

from typing import Any, Final

from simulation.procedure import Regime
from simulation.setup import Setup
from simulation.substitute.hops import RunsThrough, hops_of
from simulation.world.roster import drawn_up
from tests.system.chaos.draw import Draw
from wayside.config import MANAGER_ID

SUBSTITUTE_P: Final = 0.3
OFF_S: Final = (300.0, 2400.0)
# Quick people, so that the line is worked by them for a while; what is not named takes as long as in any run.
PEOPLE_S: Final = {"notice_s": (5.0, 120.0), "reach_s": (60.0, 600.0), "telephone_s": (5.0, 40.0)}
LIMITS: Final = {"time_limit_s": 28_800.0, "stall_limit_s": 10_800.0}
Row = dict[str, Any]


def worked(setup: Setup, when: Row, draw: Draw) -> tuple[Row, Row, tuple[Row, ...]]:
    """The tables `[substitute]` and `[limits]`, times of people, and the failure of the manager; or nothing of it."""
    if setup.battery is not None or not draw.chance(SUBSTITUTE_P):
        return {}, {}, ()
    try:
        works = {hop.work for hop in hops_of(drawn_up(setup, setup.line))}
    except RunsThrough:
        return {}, {}, ()
    regimes = [regime.value for regime in Regime]
    blocks = [section_id for section_id in setup.line.sections if section_id in works]
    other = draw.of("other")
    table: Row = {
        "regime": draw.of("regime").one_of(regimes),
        "staffed": [station for station in setup.line.stations if draw.of("staffed", station).chance(0.6)],
    }
    if other.chance(0.4):
        table["of_block"] = {other.one_of(blocks): other.one_of(regimes)}
    off = {"kind": "power_off", "target": MANAGER_ID, "duration_s": draw.of("off").by_size(*OFF_S)}
    people = {key: draw.of(key).by_size(*span) for key, span in PEOPLE_S.items()}
    return {"substitute": table, "limits": LIMITS}, people, (off | when,)
