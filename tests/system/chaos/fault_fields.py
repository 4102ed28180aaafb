"""What a drawn fault aims at and has in its fields: of any kind of `simulation.faults.table`, those of tomorrow too.

A field is drawn between the bounds of its own schema, or in the part of them that is stated here with its reason.
"""

from collections.abc import Collection
from dataclasses import replace
from typing import Any, Final

from annotated_types import Ge, Gt, Le, Lt
from pydantic.fields import FieldInfo

from network.files.quantity import Quantity
from network.model import CrossingControl, Line
from onboard.driving_settings import Driving
from simulation.faults.crossing_road import StalledVehicle
from simulation.faults.fault import Fault, Names
from simulation.faults.links import ANY, BOTH_WAYS, ONE_WAY
from simulation.faults.table import KINDS
from tests.system.chaos.draw import Draw
from wayside.config import MANAGER_ID

# (kind, field): least and greatest, and why not all that the schema allows.
RANGES: Final[dict[tuple[str, str], tuple[float, float, str]]] = {
    ("delay", "seconds"): (0.1, 30.0, "beyond the age limit of a telegram it is a cut"),
    ("reorder", "seconds"): (0.2, 10.0, "the same"),
    ("loss", "p"): (0.2, 1.0, "less than this the air does by itself"),
    ("slow", "factor"): (1.0, 6.0, "a throw of half a minute is longer than any terminal waits"),
    ("scale", "factor"): (0.0, 3.0, "from dead to three times the speed"),
    ("clock", "offset_s"): (-30.0, 30.0, "beyond the age limit of a telegram nothing gets through"),
    ("clock", "drift_ppm"): (-2000.0, 2000.0, "the worst clocks that are sold as such"),
    ("slippery", "factor"): (Driving().design_adhesion_share, 1.0, "below it is outside the design"),
}
# What a vehicle that stalls before a train that can stop no more comes to is computed, not forbidden.
DRAWN: Final = tuple(kind for kind in KINDS if kind is not StalledVehicle)
WITHOUT_BOUND: Final = (0.0, 10.0)
TAG_OF_THE_LINE_P: Final = 0.6  # a wrong id that is another tag's says a wrong place; most others say nothing
ANY_PARTY_P: Final = 0.3
IN_USE_P: Final = 0.8


def bounds_of(kind: type[Fault[Any]], name: str) -> tuple[float, float]:
    """Least and greatest value that the schema of a field allows."""
    low, high = WITHOUT_BOUND
    for bound in kind.model_fields[name].metadata:
        match bound:
            case Ge(ge=value) | Gt(gt=value):
                low = float(value)  # type: ignore[arg-type]
            case Le(le=value) | Lt(lt=value):
                high = float(value)  # type: ignore[arg-type]
            case Quantity(spans=spans):
                low, high = spans[0][0], spans[-1][1]
            case _:
                pass
    return low, high


def aimed_at(names: Names, line: Line) -> Names:
    """Without level crossings by contacts: they tell no train anything, so that none can stop where they fail."""
    deaf = {c.id for c in line.crossings.values() if c.control is CrossingControl.CONTACTS}
    return replace(
        names,
        devices=tuple(name for name in names.devices if name not in deaf),
        crossings=tuple(name for name in names.crossings if name not in deaf),
    )


def fields_of(kind: type[Fault[Any]], names: Names, draw: Draw) -> dict[str, Any]:
    """Values of a kind's own fields."""
    own = {name: info for name, info in kind.model_fields.items() if name != "target"}
    return {name: _value(kind, name, info, names, draw.of(name)) for name, info in own.items()}


def _value(
    kind: type[Fault[Any]], name: str, info: FieldInfo, names: Names, draw: Draw
) -> float | int | bool | str:
    low, high = RANGES.get((kind.kind, name), (*bounds_of(kind, name), ""))[:2]
    if name == "section":
        return draw.one_of(names.sections)
    if name == "network":  # where there is one radio, whichever it is of is that one
        return draw.one_of(("any", *names.networks)) if len(names.networks) > 1 else "any"
    if info.annotation is bool:
        return draw.chance(0.5)
    if info.annotation is int:
        if kind.aims_at == "tag" and draw.chance(TAG_OF_THE_LINE_P):
            return int(draw.one_of(names.tags))
        return draw.whole(int(low), int(high))
    if info.annotation is float:
        return draw.between(low, high)
    raise TypeError(f"{kind.kind}.{name} is {info.annotation}: say here how it is drawn")


def target_of(kind: type[Fault[Any]], names: Names, uses: Collection[str], draw: Draw) -> str:
    """What it aims at: mostly something that is in use; of devices as often a unit as one of the ground, and there as
    often the manager as a terminal.
    """
    if draw.chance(IN_USE_P):
        names = replace(
            names,
            units=_used(names.units, uses),
            devices=_used(names.devices, uses),
            tags=_used(names.tags, uses),
            points=_used(names.points, uses),
            crossings=_used(names.crossings, uses),
        )
    if kind.aims_at == "link":
        return _link(names, draw)
    targets = kind.targets(names)
    if MANAGER_ID in targets:
        terminals = [name for name in names.devices if name != MANAGER_ID] or [MANAGER_ID]
        targets = draw.one_of((names.units, draw.one_of(((MANAGER_ID,), tuple(terminals)))))
    return draw.one_of(targets)


def _used(names: tuple[str, ...], uses: Collection[str]) -> tuple[str, ...]:
    return tuple(name for name in names if name in uses) or names


def _link(names: Names, draw: Draw) -> str:
    unit = ANY if draw.chance(ANY_PARTY_P) else draw.one_of(names.units)
    device = draw.one_of(names.devices)
    if draw.chance(0.5):
        device = MANAGER_ID
    if unit != ANY and draw.chance(ANY_PARTY_P):
        device = ANY
    ends = (unit, device) if draw.chance(0.5) else (device, unit)
    return (BOTH_WAYS if draw.chance(0.5) else ONE_WAY).join(ends)
