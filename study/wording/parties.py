"""Who does, says and hears something: devices, persons, the world. Ids of units and terminals are names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from simulation.events import MANAGER, WORLD
from study.wording.phrase import Phrase

PARTIES: Final[Mapping[str, Phrase]] = {
    MANAGER: Phrase(MANAGER, "閉そく管理装置"),
    WORLD: Phrase(WORLD, "現場"),
    "drill": Phrase("drill", "訓練"),
    "controller": Phrase("controller", "指令員"),
    "staff": Phrase("staff", "係員"),
    "crew": Phrase("crew", "乗務員"),
    "*": Phrase("any party", "全装置"),
}


def party(name: str) -> Phrase:
    """What people call a party; its id where that is its name."""
    return PARTIES.get(name, Phrase(name))
