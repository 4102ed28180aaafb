"""Ways of trains from one place where they can stand to the next, as operators see them in the plan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from network.model import Position, SectionKind
from simulation.world.roster import Duty

_PLACES = (SectionKind.TRACK, SectionKind.PORTAL)


@dataclass(frozen=True, slots=True)
class Hop:
    """One such way: target `begin` to target `end` of a duty. `begins_in`: the section
    where it begins; `section_ids`: what lies beyond.

    `block`: the section between stations, empty within a station; `origin`, `destination`: stations, or portals of
    other lines; `after_block`: what of it lies beyond the block. `planned_s`: when the plan has it begin.
    """

    stock_id: str
    train: str
    duty: int
    begin: int
    end: int
    block: str
    origin: str
    destination: str
    begins_in: str
    section_ids: tuple[str, ...]
    after_block: tuple[str, ...]
    points: tuple[tuple[str, Position], ...]
    planned_s: float
    run_s: float

    @property
    def work(self) -> str:
        """In whose book it stands: the section's, or the station's."""
        return self.block or next(p for p in (self.destination, self.origin) if p)

    @property
    def ends_s(self) -> float:
        """When the plan has it end, s."""
        return self.planned_s + self.run_s

    @property
    def order(self) -> tuple[float, str]:
        """Its place in the plan."""
        return self.planned_s, self.train


class RunsThrough(ValueError):  # noqa: N818 - names what is so
    """A train runs through a station: substitute working has it stop at each."""


def hops_of(drawn: Mapping[str, tuple[Duty, ...]]) -> tuple[Hop, ...]:
    """All ways of a day, in the order of the plan. RunsThrough names the train and the station."""
    found = [
        hop
        for stock_id, duties in drawn.items()
        for index, duty in enumerate(duties)
        for hop in _hops(stock_id, index, duty)
    ]
    return tuple(sorted(found, key=lambda hop: hop.order))


def _hops(stock_id: str, index: int, duty: Duty) -> list[Hop]:
    mission = duty.mission
    spans_at = [mission.span_index(target.section_id) for target in mission.targets]
    stands = [i for i, at in enumerate(spans_at) if mission.spans[at].kind in _PLACES]
    found: list[Hop] = []
    for begin, end in pairwise(stands):
        spans = mission.spans[spans_at[begin] + 1 : spans_at[end] + 1]
        through = [span.section_id for span in spans[:-1] if span.kind in _PLACES]
        blocks = [i for i, span in enumerate(spans) if span.kind is SectionKind.BETWEEN]
        if through or len(blocks) > 1:
            raise RunsThrough(f"train {duty.train.number} runs through {(through or ['a station'])[0]}")
        origin, destination = mission.targets[begin], mission.targets[end]
        begins_s = next((s for s in (origin.departure_s, origin.arrival_s) if s is not None), duty.enter_s)
        ends_s = destination.arrival_s if destination.arrival_s is not None else begins_s
        found.append(
            Hop(
                stock_id,
                duty.train.number,
                index,
                begin,
                end,
                spans[blocks[0]].section_id if blocks else "",
                origin.place_id if blocks else origin.station_id or "",
                destination.place_id if blocks else destination.station_id or "",
                mission.targets[begin].section_id,
                tuple(span.section_id for span in spans),
                tuple(span.section_id for span in spans[blocks[0] + 1 :]) if blocks else (),
                tuple((points, position) for span in spans for points, position, _ in span.points),
                begins_s,
                max(ends_s - begins_s, 0.0),
            )
        )
    return found
