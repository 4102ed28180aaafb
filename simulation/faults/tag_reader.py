"""Faults of tags. A tag that is not read is not read, whatever else is wrong with it."""

from __future__ import annotations

from pydantic import Field

from network.files.quantities import TagId
from simulation.faults.fault import Fault


class TagFault(Fault[int | None]):
    """The id read where a tag lies; None: nothing is read."""

    aims_at = "tag"
    changes = "tag"
    target: str

    def base(self) -> int | None:
        return int(self.target)


class Miss(TagFault):
    """The tag is not read."""

    kind = "miss"

    def applied_to(self, _read_id: int | None) -> None:
        return None


class WrongId(TagFault):
    """The tag is read with the id of another."""

    kind = "wrong_id"
    id: TagId = Field(description="the id read")

    def applied_to(self, read_id: int | None) -> int | None:
        return None if read_id is None else self.id
