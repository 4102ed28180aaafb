"""Who may do what: each seat, whose name its acts bear, which acts it may do, and whether it sees the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

from simulation.faults.script import BY_ROLE, ActKind
from simulation.procedure import Post
from simulation.substitute.work import is_post, place_of


class Seat(Enum):
    """A place at the desk."""

    INSTRUCTOR = "instructor"
    DISPATCHER = "dispatcher"  # 指令
    STAFF = "staff"  # 駅係員
    DRIVER = "driver"  # 運転士, of one train
    GUEST = "guest"  # looks on, as a departure board does


@dataclass(frozen=True, slots=True)
class SeatRights:
    """What a seat may do. `person`: who its acts are by in the journal, or of whoever `leads`, unless another is named;
    `leads`: time, faults, and the truth; `sees_forecast`: how the day will go on; `posts`: which roles of substitute
    working its holder may take, a driver that of the own unit.
    """

    person: str = ""
    acts: frozenset[ActKind] = frozenset()
    leads: bool = False
    sees_forecast: bool = False
    posts: tuple[Post, ...] = ()


_BY_TELEPHONE: Final = frozenset(
    {
        ActKind.CONFIRM_OUTSIDE,
        ActKind.CONFIRM_HOLDING,
        ActKind.TAKE_BACK,
        ActKind.ENTER_SECTION,
        ActKind.BAR_UNIT,
        ActKind.UNBAR_UNIT,
        ActKind.FREE_ROAD,
    }
)
_OF_DISPATCHER: Final = frozenset(
    {
        ActKind.ACCEPT_PICTURE,
        ActKind.REENTER_ASSISTED,
        ActKind.REENTER_BY_HAND,
        ActKind.GIVE_BACK,
        ActKind.HOLD_TRAIN,
        ActKind.LET_GO,
        ActKind.END_TRAIN,
    }
)
OF_OWN_UNIT: Final = frozenset({ActKind.DRIVE, ActKind.DRIVE_BY_ATO, ActKind.GIVE_BACK, ActKind.POWER_ON})
_ON_THE_SPOT: Final = frozenset(
    {
        ActKind.POWER_ON,
        ActKind.COMMISSION,
        ActKind.REPAIR_POINTS,
        ActKind.HAUL_AWAY,
        ActKind.BRING_POWER,
        ActKind.GUARD_ROAD,
        ActKind.LEAVE_ROAD,
    }
)
RIGHTS: Final[Mapping[Seat, SeatRights]] = {
    Seat.INSTRUCTOR: SeatRights(
        "controller", frozenset(ActKind), leads=True, sees_forecast=True, posts=tuple(Post)
    ),
    Seat.DISPATCHER: SeatRights(
        "controller", _OF_DISPATCHER | _BY_TELEPHONE | BY_ROLE, sees_forecast=True, posts=(Post.DISPATCHER,)
    ),
    Seat.STAFF: SeatRights(
        "staff", _ON_THE_SPOT | _BY_TELEPHONE | BY_ROLE, posts=(Post.OPERATOR, Post.PILOT)
    ),
    Seat.DRIVER: SeatRights("crew", OF_OWN_UNIT | {ActKind.REPAIR_POINTS} | BY_ROLE, posts=(Post.DRIVER,)),
    Seat.GUEST: SeatRights(),
}


def may_be(seat: Seat, post: str, unit: str) -> bool:
    """Whether the holder of a seat, a driver's that of this unit, may take a role of substitute working."""
    return is_post(post, *RIGHTS[seat].posts) and (seat is not Seat.DRIVER or place_of(post) == unit)
