"""Each shipped drill fails when the behaviour that it checks is switched off (see `conftest` for the switches)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

import pytest

from study.drill import shipped_drills
from study.run import Run

pytestmark = pytest.mark.system

FOLDER: Final = "rtri/"

# drill: switch, and one expectation or checker that must object
WITHOUT: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        "01_normal": ("releases_at_the_front", "no invariant is broken"),
        "02_turn_back": ("keeps_proofs_when_turning", "no invariant is broken"),
        "03_block_held": ("grants_what_another_holds", "the request is refused: section 8 is held"),
        "04_unit_power_position_fixed": (
            "restarts_at_full_speed",
            "low speed until position and holdings are known",
        ),
        "05_unit_power_position_unknown": (
            "crew_does_not_stop_before_points",
            "the train is stopped before the points and the crew looks how they lie",
        ),
        "05b_extra_tag": ("reads_no_tag_after_a_restart", "it resumes before the points"),
        "06_unit_manager_link": ("silence_frees", "x"),
        "07_unit_terminal_link": ("does_not_wait_for_proof", "no invariant is broken"),
        "08a_tachometer_scale": ("believes_any_tag", "x"),
        "08b_tachometer_silent": ("ignores_position_faults", "position fault"),
        "08c_tachometer_silent_at_start": ("ignores_position_faults", "position fault"),
        "08d_tachometer_stuck": ("ignores_position_faults", "position fault"),
        "09_manager_power": ("starts_with_every_section_free", "x"),
        "10_manager_link": ("silence_frees", "x"),
        "11_terminal_link": ("does_not_wait_for_proof", "it does not enter them"),
        "12_terminal_power": ("does_not_wait_for_proof", "it does not enter them"),
        "12b_terminal_power_after_throw": ("points_unlock_without_power", "no invariant is broken"),
        "13_tag_not_read": ("expects_no_tag", "x"),
        "20_route_given_back": ("keeps_a_route_set_back", "T2 gets its route"),
        "21_points_stuck": ("proves_what_it_has_not_detected", "the train waits before them"),
        "22_points_no_detection": ("proves_what_it_has_not_detected", "but not proven"),
        "23_points_slow": ("terminal_allows_no_slower_throw", "they are proven, later"),
        "24_manager_frozen": ("obeys_stale_telegrams", "x"),
        "25_wrong_tag_id": ("believes_any_tag", "the unit does not believe it"),
        "26_tags_swapped": ("believes_tags_too_old_or_new", "the unit does not believe the first"),
        "27_slippery_rail": ("bounds_do_not_grow", "no invariant is broken"),
    }
)


@pytest.mark.parametrize("drill", WITHOUT)
def test_a_drill_fails_without_the_behaviour_that_it_checks(
    drill: str, run_with: Callable[..., tuple[Run, set[str]]]
) -> None:
    switched_off, objector = WITHOUT[drill]
    _, objections = run_with(FOLDER + drill, switched_off)
    assert objector in objections


def test_no_drill_is_left_out() -> None:
    shipped = {name.removeprefix(FOLDER) for name in shipped_drills() if name.startswith(FOLDER)}
    assert shipped == set(WITHOUT)
