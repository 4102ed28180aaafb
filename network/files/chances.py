"""Kinds of figures of what is drawn and counted over days; `network.files.quantities` lists them with the others."""

from __future__ import annotations

from typing import Annotated, Final

from network.files.quantity import Quantity

SWEEP_DAYS: Final = Quantity("days of a sweep", "", ((1, 100_000),), "assumed: several nights")
PER_DAY: Final = Quantity("number in a day", "", ((0.0, 1000.0),), "assumed: about one a minute")
MTBF_H: Final = Quantity(
    "hours between failures", "h", ((0.1, 1e8),), "assumed: a broken thing; ten thousand years of service"
)
MTBF_KM: Final = Quantity(
    "kilometres between failures", "km", ((0.1, 1e8),), "assumed: a broken thing; a hundred trains' lives"
)
MTBF_OPERATIONS: Final = Quantity(
    "operations between failures", "", ((1.0, 1e9),), "assumed: each one fails; never in a life"
)
CONFIDENCE: Final = Quantity("confidence", "", ((0.5, 0.9999),), "assumed: less says nothing")
DRAWN_VALUE: Final = Quantity("drawn value", "", ((-1e12, 1e12),), "assumed: its key has a range")
LOG_SIGMA: Final = Quantity(
    "standard deviation of a logarithm",
    "",
    ((0.01, 3.0),),
    "assumed: a hundredth; from a twentieth to twentyfold",
)
PEOPLE_SIGMA: Final = Quantity(
    "scatter of people's times", "", ((0.0, 2.0),), "assumed: always the mean; a sevenfold is common"
)
PERSON_TIME: Final = Quantity(
    "time that a person takes", "s", ((0.0, 1800.0),), "assumed: half an hour for one act"
)
SHAPE: Final = Quantity(
    "shape of a distribution", "", ((0.1, 50.0),), "assumed: nearly all at once to nearly none scattered"
)
DELAY_FACTOR: Final = Quantity("factor of a delay", "", ((0.0, 100.0),), "assumed: none to a hundred times")
ROAD_VEHICLES: Final = Quantity(
    "road vehicles an hour", "", ((0.0, 5000.0),), "assumed: none; more than a road of four lanes takes"
)
ROAD_TIME: Final = Quantity(
    "time that a road vehicle waits or stands", "s", ((1.0, 7200.0),), "assumed: a moment to two hours"
)
APPROACH: Final = Quantity(
    "road before a crossing", "m", ((50.0, 5000.0),), "assumed: seven cars; queues end in a town"
)
GOOD_LOSS: Final = Quantity(
    "loss of a good link", "", ((0.0, 0.99),), "assumed: of what loses more than 99 of 100, nothing is good"
)
BIT_ERROR: Final = Quantity(
    "probability of a bit error",
    "",
    ((0.0, 0.5),),
    "at a half a link says nothing (capacity 1 - H(p), Shannon)",
)
LANES: Final = Quantity("lanes each way", "", ((1, 2),), "assumed: no branch line is crossed by a wider road")
STOP_LINE: Final = Quantity(
    "stop line to track", "m", ((2.5, 30.0),), "assumed: just clear of a train; a crossing at a sharp angle"
)

SweepDays = Annotated[int, SWEEP_DAYS]
PerDay = Annotated[float, PER_DAY]
MtbfH = Annotated[float, MTBF_H]
MtbfKm = Annotated[float, MTBF_KM]
MtbfOperations = Annotated[float, MTBF_OPERATIONS]
Confidence = Annotated[float, CONFIDENCE]
DrawnValue = Annotated[float, DRAWN_VALUE]
LogSigma = Annotated[float, LOG_SIGMA]
PeopleSigma = Annotated[float, PEOPLE_SIGMA]
PersonTime = Annotated[float, PERSON_TIME]
Shape = Annotated[float, SHAPE]
DelayFactor = Annotated[float, DELAY_FACTOR]
RoadVehicles = Annotated[float, ROAD_VEHICLES]
RoadTime = Annotated[float, ROAD_TIME]
ApproachM = Annotated[float, APPROACH]
StopLineM = Annotated[float, STOP_LINE]
GoodLoss = Annotated[float, GOOD_LOSS]
BitError = Annotated[float, BIT_ERROR]
Lanes = Annotated[int, LANES]
