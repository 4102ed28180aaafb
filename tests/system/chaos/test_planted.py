"""Random cases find defects that are planted: that they find nothing means something.

Not all: what only a party that misbehaves could bring out, random faults cannot. How many cases each takes depends on
the draws; the limits here are several times that.
"""

from pathlib import Path
from typing import Final

import pytest

from simulation.judge.checkers import Checker
from tests.nightly import others_nightly
from tests.system.chaos.families import Family
from tests.system.chaos.planted import Found, found_by
from tests.system.conftest import SWITCHES

# A behaviour that is taken away, and words of what then goes wrong.
AT_ONCE: Final = {
    "grants_what_another_holds": ("collision", Checker.ONE_TRAIN_A_SECTION, Checker.NO_DOUBLE_GRANT),
    "bounds_do_not_grow": (Checker.WITHIN_BOUNDS,),
    # who claims too little is told so by the register, or runs where it holds nothing
    "claims_only_where_it_stands": ("dead: agreement", Checker.INSIDE_HOLDING),
    "does_not_wait_for_proof": (
        "unsafe: ran onto points",
        "unsafe: ran through points",
        Checker.PROVEN_BEFORE_ENTRY,
    ),
    "releases_at_the_front": (Checker.RELEASE_BEHIND_REAR,),
}
SOON: Final = {
    "believes_any_tag": ("unsafe", Checker.WITHIN_BOUNDS, Checker.RELEASE_BEHIND_REAR),
    "accepts_telegrams_twice": (Checker.TELEGRAM_ONCE,),
    "ground_accepts_telegrams_twice": (Checker.TELEGRAM_ONCE,),
    "crew_does_not_look": ("unsafe", Checker.POINTS_UNDER_TRAIN),
    "grants_while_undefined": (Checker.UNDEFINED_GRANTS_NOTHING,),
}
# What the wide family has besides, each of it by a defect of its own.
WIDE: Final = {
    "grants_a_block_too_many": ("crash: ValueError in wayside/register.py",),
    "lets_all_come_in": (Checker.ONE_COMES_IN,),
    "takes_what_both_networks_bring": (Checker.TELEGRAM_ONCE,),
    "has_its_markers_elsewhere": (Checker.WITHIN_BOUNDS,),
    "reckons_with_ten_times_the_way": ("dead: what takes it to",),
    "keeps_trains_back_for_ever": ("dead: route",),
    "stays_in_hand": (Checker.NO_DEAD_STATE,),
}
RARE: Final = range(530, 545)  # few cases come to a cut; the first one that did is among these


def _found(name: str, seeds: range, nets: Path, family: Family = Family.TEST_LINE) -> Found:
    found = found_by(SWITCHES[name], family, seeds, nets)
    assert found is not None, f"not in {len(seeds)} cases"
    return found


@pytest.mark.parametrize(
    "name", others_nightly(AT_ONCE, ["does_not_wait_for_proof", "releases_at_the_front"])
)
def test_a_defect_is_found_at_once(name: str, nets: Path) -> None:
    assert _found(name, range(40), nets).kind.startswith(AT_ONCE[name])


@pytest.mark.nightly
@pytest.mark.parametrize("name", SOON)
def test_a_defect_is_found_soon(name: str, nets: Path) -> None:
    assert _found(name, range(1000), nets).kind.startswith(SOON[name])


@pytest.mark.parametrize("name", others_nightly(WIDE, ["has_its_markers_elsewhere"]))
def test_a_defect_of_what_lines_and_days_may_have_besides_is_found(name: str, nets: Path) -> None:
    assert _found(name, range(1, 61), nets, Family.WIDE).kind.startswith(WIDE[name])


@pytest.mark.nightly
def test_a_defect_of_what_a_dispatcher_may_do_is_found(nets: Path) -> None:
    found = found_by(SWITCHES["takes_no_delay_for_one_that_nobody_knows"], Family.WIDE, RARE, nets)
    assert found is not None
    assert found.kind == "crash: ValueError in wayside/cutting.py:_why"
