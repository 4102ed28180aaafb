"""`[gnss]`: the satellite receivers of trains that carry one, what they err by and what they state of it.

Where the figures come from:
- 20 m that hold in a fail-safe way, and less than 3 m as what can become of it: Shift2Rail, demonstrators of fail-safe
  train positioning (rail-research.europa.eu, "Satellite positioning set to enhance train localisation").
- Under an open sky 3 m in the plane in 95 % of the time with satellite-based corrections (EGNOS open service, service
  definition): 1.2 m along one axis, if both err alike.
- How long errors last: 10 to 900 s of code multipath, 900 to 2700 s of the troposphere (tables of Gallon, Joerger and
  Pervan, NAVIGATION, after Joerger and Pervan 2016 and 2020).
- What such a receiver is for: Yamagata Railway's radio train control on GNSS and public mobile radio, without colour
  light signals or track circuits, in service from the fiscal year 2027 (tetsudo.com/news/3382).
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Final

from pydantic import Field, ValidationInfo, field_validator

from network.files.kinds import about
from network.files.quantities import (
    CorrelationTime,
    CorrelationWay,
    FixRate,
    PositionBound,
    ReceiverError,
    ReceiverLatency,
    Wait,
)
from network.files.toml_input import Record

SURE: Final = 5.0  # standard deviations that a protection level must hold: 6e-7 of all fixes are outside
SURE_OPEN: Final = 16.0  # of those under an open sky: four of them in a quarter, on which units count


class Correction(StrEnum):
    """What is done about a receiver's errors."""

    FAIL_SAFE = "fail_safe"  # what holds today
    AIM = "aim"  # what is aimed at


class GnssReceiver(Record):
    """`gnss.fail_safe`, `gnss.aim`: what a kind of receiver errs by along the track, and what it states of that."""

    sigma_m: Annotated[ReceiverError, about("standard deviation of the slow error, under an open sky")]
    noise_sigma_m: Annotated[ReceiverError, about("standard deviation of the noise of each fix")]
    multipath_sigma_m: Annotated[
        ReceiverError,
        about("standard deviation of the error by reflections, where part of the sky is hidden"),
    ]
    protection_m: Annotated[
        PositionBound,
        about(
            "protection level along the track that it states; at least 5 times all errors, 16 times the first two"
        ),
    ]

    @field_validator("protection_m")
    @classmethod
    def _covers(cls, protection_m: float, info: ValidationInfo) -> float:
        open_m = math.hypot(info.data.get("sigma_m", 0.0), info.data.get("noise_sigma_m", 0.0))
        least_m = max(SURE * math.hypot(open_m, info.data.get("multipath_sigma_m", 0.0)), SURE_OPEN * open_m)
        if protection_m < least_m:
            raise ValueError(f"at least {least_m:.2f}, by the errors beside it")
        return protection_m


FAIL_SAFE: Final = GnssReceiver(sigma_m=1.2, noise_sigma_m=0.3, multipath_sigma_m=3.0, protection_m=20.0)
AIM: Final = GnssReceiver(sigma_m=0.15, noise_sigma_m=0.05, multipath_sigma_m=0.4, protection_m=3.0)


class Gnss(Record):
    """`[gnss]`: receivers of the trains whose `sensors.carries` has `gnss`."""

    correction: Annotated[
        Correction, Field(strict=False), about("which of the two receivers below", "what holds today")
    ] = Correction.FAIL_SAFE
    rate_hz: Annotated[FixRate, about("fixes a second", "assumed: what receivers give without asking")] = 1.0
    latency_s: Annotated[
        ReceiverLatency,
        about("age of a fix when the unit receives it", "assumed: a position's computation"),
    ] = 0.2
    reacquisition_s: Annotated[
        Wait,
        about(
            "time without a fix after a tunnel or jamming",
            "assumed: 1 s of a hot start (u-blox MAX-M8Q), and until corrections and integrity are back",
        ),
    ] = 5.0
    time_constant_s: Annotated[
        CorrelationTime,
        about(
            "time constant of the slow errors: two thirds are gone after it",
            "assumed: between 10 s and 2700 s, see above",
        ),
    ] = 300.0
    multipath_way_m: Annotated[
        CorrelationWay,
        about("distance over which reflections change", "assumed: houses, trees and cuttings along a track"),
    ] = 80.0
    fail_safe: Annotated[
        GnssReceiver,
        about(
            "a receiver of today",
            "1.2 m: EGNOS, 3 m in 95 %; 20 m: Shift2Rail; noise and reflections assumed",
        ),
    ] = FAIL_SAFE
    aim: Annotated[
        GnssReceiver,
        about(
            "a future receiver, as aimed at",
            "3 m: Shift2Rail; errors assumed: somewhat beyond 0.12 m in 95 %, which QZSS states for CLAS on the move",
        ),
    ] = AIM

    @property
    def receiver(self) -> GnssReceiver:
        """The one that trains carry."""
        return self.fail_safe if self.correction is Correction.FAIL_SAFE else self.aim
