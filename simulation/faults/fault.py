"""Invariant: what a quantity is at any time follows from its base value and the faults in force alone, in the order
in which they began; one that ends takes nothing but itself away.

A fault is a type: its fields are its table in a file, with bounds, its family says what it may aim at and which
quantity it changes, `applied_to` is its effect on that. All of it is data: what makes trains and track so is
`simulation.world.disorder`, what makes devices and units so `simulation.effects`. `simulation.faults.table` finds the
types. Faults that overlap are folded: each makes of the value what it makes of it, from the base up. Nothing is ever
set back; it is computed again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, Literal, Self, TypeVar

import numpy as np

from network.files.toml_input import Record, one_of
from simulation.settings import PositionSensor

VehiclePart = Literal["doors_closed", "brake_good", "motors_share"]  # as in `onboard.vehicle.Vehicle`

V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class Names:
    """Everything on a line that a fault, an act or an expectation may name."""

    units: tuple[str, ...] = ()
    devices: tuple[str, ...] = ()  # the block manager, the terminals, level crossings
    tags: tuple[str, ...] = ()
    markers: tuple[str, ...] = ()  # groups of them
    points: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    stations: tuple[str, ...] = ()
    trains: tuple[str, ...] = ()
    people: tuple[str, ...] = ()
    routes: tuple[str, ...] = ()
    pieces: tuple[str, ...] = ()
    cable: tuple[str, ...] = ()  # its stretches, each between two neighbouring stations
    signals: tuple[str, ...] = ()  # line signals
    levers: tuple[str, ...] = ()  # direction levers
    crossings: tuple[str, ...] = ()  # level crossings that have a device
    chargers: tuple[str, ...] = ()  # stations that have one, where sets run on batteries
    on_battery: tuple[str, ...] = ()  # units of these sets
    networks: tuple[str, ...] = ("first",)  # that trains have a radio of
    # With substitute working: by post and section or station, the steps that are that post's there.
    steps: Mapping[tuple[str, str], tuple[str, ...]] = field(
        default_factory=dict[tuple[str, str], tuple[str, ...]]
    )

    @property
    def posts(self) -> tuple[str, ...]:
        """Those who work a line by substitute working, each at its place."""
        return tuple(sorted({post for post, _ in self.steps}))

    def aimed_at(self, what: str) -> tuple[str, ...]:
        """All of a kind of target (`Fault.aims_at`)."""
        return {
            "charger": self.chargers,
            "device": (*self.devices, *self.units),
            "group of markers": self.markers,
            "level crossing": self.crossings,
            "points": self.points,
            "section": self.sections,
            "tag": self.tags,
            "unit": self.units,
        }[what]


@dataclass(frozen=True, slots=True)
class Onset:
    """When a fault takes hold, as far as a fault may keep it."""

    t_s: float
    chance: np.random.Generator  # its own
    shown_mps: Callable[[str], float]  # what the tachometer of a stock shows


class Fault(Record, Generic[V]):
    """A kind of failure of something named by `target`; V is the type of the quantity that it changes."""

    kind: ClassVar[str]  # the word in files
    aims_at: ClassVar[str]  # kind of target, in words
    changes: ClassVar[str]  # the quantity; faults on the same quantity of the same target are folded
    in_order: ClassVar[Any]  # the quantity without any fault, unless `base` tells it
    momentary: ClassVar[bool] = False  # begins and ends at once
    of_sensor: ClassVar[PositionSensor | None] = None  # a unit that does not carry it never notices

    target: Any

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        """What it may aim at."""
        return names.aimed_at(cls.aims_at)

    def wrong_target(self, names: Names) -> str:
        """What should stand in place of a target that does not exist; empty if it does."""
        known = self.targets(names)
        return "" if self.target in known else f"a {self.aims_at}: {one_of(known, self.target)}"

    def wrong_names(self, _names: Names) -> dict[str, str]:
        """By key of its own, what should stand in place of a name that does not exist."""
        return {}

    def taking_hold(self, _onset: Onset, /) -> Self:
        """The fault as it takes hold; a kind that keeps something of the moment returns a copy that has it."""
        return self

    def base(self) -> V:
        """The quantity without any fault."""
        value: V = self.in_order
        return value

    def applied_to(self, value: V, /) -> V:
        """What the fault makes of the quantity."""
        raise NotImplementedError

    @property
    def place(self) -> tuple[str, str]:
        """The quantity and whose it is."""
        return self.changes, str(self.target)

    def parameters(self) -> dict[str, Any]:
        """Its own fields, without the target."""
        return self.model_dump(exclude={"target"})


class SwitchedFault:
    """What is as it should be (`in_order`) or is not: comes before the family among the bases."""

    in_order: ClassVar[Any]

    def applied_to(self, _value: bool, /) -> bool:
        return not self.in_order


class UnitFault(Fault[V], Generic[V]):
    """A kind of failure of one train's equipment, named by the stock that has it."""

    aims_at = "unit"
    target: str


class SensorFault(UnitFault[V], Generic[V]):
    """A kind of failure of one train's sensor: its quantity is a field of the sensor's row."""

    sensor: ClassVar[str]  # name of its row
    field: ClassVar[str]


def folded_value(base: V, faults: Iterable[Fault[V]]) -> V:
    """The value in force: what the faults, in their order, make of the base."""
    for fault in faults:
        base = fault.applied_to(base)
    return base


F = TypeVar("F", bound=Fault[Any])


class InForce:
    """The faults in force, by number, in the order in which they began."""

    def __init__(self) -> None:
        self._faults: dict[int, Fault[Any]] = {}

    def __contains__(self, key: int) -> bool:
        return key in self._faults

    def begin(self, key: int, fault: Fault[Any], onset: Onset) -> None:
        """A fault takes hold."""
        self._faults[key] = fault.taking_hold(onset)

    def end(self, key: int) -> None:
        """A fault is over; the others of its place stay in force."""
        del self._faults[key]

    def value(self, fault: Fault[V]) -> V:
        """What the quantity that a fault changes is now."""
        now: V = folded_value(fault.base(), [self._faults[key] for key in self.at(fault.place)])
        return now

    def at(self, place: tuple[str, str]) -> list[int]:
        """Numbers of the faults in force on one quantity of one target."""
        return [key for key, fault in self._faults.items() if fault.place == place]

    def in_family(self, kind: type[F]) -> list[F]:
        """Those of a family, in order."""
        return [fault for fault in self._faults.values() if isinstance(fault, kind)]
