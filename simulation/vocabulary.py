"""Every word that a journal entry may have as its `what`; a test holds real journals to it."""

from __future__ import annotations

from typing import Final

from wayside.said import NoteKind

DEVICE_WORDS: Final = {
    NoteKind.STARTED: "restarted",
    NoteKind.CLAIMED: "signed_on",
    NoteKind.BY_HAND: "confirmed_by_hand",
    NoteKind.COMMANDED: "points_commanded",
    NoteKind.PROVEN: "points_proven",
    NoteKind.UNPROVEN: "points_unproven",
}


def device_word(kind: NoteKind) -> str:
    """The word for a device's note."""
    return DEVICE_WORDS.get(kind, kind.value.replace(" ", "_"))


UNIT_WORDS: Final = frozenset(
    {
        "arrived",
        "changed_ends",
        "claimed",
        "crew_checked_points",
        "crew_waits_at_points",
        "departs",
        "emergency_released",
        "gave_back",
        "give_back_refused",
        "holds",
        "learned",
        "intervention",
        "mission",
        "mission_done",
        "moving",
        "points_refused",
        "position_fault",
        "position_found",
        "proof_dropped",
        "proven",
        "refused",
        "register_differs",
        "reported",
        "overran",
        "restarted",
        "resumed",
        "route_held",
        "sign_off_refused",
        "sign_seen",
        "sign_on_refused",
        "signed_off",
        "signed_on",
        "stop_limit",
        "stop_impossible",
        "stopped_short",
        "tachometer_fault",
        "tag_doubted",
        "tag_read",
        "telegram_dropped",
        "took_effect",
    }
)
WORLD_WORDS: Final = frozenset(
    {
        "act",
        "collision",
        "entered",
        "fault",
        "fault_over",
        "heard",
        "left",
        "lost_at_dead_device",
        "points_forced",
        "points_locked",
        "points_moving",
        "points_set_by_hand",
        "points_unlocked",
        "power_off",
        "power_on",
        "reversed",
        "sent",
        "tag_passed",
        "unsafe",
    }
)
WORDS: Final = UNIT_WORDS | WORLD_WORDS | {device_word(kind) for kind in NoteKind}
