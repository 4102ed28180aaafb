"""`[substitute]`: what people do when the block manager is off, and which steps of it they leave out."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from network.files.kinds import TABLES_MAX, about
from network.files.quantities import SpeedKmh, Wait
from network.files.toml_input import Record
from network.units import mps
from simulation.procedure import Regime, WorkingStep


class LeftOutStep(Record):
    """`[[substitute.left_out]]`: a step that people leave out, and go on as though it had been done."""

    step: Annotated[WorkingStep, Field(strict=False), about("the step, of docs/substitute-working.md")]
    block: Annotated[str, about("in which section between stations, or station; left out: everywhere")] = ""
    train: Annotated[str, about("for which train; left out: for every one")] = ""

    def holds(self, step: WorkingStep, block: str, train: str) -> bool:
        """Whether it is this step here."""
        return self.step is step and self.block in ("", block) and self.train in ("", train)


class Substitute(Record):
    """`[substitute]`: while the block manager is off, trains run by substitute working, on the pilot's leave.

    Needs `[people] react`: once it has ended, staff cut the units in and restore the picture.
    """

    regime: Annotated[
        Regime,
        Field(strict=False),
        about(
            "who agrees with whom: operators by telephone, the pilot of a train that comes back, the dispatcher"
        ),
    ] = Regime.TELEPHONE
    of_block: Annotated[
        dict[str, Annotated[Regime, Field(strict=False)]],
        about("another one by section between stations", "none: the same in all"),
    ] = Field(default_factory=dict)
    staffed: Annotated[
        tuple[str, ...],
        Field(strict=False),
        about(
            "stations that have an operator; to others one has to come (`people.reach_s`)",
            "none; portals lead to lines that have one",
        ),
    ] = ()
    speed_kmh: Annotated[
        SpeedKmh,
        about(
            "a train driven by hand runs no faster",
            "assumed: 45 km/h, the most that this project allows on sight",
        ),
    ] = 45.0
    ask_before_s: Annotated[
        Wait,
        about(
            "a train is asked for so long before its time", "assumed: what asking, points and boarding take"
        ),
    ] = 300.0
    left_out: Annotated[
        tuple[LeftOutStep, ...],
        Field(strict=False, max_length=TABLES_MAX),
        about("steps that people leave out"),
    ] = ()

    def regime_of(self, block: str) -> Regime:
        """By which working a section between stations is worked."""
        return self.of_block.get(block, self.regime)

    @property
    def speed_mps(self) -> float:
        """The most that a train runs by hand, m/s."""
        return mps(self.speed_kmh)
