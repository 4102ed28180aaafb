"""Every figure in the files of a bundle, with the kind of quantity that its schema says it is, in the file's own unit.

The kinds come from the schemas and their ranges from the table that `docs/files.md` is made of, so a new quantity is
found here by itself. A figure accepted is held against its range here once more, without the code that reads files.
"""

import math
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Final

from pydantic import BaseModel

from network.files.quantities import BY_NAME
from network.files.quantity import Quantity
from network.files.schema_walk import json_schema_of, resolved_node
from simulation.faults.table import FAULTS
from vehicle.train_file import UNITS, TrainFile

Path = tuple[int | str, ...]
ROUNDING: Final = 1e-9  # by which a figure is just inside or just outside


@dataclass(frozen=True, slots=True)
class Place:
    """A figure of a file: where it stands, what it is, and by what it is multiplied to be in the quantity's unit."""

    path: Path
    quantity: Quantity
    whole: bool
    factor: float = 1.0

    @property
    def key(self) -> str:
        """As messages spell it."""
        text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.path)
        return text.removeprefix(".")

    def holds(self, value: float) -> bool:
        """Whether a value of the file is in the range, but for the rounding of units."""
        if not math.isfinite(value):
            return False
        real = value * self.factor
        slack = 2 * ROUNDING * max(1e-9, abs(real)) * (self.factor != 1.0)
        return any(low - slack <= real <= high + slack for low, high in self.quantity.spans)

    def edges(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Values at and just inside the ends of the range, and values just outside, as the file writes them."""
        inside: set[float] = set()
        outside: set[float] = set()
        for low, high in self.quantity.spans:
            for end, outwards in ((low, -1), (high, 1)):
                written = end if self.factor == 1.0 else end / self.factor
                step = 1 if self.whole else max(abs(written), 1.0) * ROUNDING * 10
                # In another unit the end itself may be rounded out of the range.
                inside |= {written if self.factor == 1.0 else written - outwards * step * (low < high)}
                inside |= {written - outwards * step} if low < high else set()
                outside |= {written + outwards * step}
        outside = {value for value in outside if not self.holds(value)}
        make = int if self.whole else float
        return tuple(map(make, sorted(inside))), tuple(map(make, sorted(outside)))


def places_of(model: type[BaseModel], data: Mapping[str, Any]) -> Iterator[Place]:
    """Every figure that `data` has, by the model's schema."""
    schema = json_schema_of(model)
    yield from _places(schema, resolved_node(schema, schema), data, (), model is TrainFile)


def _places(
    schema: Mapping[str, Any], node: Mapping[str, Any], value: object, path: Path, train: bool
) -> Iterator[Place]:
    node = resolved_node(schema, node)
    if isinstance(value, Mapping):
        for key, inner in value.items():
            own, factor = node.get("properties", {}).get(key), 1.0
            if own is None and train:
                own, factor = _in_other_unit(node, key)
            if own is None and isinstance(node.get("additionalProperties"), Mapping):
                own = node["additionalProperties"]
            if own is not None:
                for place in _places(schema, own, inner, (*path, key), train):
                    yield place if factor == 1.0 else Place(place.path, place.quantity, place.whole, factor)
        if path[:1] == ("fault",) and value.get("kind") in FAULTS:
            yield from _fault_places(value, path)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _places(schema, node.get("items", {}), inner, (*path, i), train)
    elif "quantity" in node and isinstance(value, int | float) and not isinstance(value, bool):
        yield Place(path, _in_schema_unit(node), node.get("type") == "integer")


def _in_schema_unit(node: Mapping[str, Any]) -> Quantity:
    """The quantity with the range of its schema, which has that of the table in the key's unit."""
    known = BY_NAME[node["quantity"]]
    ranges = node.get("oneOf", [node])
    spans = tuple((each["minimum"], each["maximum"]) for each in ranges)
    return Quantity(known.name, known.unit, spans, known.source)


def _in_other_unit(node: Mapping[str, Any], key: str) -> tuple[Any, float]:
    """The schema of a train's key that is written in another unit than SI."""
    for ending, si_ending, up, down in UNITS:
        if key.endswith(ending) and "_per_" not in key:
            return node.get("properties", {}).get(key.removesuffix(ending) + si_ending), up / down
    return None, 1.0


def _fault_places(value: Mapping[str, Any], path: Path) -> Iterator[Place]:
    """The figures that a kind of fault has of its own."""
    schema = json_schema_of(FAULTS[value["kind"]])
    for key, own in schema["properties"].items():
        if key in value and "quantity" in own and not isinstance(value[key], bool | str):
            yield Place((*path, key), _in_schema_unit(own), own["type"] == "integer")


def value_at(data: Any, path: Path) -> Any:  # noqa: ANN401
    """What stands at a path."""
    for part in path:
        data = data[part]
    return data


def with_value(data: Any, path: Path, value: object) -> Any:  # noqa: ANN401
    """A copy with another value at a path."""
    copy = deepcopy(data)
    value_at(copy, path[:-1])[path[-1]] = value
    return copy


def leaves(data: object, path: Path = ()) -> Iterator[Path]:
    """Every place that holds a plain value."""
    if isinstance(data, Mapping):
        for key, inner in data.items():
            yield from leaves(inner, (*path, key))
    elif isinstance(data, list):
        for i, inner in enumerate(data):
            yield from leaves(inner, (*path, i))
    elif path:
        yield path
