"""The tables of a scenario that a run reads as they are: one class each, for the file and for the run, and their list.

Ranges are those of the kinds in `network.files.kinds`; what a key means and where its default comes from stands
with it, and `docs/files/scenario.md` is made from here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from network.files import quantities
from network.files.kinds import about
from network.files.part_of_day import PartOfDay
from network.files.toml_input import Record
from onboard.driving.laws.settings import LawTables
from onboard.driving.planner.wish import Planning
from onboard.driving_settings import Driving
from onboard.duty_parameters import ReleaseRule
from onboard.unit_records import UnitParameters
from radio.air import AirParameters
from simulation.battery_settings import BatterySettings
from simulation.gnss_settings import Gnss
from simulation.late.settings import Late
from simulation.line_signals_settings import LineSignals
from simulation.people import People
from simulation.scatter import ScatterSettings
from simulation.sensor_settings import Beacons, Curvature, Lidar
from simulation.substitute_settings import Substitute
from wayside.config import DispatcherMeans, OrderRule, ReentryMode


class PositionSensor(StrEnum):
    """What trains may carry to know where they are, beside wheels and slide protection (cameras: `[vision]`)."""

    TAGS = "tags"  # a reader of tags (地上子)
    BEACONS = "beacons"  # a receiver of the train stop's beacons
    CURVATURE = "curvature"  # a yaw gyro, compared with a map of curvature
    GNSS = "gnss"
    LIDAR = "lidar"


Carries = Annotated[
    tuple[Annotated[PositionSensor, Field(strict=False)], ...],
    Field(strict=False, max_length=len(PositionSensor)),
]


class Sensors(Record):
    """`[sensors]`: what trains carry, and its errors, drawn per train or per reading from seeded sources."""

    carries: Annotated[
        Carries, about("how trains find their position, besides wheels", "Sugiyama: tags and wheels")
    ] = (PositionSensor.TAGS,)
    carries_of: Annotated[dict[str, Carries], about("the same by stock id, instead")] = Field(
        default_factory=dict
    )

    @property
    def wheels_vary(self) -> bool:
        """Whether what a turn of the measured wheel is worth changes on the way."""
        return self.creep_share > 0.0 or self.tread_conicity > 0.0

    def wheel_varies_share(self, wheel_diameter_m: float) -> float:
        """By how much at most, of a wheel of that diameter, as a share."""
        leads = self.tachometer_axle == "leading"
        slope = self.tread_conicity * self.flangeway_m / (0.5 * wheel_diameter_m) if leads else 0.0
        return self.creep_share + slope

    def carried_by(self, stock_id: str) -> frozenset[PositionSensor]:
        """What a stock carries."""
        return frozenset(self.carries_of.get(stock_id, self.carries))

    def carries_gyro(self, stock_id: str) -> bool:
        """Whether a stock carries a yaw gyro and a map of curvature."""
        return PositionSensor.CURVATURE in self.carried_by(stock_id)

    @property
    def any_gyro(self) -> bool:
        """Whether any stock may carry one."""
        return any(
            PositionSensor.CURVATURE in carried for carried in (self.carries, *self.carries_of.values())
        )

    wheel_factor_sigma: Annotated[
        quantities.WheelError,
        about(
            "standard deviation of real over assumed wheel circumference, among trains",
            "assumed: wear between two turnings",
        ),
    ] = 0.003
    creep_share: Annotated[
        quantities.Creep,
        about(
            "share by which the measured wheel turns more when it pulls at the adhesion limit, and less when it"
            " brakes there; in proportion below",
            "off; Harada, 2.1, names it. Assumed where it is on: 0.003, what Kalker's linear theory gives at an"
            " adhesion of 0.25 under 50 kN a wheel, 0.001, with the bend towards saturation",
        ),
    ] = 0.0
    tread_conicity: Annotated[
        quantities.Conicity,
        about(
            "slope of the treads: in curves a leading axle runs outwards, on the outer wheel's larger circle",
            "off; Harada, 2.1. Assumed where it is on: 0.05, a new cone of 1 in 20",
        ),
    ] = 0.0
    flangeway_m: Annotated[
        quantities.Flangeway,
        about("lateral play by which an axle may run outwards", "assumed: half the play of 1067 mm gauge"),
    ] = 0.007
    tachometer_axle: Annotated[
        Literal["leading", "trailing"],
        about(
            "axle of the bogie, in the direction of travel; a trailing axle stays near the middle",
            "assumed: the larger error",
        ),
    ] = "leading"
    tag_read_sigma_m: Annotated[
        quantities.ReadError,
        about(
            "standard deviation of the place where a tag is read", "assumed: a reader's field of about 0.1 m"
        ),
    ] = 0.05
    tag_read_max_m: Annotated[
        quantities.ReadError,
        about("the reader discards readings beyond this", "assumed: the edge of its field"),
    ] = 0.2
    tags: Annotated[
        Literal["ids", "bits"],
        about("a tag's id is read as it stands, or from telegrams bit by bit with the errors of the air"),
    ] = "ids"
    tag_bit_error_factor: Annotated[
        quantities.BitErrorFactor,
        about(
            "factor of the bit-error rates, where tags are read bit by bit", "Sugiyama, table 7, is factor 1"
        ),
    ] = 1.0


class Load(Record):
    """The passengers: shares of the load when full, drawn per train number."""

    load_share_mean: Annotated[
        quantities.Share, about("mean load as a share of the full one", "assumed: a branch line")
    ] = 0.2
    load_share_spread: Annotated[
        quantities.SpreadShare, about("train to train, evenly within +-", "assumed: peak and off-peak")
    ] = 0.15


class Tuning(Record):
    """`[tuning]`: trains learn to stop; the table alone switches it on."""

    days: Annotated[quantities.Days, about("how often the day is repeated; the last one is reported")] = 1
    learn: Annotated[bool, about("whether trains go on learning")] = True
    learned: Annotated[
        str | None, about("file that an earlier run left (`learned.json`), beside the scenario")
    ] = None


class Light(StrEnum):
    """What a run may assume of light and weather."""

    LIT_TUNNEL = "lit_tunnel"  # the paper's condition
    DAYLIGHT = "daylight"
    DUSK = "dusk"
    RAIN = "rain"
    RAIN_AT_DUSK = "rain_at_dusk"
    BACKLIGHT = "backlight"


class LightHours(PartOfDay):
    """`vision.hours`: light and weather of a part of the day."""

    light: Annotated[Light, Field(strict=False), about("light and weather in it")]


class Vision(Record):
    """`[vision]`: stop signs, and a camera on each train that looks for them; without the table there are none."""

    stations: Annotated[
        Literal["all"] | Annotated[tuple[str, ...], Field(strict=False)],
        about("ids of stations with signs, or all"),
    ] = "all"
    rate_hz: Annotated[
        quantities.FrameRate,
        about(
            "frames taken up; the camera has more, but errors of neighbours are alike",
            "assumed: half of the camera's",
        ),
    ] = 5.0
    light: Annotated[
        Light,
        Field(strict=False),
        about(
            "light and weather at the signs: what cameras see follows images rendered in it",
            "Oda, 3.1 (1): a lit underground line",
        ),
    ] = Light.LIT_TUNNEL
    hours: Annotated[
        tuple[LightHours, ...],
        Field(strict=False, max_length=8),
        about("parts of the day with another light; the first that holds counts"),
    ] = ()
    hidden_beyond_m: Annotated[
        quantities.Distance,
        about("curves and buildings hide signs that are further off", "assumed: nothing does"),
    ] = 1000.0
    false_share: Annotated[
        quantities.Share,
        about(
            "share of the frames that take something else for the sign, anywhere in range",
            "assumed: none beyond those rendered",
        ),
    ] = 0.0

    @property
    def wanted(self) -> bool:
        """Whether any station has a sign."""
        return bool(self.stations)

    def has_sign(self, station_id: str | None) -> bool:
        """Whether that station has stop signs; None is a place that is no station."""
        if station_id is None:
            return False
        return self.stations == "all" or station_id in self.stations


class Limits(Record):
    """`[limits]`: when a run ends whatever happens."""

    time_limit_s: Annotated[
        quantities.RunLimit,
        about("the run ends this long after the last planned time", "assumed: an hour of delay"),
    ] = 3600.0
    stall_limit_s: Annotated[
        quantities.RunLimit,
        about(
            "or when no train has moved for this long although one waits for a section", "assumed: an hour"
        ),
    ] = 3600.0


class Interlocking(StrEnum):
    """Where it is decided who goes where."""

    ONBOARD = "onboard"  # units ask the manager and command terminals, by radio
    CENTRAL = "central"  # a centre (CTC) does, over a cable along the line
    RELAY = (
        "relay"  # a centre does, and where it does not reach, staff at the stations' own relay interlockings
    )


class Operation(Record):
    """`[operation]`: what people do, and from where the line is worked."""

    interlocking: Annotated[
        Interlocking,
        Field(strict=False),
        about(
            "on board, or by a centre whose cable reaches trains and points: beyond a cut (`cable_cut`) no train moves"
            " further than it may already; `relay`: until staff have come to the stations and work them",
            "Sugiyama: on board",
        ),
    ] = Interlocking.ONBOARD
    staff_reach_s: Annotated[
        quantities.Wait,
        about("`relay`: from a cut until staff are at the stations beyond it", "assumed: an hour by road"),
    ] = 3600.0
    telephone_block_s: Annotated[
        quantities.Wait,
        about(
            "`relay`: staff of two stations agree on a train by telephone and write it down (代用閉そく)",
            "assumed: three minutes",
        ),
    ] = 180.0
    release: Annotated[
        ReleaseRule,
        Field(strict=False),
        about(
            "what lies behind a train is given back as a whole route, when it has arrived, or each section by itself,"
            " at the first tag that proves the whole train to have left it",
            "Sugiyama: a whole route",
        ),
    ] = ReleaseRule.ROUTE
    centre: Annotated[
        str | None, about("station at which the centre's cable joins the line; left out: the first")
    ] = None

    portal_lead_s: Annotated[
        quantities.Wait,
        about("a train stands at the portal this long before its first departure", "assumed: 3.5 min"),
    ] = 210.0
    change_ends_s: Annotated[
        quantities.Wait, about("the driver walks to the other end", "assumed: 40 m and the cabs")
    ] = 60.0
    reentry: Annotated[
        ReentryMode,
        Field(strict=False),
        about("how the block state comes back after the manager lost it", "assumed: people are helped"),
    ] = ReentryMode.ASSISTED


class Dispatch(Record):
    """`[dispatch]`: how the block manager gives routes that are free; left out, to who asks first."""

    certificate: Annotated[
        bool, about("a route is granted only if it is proven that all trains can still finish", "off")
    ] = False
    order: Annotated[
        OrderRule,
        Field(strict=False),
        about(
            "who goes first over open line: who asks first, who is planned first while it is not too late, or beyond"
            " that by the less delay of all trains whichever of two goes first, or by the order of all trains with the"
            " least delay (with the extra `plan`)",
            "off",
        ),
    ] = OrderRule.FIRST_COME
    keep_order_below_min: Annotated[
        quantities.DelayMin,
        about("the planned order is kept while the train that is first is less late", "assumed: 4 min"),
    ] = 4.0
    hold_min_max: Annotated[
        quantities.DelayMin,
        about("no train waits for its turn longer than this", "assumed: a quarter of an hour"),
    ] = 15.0
    overtaken_max: Annotated[
        quantities.Overtaken,
        about("number of trains that may pass before one that waits for the same line", "assumed: two"),
    ] = 2
    may: Annotated[
        tuple[Annotated[DispatcherMeans, Field(strict=False)], ...],
        Field(strict=False),
        about(
            "what the dispatcher may do besides: have a train go to another track of its next station, ask a train that"
            " does not leave for its route back",
            "nothing",
        ),
    ] = ()
    turn_back_at: Annotated[
        tuple[str, ...],
        Field(strict=False),
        about(
            "stations where the dispatcher may end a late train, so that its set goes on from there as a later train of"
            " its own that stops there",
            "none",
        ),
    ] = ()
    cancel_trains: Annotated[
        tuple[str, ...],
        Field(strict=False),
        about(
            "trains that the dispatcher may leave out whole, so that their set goes on as a later train of its own",
            "none",
        ),
    ] = ()
    cancelled_min: Annotated[
        quantities.DelayMin,
        about(
            "a call that is cancelled counts as so late, in every figure; and so does a train that is cut, whole or in"
            " part, where the dispatcher weighs it",
            "assumed: an hour",
        ),
    ] = 60.0
    cut_gain_min: Annotated[
        quantities.DelayMin,
        about(
            "train-minutes that cutting trains must save beyond that, at least; 0: anything, but more than nothing",
            "assumed: 10 min",
        ),
    ] = 10.0
    given: Annotated[
        tuple[str, ...],
        Field(strict=False),
        about(
            "the order of the day: the set of each of all moves in turn, as `branchline import displib` writes it",
            "none: nobody goes by one",
        ),
    ] = ()

    @model_validator(mode="after")
    def _only_by_proof(self) -> Self:
        if (self.may or self.cuts) and not self.certificate:
            raise ValueError(
                "nothing without certificate = true: on another track trains may block each other"
            )
        return self

    @property
    def cuts(self) -> bool:
        """Whether the dispatcher may end trains early or leave them out."""
        return bool(self.turn_back_at or self.cancel_trains)

    @property
    def stated_late_s(self) -> float:
        """How late a cancelled call counts as, s."""
        return 60.0 * self.cancelled_min


NO_TUNING: Final = Tuning(learn=False)  # a scenario without that table
NO_VISION: Final = Vision(stations=())


@dataclass(frozen=True, slots=True, kw_only=True)
class Tables:
    """All tables of a scenario that a run reads: a field each, whose default is that of a scenario without the table.

    What follows of a field: the table of a scenario file, its patch, its schema, its part of docs/files/scenario.md,
    and the attribute of a setup.
    """

    air: AirParameters = field(default_factory=AirParameters)
    second_air: Annotated[
        AirParameters | None,
        about("a second network, on which each telegram goes out as well; left out: there is one"),
    ] = None
    unit: UnitParameters = field(default_factory=UnitParameters)
    driving: Driving = field(default_factory=Driving)
    law: LawTables = field(default_factory=LawTables)
    planning: Planning = field(default_factory=Planning)
    sensors: Sensors = field(default_factory=Sensors)
    gnss: Gnss = field(default_factory=Gnss)
    beacons: Beacons = field(default_factory=Beacons)
    curvature: Curvature = field(default_factory=Curvature)
    scatter: ScatterSettings = field(default_factory=ScatterSettings)
    tuning: Tuning = NO_TUNING
    vision: Vision = NO_VISION
    lidar: Lidar = field(default_factory=Lidar)
    limits: Limits = field(default_factory=Limits)
    operation: Operation = field(default_factory=Operation)
    dispatch: Dispatch = field(default_factory=Dispatch)
    battery: Annotated[
        BatterySettings | None, about("trains that have a battery run on it; left out: all run from a wire")
    ] = None
    people: People = field(default_factory=People)
    late: Late = field(default_factory=Late)
    substitute: Annotated[
        Substitute | None,
        about("substitute working while the block manager is off; left out: trains wait until it is back"),
    ] = None
    line_signals: Annotated[
        LineSignals | None,
        about("trains run by line signals, as before there were units; left out: under authority"),
    ] = None
