"""Faults of tags (地上子): one that is not read reads as nothing, whatever else is wrong with it."""

from __future__ import annotations

from pydantic import Field

from simulation.faults.fault import Fault, Names, World


class TagFault(Fault[int | None]):
    """The id read where a tag lies; None: nothing is read."""

    aims_at = "tag"
    changes = "tag"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return names.tags

    def base(self, _world: World) -> int | None:
        return int(self.target)

    def put(self, world: World, read_id: int | None) -> None:
        tag_id = int(self.target)
        if read_id == tag_id:
            world.trains.tag_faults.pop(tag_id, None)
        else:
            world.trains.tag_faults[tag_id] = read_id


class Miss(TagFault):
    """The tag is not read."""

    kind = "miss"

    def over(self, _read_id: int | None) -> None:
        return None


class WrongId(TagFault):
    """The tag reads as another."""

    kind = "wrong_id"
    id: int = Field(ge=1, le=65535, description="the id read")

    def over(self, read_id: int | None) -> int | None:
        return None if read_id is None else self.id
