"""What re-entry costs the person: inputs until the Karasuyama line is defined again, by hand and assisted."""

from pathlib import Path

import pytest

from network.files.line_file import load_line
from radio.keys import capability_key
from radio.messages import Claim
from wayside.acts import Act
from wayside.block_manager import AskUnits, Heard, step
from wayside.config import ReentryMode, manager_config
from wayside.register import start
from wayside.said import AcceptPicture, ConfirmHolding, EnterSection

KARASUYAMA = Path(__file__).resolve().parents[2] / "network" / "lines" / "karasuyama.toml"
FOUR_OUT = {
    "V1": ("HSK.MD", "HSK.S", "HSK.1"),
    "V2": ("HSK-OGN", "OGN.W", "OGN.1"),
    "V3": ("OGN.2",),
    "V4": ("OGN-KRS", "KRS.1"),
}


def karasuyama(mode: ReentryMode, silent: frozenset[str]) -> int:
    """Inputs until the line is defined again, with four trains out of which some stand in stations and do not speak."""
    config = manager_config(load_line(KARASUYAMA), [], tuple(FOUR_OUT), reentry=mode)
    assert len(config.sections) == 11
    terminals = {terminal_id for section in config.sections for terminal_id in section.terminal_ids}
    keys = {terminal_id: capability_key(b"m" * 32, terminal_id) for terminal_id in terminals}
    register, _ = step(start(config, 2, keys, FOUR_OUT), AskUnits(), 0.0)
    for unit_id in FOUR_OUT.keys() - silent:
        register, _ = step(register, Heard(unit_id, 1, True, 1, Claim(FOUR_OUT[unit_id], 7)), 1.0)
    acts: list[Act] = []
    if mode is ReentryMode.BY_HAND:
        holder = {section: unit_id for unit_id, held in FOUR_OUT.items() for section in held}
        acts += [
            EnterSection(section.section_id, holder.get(section.section_id), "controller")
            for section in config.sections
        ]
    for unit_id in sorted(silent):
        people = ("staff",) if mode is ReentryMode.BY_HAND else ("controller", "staff")
        acts += [ConfirmHolding(unit_id, FOUR_OUT[unit_id], person) for person in people]
    for act in (*acts, AcceptPicture("controller")):
        assert not register.defined
        register, _ = step(register, act, 60.0)
    assert register.defined
    assert {unit_id: register.held_by(unit_id) for unit_id in FOUR_OUT} == FOUR_OUT
    return register.inputs


@pytest.mark.parametrize(
    ("silent", "by_hand", "assisted"), [((), 12, 1), (("V3",), 13, 3)], ids=["all speak", "one is silent"]
)
def test_assisted_needs_at_most_a_third_of_the_inputs(
    silent: tuple[str, ...], by_hand: int, assisted: int
) -> None:
    assert karasuyama(ReentryMode.BY_HAND, frozenset(silent)) == by_hand
    assert karasuyama(ReentryMode.ASSISTED, frozenset(silent)) == assisted
    assert 3 * assisted <= by_hand
