"""`[line_signals]`: a line as it was, with line signals and no units: its equipment, and what people did that day."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field

from network.files.kinds import TABLES_MAX, TEXTS_MAX, TimeOfDay, about
from network.files.names import Identifier, Prose
from network.files.quantities import SpeedKmh
from network.files.toml_input import Record
from network.model import Direction
from network.units import mps


class SignalDeed(StrEnum):
    """What people do at signals."""

    SET = "set"  # pull the signal's lever: it clears once the machine lets it
    LEVER = "lever"  # a direction lever
    RELEASE_LEVER = "release_lever"
    SUBSTITUTE = "substitute"  # the substitute aspect, past what the machine lets
    SEND_OFF = "send_off"  # a driver is told to pass the signal at stop


class OneWay(Record):
    """What is for trains of one direction alone."""

    id: Annotated[Identifier, about("its name")]
    runs: Annotated[Literal["down", "up"], about("for trains of this direction")]

    @property
    def direction(self) -> Direction:
        """For trains of which direction."""
        return Direction.DOWN if self.runs == "down" else Direction.UP


class LineSignal(OneWay):
    """`[[line_signals.signal]]`: a main signal that lets a train into, or further into, a section between stations."""

    at: Annotated[str, about("the track at whose end it stands (its section), or the halt that it stands at")]
    block: Annotated[str, about("the section between stations that it lets into, or stands in")]
    automatic: Annotated[
        bool,
        about(
            "its lever is pulled by the train that comes near (approach control), else by people",
            "people do it",
        ),
    ] = False


class DirectionLever(OneWay):
    """`[[line_signals.lever]]`: it keeps sections for one direction, signals of the other stay at stop (方向てこ)."""

    blocks: Annotated[
        tuple[str, ...], Field(strict=False, min_length=1, max_length=TEXTS_MAX), about("of which sections")
    ]


class DepartureDetector(Record):
    """`[[line_signals.detector]]`: a train that leaves past a signal at stop puts others to stop (誤出発検知)."""

    signal: Annotated[str, about("the signal that it watches")]
    holds: Annotated[
        tuple[str, ...],
        Field(strict=False, min_length=1, max_length=TEXTS_MAX),
        about("the signals that it puts and keeps at stop"),
    ]
    works: Annotated[bool, about("false: it notes the train, and puts nothing to stop", "it does")] = True


class SignalAct(Record):
    """`[[line_signals.act]]`: what somebody did, and when."""

    at_s: Annotated[TimeOfDay, Field(alias="at"), about("when")]
    who: Annotated[Prose, about("who, as the journal has it")]
    does: Annotated[SignalDeed, Field(strict=False), about("what")]
    target: Annotated[str, about("the signal; for a direction lever, that")]


class LineSignals(Record):
    """`[line_signals]`: trains run by line signals, their units cut out, from the beginning to the end of the day."""

    signal: Annotated[
        tuple[LineSignal, ...], Field(strict=False, min_length=1, max_length=TABLES_MAX), about("its signals")
    ]
    lever: Annotated[
        tuple[DirectionLever, ...], Field(strict=False, max_length=TABLES_MAX), about("direction levers")
    ] = ()
    detector: Annotated[
        tuple[DepartureDetector, ...],
        Field(strict=False, max_length=TABLES_MAX),
        about("wrong-departure detectors"),
    ] = ()
    act: Annotated[
        tuple[SignalAct, ...],
        Field(strict=False, max_length=TABLES_MAX),
        about("what people did, in any order"),
    ] = ()
    speed_kmh: Annotated[
        SpeedKmh | None, about("drivers run no faster; left out: as fast as the line allows")
    ] = None

    def speed_mps(self, line_mps: float) -> float:
        """The most that a train runs, m/s, on a line that allows so much."""
        return line_mps if self.speed_kmh is None else mps(self.speed_kmh)
