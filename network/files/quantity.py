"""What a kind of figure is: its unit, the range outside of which it is nonsense, and what the range rests on.

A `Quantity` stands in `Annotated[float, …]` of every key that has it (`network.files.quantities` lists all), checks
the value, and leaves its name in the JSON Schema, from which `docs/files/ranges.md` and the tests of damaged files
read it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

OUT_OF_RANGE: Final = "out_of_range"  # type of the error, as pydantic tells it


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of figure. `spans`: the ranges, ends included, in rising order and in `unit`; `source`: of the ends."""

    name: str
    unit: str
    spans: tuple[tuple[float, float], ...]
    source: str

    def holds(self, value: float) -> bool:
        """Whether a value is no nonsense; never one that is not finite."""
        return any(low <= value <= high for low, high in self.spans)

    def text(self) -> str:
        """The range in words, with its unit: `0 or 0.05 to 20 m/s^3`."""
        return self.text_in(self.unit, 1.0)

    def text_in(self, unit: str, factor: float) -> str:
        """The same in another unit, of which `factor` make one of its own."""
        words = (
            f"{low * factor:.6g}" if low == high else f"{low * factor:.6g} to {high * factor:.6g}"
            for low, high in self.spans
        )
        return " or ".join(words) + (f" {unit}" if unit else "")

    def in_unit(self, unit: str, up: float, down: float = 1.0) -> Quantity:
        """The same kind in a unit of which `up` over `down` make one of this; the same operations as the reader's."""
        spans = tuple((low * up / down, high * up / down) for low, high in self.spans)
        return Quantity(self.name, unit, spans, self.source)

    def _check(self, value: float) -> float:
        if self.holds(value):
            return value
        context = {"expected": f"{self.text()} ({self.name})", "quantity": self}
        raise PydanticCustomError(OUT_OF_RANGE, "{expected}", context)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:  # noqa: ANN401
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        node = handler(core)
        ranges = [{"minimum": low, "maximum": high} for low, high in self.spans]
        node.update(ranges[0] if len(ranges) == 1 else {"oneOf": ranges})
        node["quantity"] = self.name
        return node
