"""Every kind of figure that a file may have, with its range and what that rests on; no key has a range of its own.

The ends are real extremes where one is known, rounded outwards, or `assumed: why`. They tell nonsense from figures;
what is sensible on one line is for its author.
"""

from __future__ import annotations

from typing import Annotated, Final

from network.files import chances
from network.files.quantity import Quantity

_TRAIN: Final = (
    "heaviest and longest train: Mount Newman ore line, 21 June 2001, 99 734 t, 7353 m, 682 wagons, 8 units"
)
_CAR: Final = "least: the test car of Oda, 3.3.2"
_SPEED: Final = "greatest on rails: LGV Est, 3 April 2007, 574.8 km/h"
_BRAKE: Final = "greatest: hazard brake of a tram with track brakes, about 3 m/s^2 (EN 13452-1)"

# what a train is --------------------------------------------------------------------------------------------
TRAIN_LENGTH: Final = Quantity("length of a train", "m", ((1.0, 7500.0),), f"{_CAR}, 1.244 m; {_TRAIN}")
MASS: Final = Quantity("mass of a train", "t", ((0.05, 100_000.0),), f"{_CAR}, 83 kg; {_TRAIN}")
LOAD: Final = Quantity("load of a train", "t", ((0.0, 100_000.0),), _TRAIN)
ROTATING_MASS: Final = Quantity(
    "rotating mass",
    "",
    ((0.0, 0.5),),
    "assumed: share of the mass; an electric locomotive alone has about 0.3",
)
FORCE: Final = Quantity(
    "tractive force",
    "kN",
    ((0.01, 7000.0),),
    "least: a model car; greatest: eight AC6000CW of the heaviest train, 836 kN each",
)
BRAKE_FORCE: Final = Quantity("electric brake force", "kN", ((0.0, 7000.0),), "as tractive force; 0: none")
POWER: Final = Quantity(
    "tractive power",
    "kW",
    ((0.01, 40_000.0),),
    "least: a model car; greatest: eight AC6000CW, 4.4 MW each; Shen 24 has 28.8 MW",
)
BRAKE_POWER: Final = Quantity("electric brake power", "kW", ((0.0, 40_000.0),), "as tractive power; 0: none")
AUXILIARY_POWER: Final = Quantity(
    "auxiliary power",
    "kW",
    ((0.0, 5000.0),),
    "assumed: several times the train supply of the longest passenger trains, about 1 MW",
)
RESISTANCE: Final = Quantity(
    "running resistance by weight", "N/kN", ((0.0, 50.0),), "assumed: plain bearings at a start have about 20"
)
RESISTANCE_SLOPE: Final = Quantity(
    "running resistance by weight and speed",
    "N/kN per km/h",
    ((0.0, 1.0),),
    "assumed: ten times and more of any published formula",
)
AIR_RESISTANCE: Final = Quantity(
    "air resistance",
    "N per (km/h)^2",
    ((0.0, 100.0),),
    "assumed: drag area of 2000 m^2, beyond that of the longest train",
)
CURVE_RESISTANCE: Final = Quantity(
    "curve resistance",
    "m",
    ((0.0, 2000.0),),
    "assumed: permille times radius; 600 to 800 in published formulas",
)
SPEED: Final = Quantity("speed", "km/h", ((1.0, 575.0),), f"least assumed; {_SPEED}")
SPEED_FROM_0: Final = Quantity("speed from a stand", "km/h", ((0.0, 575.0),), _SPEED)
SPEED_MARGIN: Final = Quantity("speed margin", "km/h", ((0.0, 36.0),), "assumed: more is no margin")
SIGHT_SPEED: Final = Quantity(
    "speed on sight", "km/h", ((1.0, 45.0),), "assumed: 15 km/h in Japan, at most 40 km/h in Germany"
)
DECELERATION: Final = Quantity("deceleration", "m/s^2", ((0.01, 3.5),), f"least: the first notch; {_BRAKE}")
JERK: Final = Quantity(
    "jerk limit",
    "m/s^3",
    ((0.0, 0.0), (0.05, 20.0)),
    "assumed: four times that of Oda, 3.2.3, 4.65 m/s^3; 0: none",
)
DEAD_TIME: Final = Quantity(
    "dead time", "s", ((0.0, 6.0),), "the ring of commands holds 63 steps of 0.1 s; Oda, 3.2.3 has 1 s"
)
LAG: Final = Quantity(
    "lag", "s", ((0.0, 30.0),), "greatest: filling of brake cylinders in position G, 18 to 30 s (UIC 540)"
)
BATTERY_ENERGY: Final = Quantity(
    "energy of a traction battery",
    "kWh",
    ((1.0, 10_000.0),),
    "greatest assumed: twice the battery of a locomotive of 2.4 MWh, twice over; least: a cart",
)
BATTERY_POWER: Final = Quantity(
    "power of a traction battery or charger",
    "kW",
    ((1.0, 20_000.0),),
    "greatest: as the power at the rim; least assumed",
)
VOLTAGE: Final = Quantity(
    "direct voltage", "V", ((24.0, 4000.0),), "24 V of a starter battery; 3 kV wires may have 3.9 kV"
)
CURRENT: Final = Quantity("direct current", "A", ((1.0, 10_000.0),), "assumed: a whole train on 1.5 kV")
RESISTANCE_OHM: Final = Quantity(
    "internal resistance of a battery", "ohm", ((0.0, 10.0),), "assumed: a worn pack of small cells"
)
CONSUMPTION: Final = Quantity(
    "energy a kilometre", "kWh/km", ((0.0, 100.0),), "assumed: a heavy freight train on battery"
)
EFFICIENCY: Final = Quantity("efficiency", "", ((0.05, 1.0),), "least: a steam locomotive, 5 to 10 %")
EFFICIENCY_OR_0: Final = Quantity("efficiency of regeneration", "", ((0.0, 1.0),), "0: nothing is given back")
MOTOR_LOSS: Final = Quantity(
    "loss of a motor and its inverter",
    "kW",
    ((0.0, 300.0),),
    "less than none would be more than 100 %; greatest assumed: a fifth of the largest motors, about 1.6 MW",
)
GEAR_LOSS: Final = Quantity(
    "loss of a gear",
    "",
    ((0.0, 0.1),),
    "assumed: share of what it passes on; a stage of spur gears loses 1 to 3 %",
)
ADHESION: Final = Quantity(
    "adhesion coefficient",
    "",
    ((0.05, 0.6),),
    "least: leaves and oil; greatest: dry sanded rail (Curtius and Kniffler: 0.33 at rest)",
)
ADHESION_SLOPE: Final = Quantity(
    "fall of adhesion with speed", "s/m", ((0.0, 0.2),), "assumed: six times that of the shipped trains"
)
WHEEL_DIAMETER: Final = Quantity(
    "diameter of a wheel",
    "mm",
    ((50.0, 3000.0),),
    f"{_CAR}, 102 mm; greatest: driving wheels of 9 feet, Bristol and Exeter, 1853",
)
CARS: Final = Quantity("number of cars", "", ((1, 700),), _TRAIN)
MOTORS: Final = Quantity("number of motors", "", ((1, 200),), "assumed: a 16-car Shinkansen has 56 to 64")
PULSES: Final = Quantity(
    "pulses of a tachometer",
    "",
    ((1, 10_000),),
    f"assumed: ten times that of the {_CAR.removeprefix('least: the ')}",
)

# what a line is ---------------------------------------------------------------------------------------------
KILOMETRAGE: Final = Quantity(
    "kilometrage",
    "km",
    ((-100.0, 10_000.0),),
    "longest line: Moscow to Vladivostok, 9288 km; before 0 assumed",
)
GRADIENT: Final = Quantity(
    "gradient", "permille", ((-150.0, 150.0),), "steepest by adhesion: trams of Lisbon, 138 permille"
)
RADIUS: Final = Quantity(
    "radius of a curve",
    "m",
    ((-100_000.0, -10.0), (10.0, 100_000.0)),
    "least: trams of Lisbon, 11 m; flatter is straight",
)
TRANSITION: Final = Quantity(
    "length of a transition", "m", ((0.0, 1000.0),), "assumed: about twice those of high-speed lines"
)
CANT: Final = Quantity("cant", "mm", ((0.0, 200.0),), "Tokaido Shinkansen: 200 mm")
COORDINATE: Final = Quantity("place on a map", "m", ((-1e7, 1e7),), "a quarter of the meridian")
HEIGHT: Final = Quantity(
    "height above the sea", "m", ((-500.0, 6000.0),), "Tanggula pass, 5072 m; Seikan tunnel, -240 m"
)
BEARING: Final = Quantity("bearing", "degrees", ((-360.0, 360.0),), "a whole turn either way")
OFFSET: Final = Quantity("lateral offset", "m", ((-500.0, 500.0),), "assumed: the widest yards")
CROSSING_WIDTH: Final = Quantity(
    "extent of a level crossing along the track", "m", ((0.5, 100.0),), "assumed: a path; the widest roads"
)
OVERLAP: Final = Quantity(
    "overlap beyond a stop", "m", ((0.0, 400.0),), "assumed: twice the 200 m that main lines keep"
)
THROW_TIME: Final = Quantity(
    "throw of points",
    "s",
    ((0.1, 120.0),),
    "assumed: motors take 1 to 10 s, cranking by hand a minute or two",
)
TAG_ID: Final = Quantity(
    "id of a tag", "", ((1, 0xFFFF),), "Sugiyama, 6.1.3: 24 bits hold the id and its CRC-8"
)
TAGS_WRONG: Final = Quantity(
    "number of tags that are wrong together", "", ((0, 4),), "assumed: a station has about five"
)

# what happens on it -----------------------------------------------------------------------------------------
WAIT: Final = Quantity(
    "time of an act",
    "s",
    ((0.0, 3600.0),),
    "assumed: what people and rules wait for in running, at most an hour",
)
REACTION: Final = Quantity("reaction time", "s", ((0.0, 30.0),), "assumed: as a lag")
DELAY: Final = Quantity(
    "delay of a train", "min", ((0.0, 1440.0),), "assumed: what is a day late is a train of another day"
)
OVERTAKEN: Final = Quantity(
    "trains let on before another", "", ((1, 1000),), "assumed: as many as a dense day has; 0: nobody waits"
)
BLOCKS: Final = Quantity("blocks of a section", "", ((1, 100),), "assumed: 80 stand for moving blocks")
HANDLE: Final = Quantity("notch of a handle", "", ((-99, 99),), "assumed: as many notches as no handle has")
RUN_LIMIT: Final = Quantity("limit of a run", "s", ((1.0, 259_200.0),), "assumed: three days")
DRILL_TIME: Final = Quantity("time in a drill", "s", ((0.0, 259_200.0),), "as the limit of a run")
DURATION: Final = Quantity("duration in a drill", "s", ((0.1, 259_200.0),), "a step; as the limit of a run")
PACE: Final = Quantity("time of an entry by hand", "s", ((0.0, 600.0),), "assumed: ten minutes for one word")
LATER: Final = Quantity("shift of a train", "s", ((-86_400, 86_400),), "a day")
CLOCK_OFFSET: Final = Quantity("clock offset", "s", ((-86_400.0, 86_400.0),), "a day")
CLOCK_DRIFT: Final = Quantity(
    "clock drift", "ppm", ((-1e5, 1e5),), "assumed: a tenth; a quartz has 100 ppm at most"
)
TIME_OFFSET: Final = Quantity(
    "offset of a dead time or lag", "s", ((-2.0, 2.0),), "range of Oda's learning, section 3.4: 0 to 2 s"
)
TIME_SPREAD: Final = Quantity("spread of a dead time or lag", "s", ((0.0, 2.0),), "as the offset")
TELEGRAM_DELAY: Final = Quantity(
    "delay of a telegram", "s", ((0.1, 60.0),), "a step, which lock-step needs; a minute assumed"
)
ADDED_DELAY: Final = Quantity(
    "delay added to a telegram", "s", ((0.0, 600.0),), "assumed: ten minutes in a queue"
)
LINK_RATE: Final = Quantity(
    "rate at which a link changes", "1/s", ((0.0, 100.0),), "assumed: ten times a step of 0.1 s"
)
FRAME_RATE: Final = Quantity("rate of frames", "Hz", ((0.1, 10.0),), "the camera's own, 10 Hz")
GAIN: Final = Quantity("control gain", "1/s", ((0.01, 10.0),), "greatest: a step of 0.1 s; least assumed")
INTEGRAL_GAIN: Final = Quantity(
    "gain of an integral", "1/s^2", ((0.0, 10.0),), "as a control gain, over a second; 0: none"
)
DERIVATIVE_GAIN: Final = Quantity(
    "gain of a derivative", "", ((0.0, 10.0),), "as a control gain, times a second; 0: none"
)
ACCELERATION_BAND: Final = Quantity(
    "band about an acceleration", "m/s^2", ((0.0, 1.0),), "assumed: several notches of any train"
)
OWN_WAY: Final = Quantity("way beyond a portal", "km", ((0.0, 1000.0),), "assumed: a day of a local set")
CHARGE_TIME: Final = Quantity("time of charging", "min", ((0.0, 1440.0),), "a day")
DISTANCE: Final = Quantity(
    "distance to a place", "m", ((0.0, 10_000.0),), "assumed: beyond any section of a branch line"
)
POSITION_BOUND: Final = Quantity(
    "bound of a position", "m", ((0.01, 1000.0),), "assumed: a centimetre, a kilometre"
)
READ_ERROR: Final = Quantity(
    "error of a tag reader", "m", ((0.0, 10.0),), "assumed: far beyond the field of a reader"
)
MARKER_ERROR: Final = Quantity(
    "place of a marker", "m", ((0.0, 0.05),), "greatest: what units reckon with; more is a fault of the map"
)
VISIBILITY: Final = Quantity(
    "visibility", "m", ((1.0, 100_000.0),), "least: a whiteout; greatest assumed: air without dust"
)
WHEEL_ERROR: Final = Quantity(
    "error of a wheel", "", ((0.0, 0.1),), "assumed: wear from new to last, 860 to 780 mm is 9 %"
)
FIX_RATE: Final = Quantity(
    "rate of a receiver's fixes", "Hz", ((1.0, 10.0),), "a step of 0.1 s; least assumed"
)
RECEIVER_ERROR: Final = Quantity(
    "error of a satellite receiver",
    "m",
    ((0.0, 100.0),),
    "assumed: as when signals were degraded, until 2000",
)
RECEIVER_BIAS: Final = Quantity(
    "fault of a satellite receiver", "m", ((-10_000.0, 10_000.0),), "assumed: as a distance to a place"
)
RECEIVER_LATENCY: Final = Quantity(
    "latency of a satellite receiver",
    "s",
    ((0.0, 3.0),),
    "what units keep of the way run; some tenths are usual",
)
CORRELATION_TIME: Final = Quantity(
    "time constant of an error",
    "s",
    ((1.0, 7200.0),),
    "assumed: two hours; the troposphere's is at most 2700 s",
)
CORRELATION_WAY: Final = Quantity(
    "way over which an error changes", "m", ((1.0, 10_000.0),), "assumed: as a distance to a place"
)
YAW_RATE: Final = Quantity(
    "yaw rate",
    "deg/s",
    ((0.0, 125.0),),
    "full scale of the ASM330LHH in its finest range; a train turns by 10 deg/s at the very most",
)
SAMPLE_RATE: Final = Quantity(
    "rate of a sensor's samples", "Hz", ((10.0, 100_000.0),), "least: one a step; greatest assumed"
)
BODY_FREQUENCY: Final = Quantity(
    "natural frequency of a car body", "Hz", ((0.3, 5.0),), "assumed: soft to stiff secondary springs"
)
BODY_DAMPING: Final = Quantity(
    "damping of a car body", "", ((0.05, 2.0),), "assumed: as a share of the critical one"
)
MATCHED_WAY: Final = Quantity(
    "way that is matched with a map", "m", ((5.0, 800.0),), "greatest: what units keep; least assumed"
)
SEARCHED_WAY: Final = Quantity(
    "way that is searched for a match",
    "m",
    ((5.0, 400.0),),
    "greatest: what units have room for; least assumed",
)
CURVATURE_ERROR: Final = Quantity(
    "error of a curvature", "1/m", ((1e-6, 0.01),), "greatest: a curve of 100 m; least assumed"
)
SIGMAS: Final = Quantity(
    "number of standard deviations", "", ((1.0, 10.0),), "assumed: a third of all, or none in an age"
)
NOISE_FACTOR: Final = Quantity(
    "factor of noise", "", ((0.0, 1000.0),), "assumed: none, or a sensor that is broken"
)
CREEP: Final = Quantity(
    "creep of a wheel",
    "",
    ((0.0, 0.02),),
    "greatest: creep at which steel wheels on rails have reached full adhesion, 1 to 2 % on dirty rails",
)
CONICITY: Final = Quantity(
    "slope of a tread", "", ((0.0, 0.5),), "greatest: equivalent conicity of badly worn treads, about 0.5"
)
FLANGEWAY: Final = Quantity(
    "play of a wheelset", "m", ((0.0, 0.03),), "assumed: a gauge widened by 30 mm has it all on one side"
)
DAYS: Final = Quantity(
    "number of days", "", ((1, 60),), "assumed: what a train needs to learn is a few weeks"
)
SEED: Final = Quantity("seed", "", ((0, 2**63 - 1),), "what 63 bits hold")

# shares and factors ------------------------------------------------------------------------------------------
SHARE: Final = Quantity("share", "", ((0.0, 1.0),), "by its meaning")
SHARE_ABOVE_0: Final = Quantity(
    "share of something that is there",
    "",
    ((0.01, 1.0),),
    "least assumed: a hundredth; eight of 690 vehicles have the motors",
)
PROBABILITY: Final = Quantity("probability", "", ((0.0, 1.0),), "by its meaning")
SPREAD_SHARE: Final = Quantity("spread of a share", "", ((0.0, 0.5),), "more would pass 0 or 1")
SIGMA: Final = Quantity("standard deviation of a factor", "", ((0.0, 0.3),), "three of them reach nearly 0")
BRAKE_FACTOR: Final = Quantity(
    "factor of a brake", "", ((0.05, 2.0),), "assumed: pads that are nearly gone, or twice as good"
)
WHEEL_FACTOR: Final = Quantity(
    "factor of a wheel", "", ((0.9, 1.1),), "a new wheel of 860 mm against one worn to 780 mm, either way"
)
SLOWNESS: Final = Quantity("factor of a throw", "", ((1.0, 100.0),), "assumed: a hundred times as slow")
READING_FACTOR: Final = Quantity("factor of a reading", "", ((0.0, 10.0),), "assumed: ten times too much")
BIT_ERROR_FACTOR: Final = Quantity(
    "factor of bit errors", "", ((0.0, 10_000.0),), "assumed: from Sugiyama, table 7, to nearly every bit"
)
STRETCH: Final = Quantity(
    "factor of a running time", "", ((0.1, 10.0),), "assumed: ten times as fast or slow"
)

ALL: Final[tuple[Quantity, ...]] = tuple(
    value
    for name, value in (globals() | vars(chances)).items()
    if name.isupper() and isinstance(value, Quantity)
)
BY_NAME: Final = {quantity.name: quantity for quantity in ALL}

TrainLength = Annotated[float, TRAIN_LENGTH]
MassKg = Annotated[float, MASS.in_unit("kg", 1e3)]
LoadKg = Annotated[float, LOAD.in_unit("kg", 1e3)]
RotatingMass = Annotated[float, ROTATING_MASS]
ForceN = Annotated[float, FORCE.in_unit("N", 1e3)]
BrakeForceN = Annotated[float, BRAKE_FORCE.in_unit("N", 1e3)]
PowerW = Annotated[float, POWER.in_unit("W", 1e3)]
BrakePowerW = Annotated[float, BRAKE_POWER.in_unit("W", 1e3)]
AuxiliaryPowerW = Annotated[float, AUXILIARY_POWER.in_unit("W", 1e3)]
Resistance = Annotated[float, RESISTANCE]
ResistanceSlope = Annotated[float, RESISTANCE_SLOPE]
AirResistance = Annotated[float, AIR_RESISTANCE]
CurveResistance = Annotated[float, CURVE_RESISTANCE]
SpeedKmh = Annotated[float, SPEED]
SpeedMps = Annotated[float, SPEED.in_unit("m/s", 1.0, 3.6)]
SpeedFrom0Kmh = Annotated[float, SPEED_FROM_0]
SpeedFrom0Mps = Annotated[float, SPEED_FROM_0.in_unit("m/s", 1.0, 3.6)]
SpeedMarginMps = Annotated[float, SPEED_MARGIN.in_unit("m/s", 1.0, 3.6)]
SightSpeedMps = Annotated[float, SIGHT_SPEED.in_unit("m/s", 1.0, 3.6)]
Deceleration = Annotated[float, DECELERATION]
Jerk = Annotated[float, JERK]
DeadTime = Annotated[float, DEAD_TIME]
Lag = Annotated[float, LAG]
BatteryEnergyJ = Annotated[float, BATTERY_ENERGY.in_unit("J", 3.6e6)]
BatteryPowerW = Annotated[float, BATTERY_POWER.in_unit("W", 1e3)]
BatteryPowerKw = Annotated[float, BATTERY_POWER]
HeatingKw = Annotated[float, AUXILIARY_POWER]
VoltageV = Annotated[float, VOLTAGE]
CurrentA = Annotated[float, CURRENT]
ResistanceOhm = Annotated[float, RESISTANCE_OHM]
Consumption = Annotated[float, CONSUMPTION]
Efficiency = Annotated[float, EFFICIENCY]
EfficiencyOr0 = Annotated[float, EFFICIENCY_OR_0]
MotorLossW = Annotated[float, MOTOR_LOSS.in_unit("W", 1e3)]
GearLoss = Annotated[float, GEAR_LOSS]
Adhesion = Annotated[float, ADHESION]
AdhesionSlope = Annotated[float, ADHESION_SLOPE]
WheelDiameterM = Annotated[float, WHEEL_DIAMETER.in_unit("m", 1.0, 1e3)]
Cars = Annotated[int, CARS]
Motors = Annotated[int, MOTORS]
Pulses = Annotated[int, PULSES]
Kilometrage = Annotated[float, KILOMETRAGE]
GradientPermille = Annotated[float, GRADIENT]
Radius = Annotated[float, RADIUS]
Transition = Annotated[float, TRANSITION]
CantMm = Annotated[float, CANT]
Coordinate = Annotated[float, COORDINATE]
Height = Annotated[float, HEIGHT]
Bearing = Annotated[float, BEARING]
Offset = Annotated[float, OFFSET]
CrossingWidth = Annotated[float, CROSSING_WIDTH]
OverlapM = Annotated[float, OVERLAP]
ThrowTime = Annotated[float, THROW_TIME]
TagId = Annotated[int, TAG_ID]
TagsWrong = Annotated[int, TAGS_WRONG]
Wait = Annotated[float, WAIT]
DelayMin = Annotated[float, DELAY]
Overtaken = Annotated[int, OVERTAKEN]
BlockCount = Annotated[int, BLOCKS]
Handle = Annotated[int, HANDLE]
Reaction = Annotated[float, REACTION]
RunLimit = Annotated[float, RUN_LIMIT]
DrillTime = Annotated[float, DRILL_TIME]
Duration = Annotated[float, DURATION]
Pace = Annotated[float, PACE]
ClockOffset = Annotated[float, CLOCK_OFFSET]
Later = Annotated[int, LATER]
ClockDrift = Annotated[float, CLOCK_DRIFT]
TimeOffset = Annotated[float, TIME_OFFSET]
TimeSpread = Annotated[float, TIME_SPREAD]
TelegramDelay = Annotated[float, TELEGRAM_DELAY]
AddedDelay = Annotated[float, ADDED_DELAY]
LinkRate = Annotated[float, LINK_RATE]
FrameRate = Annotated[float, FRAME_RATE]
Gain = Annotated[float, GAIN]
IntegralGain = Annotated[float, INTEGRAL_GAIN]
DerivativeGain = Annotated[float, DERIVATIVE_GAIN]
AccelerationBand = Annotated[float, ACCELERATION_BAND]
Distance = Annotated[float, DISTANCE]
OwnWay = Annotated[float, OWN_WAY]
ChargeTime = Annotated[float, CHARGE_TIME]
PositionBound = Annotated[float, POSITION_BOUND]
ReadError = Annotated[float, READ_ERROR]
MarkerError = Annotated[float, MARKER_ERROR]
VisibilityM = Annotated[float, VISIBILITY]
WheelError = Annotated[float, WHEEL_ERROR]
FixRate = Annotated[float, FIX_RATE]
ReceiverError = Annotated[float, RECEIVER_ERROR]
ReceiverBias = Annotated[float, RECEIVER_BIAS]
ReceiverLatency = Annotated[float, RECEIVER_LATENCY]
CorrelationTime = Annotated[float, CORRELATION_TIME]
CorrelationWay = Annotated[float, CORRELATION_WAY]
YawRateDegps = Annotated[float, YAW_RATE]
SampleRate = Annotated[float, SAMPLE_RATE]
BodyFrequency = Annotated[float, BODY_FREQUENCY]
BodyDamping = Annotated[float, BODY_DAMPING]
MatchedWay = Annotated[float, MATCHED_WAY]
SearchedWay = Annotated[float, SEARCHED_WAY]
CurvatureError = Annotated[float, CURVATURE_ERROR]
Sigmas = Annotated[float, SIGMAS]
NoiseFactor = Annotated[float, NOISE_FACTOR]
Creep = Annotated[float, CREEP]
Conicity = Annotated[float, CONICITY]
Flangeway = Annotated[float, FLANGEWAY]
Days = Annotated[int, DAYS]
Seed = Annotated[int, SEED]
Share = Annotated[float, SHARE]
ShareAbove0 = Annotated[float, SHARE_ABOVE_0]
Probability = Annotated[float, PROBABILITY]
SpreadShare = Annotated[float, SPREAD_SHARE]
Sigma = Annotated[float, SIGMA]
BrakeFactor = Annotated[float, BRAKE_FACTOR]
WheelFactor = Annotated[float, WHEEL_FACTOR]
Slowness = Annotated[float, SLOWNESS]
ReadingFactor = Annotated[float, READING_FACTOR]
BitErrorFactor = Annotated[float, BIT_ERROR_FACTOR]
Stretch = Annotated[float, STRETCH]
