"""The tables of a scenario that a run reads as they are: one class each, for the file and for the run.

Ranges are those of the kinds in `network.files.kinds`; what a key means and where its default comes from stands
with it, and `docs/files.md` is made from here.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Final, Literal

from pydantic import Field, ValidationInfo, field_validator

from network.files.kinds import TimeOfDay, about
from network.files.quantities import (
    BitErrorFactor,
    BodyDamping,
    BodyFrequency,
    CurvatureError,
    Days,
    Deceleration,
    Distance,
    FrameRate,
    Gain,
    MatchedWay,
    NoiseFactor,
    PositionBound,
    Reaction,
    ReadError,
    RunLimit,
    SampleRate,
    SearchedWay,
    Share,
    ShareAbove0,
    Sigma,
    Sigmas,
    SpeedMarginMps,
    SpeedMps,
    SpreadShare,
    Wait,
    WheelError,
    YawRateDegps,
)
from network.files.toml_input import Record
from simulation.sensors.open_air import Light
from wayside.config import ReentryMode


class Driving(Record):
    """`[driving]`: how units drive and supervise; neither the line nor the paper gives figures."""

    law: Annotated[
        str, about("driving law of every stock that is not named", "assumed: notches about a speed")
    ] = "hold_speed"
    law_of: Annotated[dict[str, str], about("driving law by stock id")] = Field(default_factory=dict)

    service_guaranteed_share: Annotated[
        ShareAbove0,
        about("of the strongest service notch, on which supervision counts", "assumed: worn pads, wet rail"),
    ] = 0.8
    emergency_guaranteed_share: Annotated[
        ShareAbove0, about("of the emergency brake, on which supervision counts", "assumed: the same")
    ] = 0.8
    design_adhesion_share: Annotated[
        ShareAbove0,
        about(
            "of the dry rail's adhesion, down to which the guaranteed brakes hold; what follows from less is told as"
            " outside the design",
            "assumed: a damp rail, and what the guaranteed brakes need at the speeds of the lines here",
        ),
    ] = 0.8
    reaction_reserve_s: Annotated[
        Reaction, about("beyond dead time and lag of the brake", "assumed: ageing valves")
    ] = 0.5
    service_margin_mps: Annotated[
        SpeedMarginMps, about("over the permitted speed before the service brake comes", "assumed: 2 km/h")
    ] = 0.6
    release_margin_mps: Annotated[
        SpeedMarginMps, about("under it before that brake goes", "assumed: so that it does not chatter")
    ] = 1.0
    emergency_margin_mps: Annotated[
        SpeedMarginMps, about("over it before the emergency brake comes", "assumed: 7 km/h")
    ] = 2.0
    driving_margin_mps: Annotated[
        SpeedMarginMps, about("under the permitted speed at which trains are driven", "assumed: 4 km/h")
    ] = 1.2
    stop_deceleration_mps2: Annotated[
        Deceleration, about("of the pattern to a stop at a mark", "assumed: a moderate stop, 2.2 km/h/s")
    ] = 0.6
    stop_gain_per_s: Annotated[
        Gain, about("proportional gain to the stop pattern", "assumed: settles in about a second")
    ] = 0.8
    cruise_gain_per_s: Annotated[
        Gain, about("proportional gain to the cruising speed", "assumed: settles in about 3 s")
    ] = 0.3
    notch_hold_s: Annotated[
        Wait, about("a notch is kept at least this long", "assumed: spares the switchgear")
    ] = 2.0
    standing_brake_share: Annotated[
        ShareAbove0, about("of the notches, applied while a train stands", "assumed: holds on 20 permille")
    ] = 0.5


class Carried(StrEnum):
    """What trains may carry to know where they are, beside wheels and slide protection (cameras: `[vision]`)."""

    TAGS = "tags"  # a reader of tags (地上子)
    BEACONS = "beacons"  # a receiver of the train stop's beacons
    CURVATURE = "curvature"  # a yaw gyro, compared with a map of curvature
    GNSS = "gnss"
    LIDAR = "lidar"


Carries = Annotated[
    tuple[Annotated[Carried, Field(strict=False)], ...], Field(strict=False, max_length=len(Carried))
]


class Sensors(Record):
    """`[sensors]`: what trains carry, and its errors, drawn per train or per reading from seeded sources."""

    carries: Annotated[Carries, about("by what trains know where they are", "Sugiyama: tags and wheels")] = (
        Carried.TAGS,
    )
    carries_of: Annotated[dict[str, Carries], about("the same by stock id, in place of it")] = Field(
        default_factory=dict
    )

    def carried_by(self, stock_id: str) -> frozenset[Carried]:
        """What a stock carries."""
        return frozenset(self.carries_of.get(stock_id, self.carries))

    def carries_gyro(self, stock_id: str) -> bool:
        """Whether a stock carries a yaw gyro and a map of curvature."""
        return Carried.CURVATURE in self.carried_by(stock_id)

    @property
    def any_gyro(self) -> bool:
        """Whether any stock may carry one."""
        return any(Carried.CURVATURE in carried for carried in (self.carries, *self.carries_of.values()))

    wheel_factor_sigma: Annotated[
        WheelError,
        about(
            "of real over assumed wheel circumference, train to train", "assumed: wear between two turnings"
        ),
    ] = 0.003
    tag_read_sigma_m: Annotated[
        ReadError,
        about("of where a tag is read", "assumed: a reader's field of about 0.1 m"),
    ] = 0.05
    tag_read_max_m: Annotated[
        ReadError, about("beyond this the reader discards", "assumed: the edge of its field")
    ] = 0.2
    tags: Annotated[
        Literal["ids", "bits"],
        about("a tag's id is read as it stands, or from telegrams bit by bit with the errors of the air"),
    ] = "ids"
    tag_bit_error_factor: Annotated[
        BitErrorFactor,
        about("on the bit-error rates, where tags are read by bits", "Sugiyama, table 7, is factor 1"),
    ] = 1.0


class BeaconTrust(StrEnum):
    """What a beacon noticed in its window may do."""

    BOUNDED = "bounded"  # move the estimate inside the bounds; one with a number cuts them
    PAPER = "paper"  # set the position and bounds, as in Harada, 2.2


class Beacons(Record):
    """`[beacons]`: how trains that carry a receiver go by the beacons of the train stop."""

    trust: Annotated[
        BeaconTrust,
        Field(strict=False),
        about(
            "what a beacon noticed in its window may do; `paper` alone lets one that is mistaken break the bounds"
        ),
    ] = BeaconTrust.BOUNDED
    window_share: Annotated[
        ShareAbove0,
        about("of the interval: a beacon is looked for this far either way", "Harada, table 1: 40 m of 440"),
    ] = 0.1
    window_least_m: Annotated[
        PositionBound, about("and at least this far", "Harada, 3.2: some windows can be no wider")
    ] = 10.0
    accuracy_m: Annotated[
        PositionBound,
        about("bound of the position where a beacon is noticed", "assumed: the receiver's field"),
    ] = 1.0
    placed_within_m: Annotated[
        PositionBound,
        about(
            "one that tells its number lies this near to where the database has it",
            "assumed: kilometrages to the metre; moved ones are told to the database",
        ),
    ] = 2.0
    notice_sigma_m: Annotated[
        ReadError, about("of where a beacon is noticed", "assumed: a loop of half a metre under the car")
    ] = 0.15
    notice_max_m: Annotated[ReadError, about("at most this far off", "assumed: the edge of its field")] = 0.5


class Rails(StrEnum):
    """How well rails are laid in plan: the two levels of ORE B 176, and without any fault."""

    STRAIGHT = "straight"
    LOW = "low"
    HIGH = "high"


class Filter(StrEnum):
    """What map and run go through before they are compared; all but the first are for experiments."""

    SPACE = "space"
    TIME = "time"
    OFF = "off"


class Curvature(Record):
    """`[curvature]`: yaw gyro, rails as laid, comparison with the map, where `sensors.carries` has curvature."""

    map: Annotated[
        str,
        about(
            "what the map holds: `design`, the line as believed, or a file beside the scenario",
            "Harada, 3.3: filtered curvature is near that of the ledger",
        ),
    ] = "design"
    rails: Annotated[
        Rails,
        Field(strict=False),
        about(
            "how well the rails lie in plan; units count on no worse",
            "ORE B 176: spectra of low and high disturbance; assumed: a branch line has the high one",
        ),
    ] = Rails.HIGH
    sample_sigma_degps: Annotated[
        YawRateDegps,
        about(
            "standard deviation of one sample of the gyro",
            "ASM330LHH in the cab of an ETR103 (ETH-PBL/Railway-Precise-Localization): 0.16 to 0.21, mostly its own"
            " white noise",
        ),
    ] = 0.19
    sample_rate_hz: Annotated[SampleRate, about("of the gyro's samples", "the same record: 1.7 kHz")] = 1700.0
    noise_factor: Annotated[
        NoiseFactor, about("on the gyro's noise; units count on 1", "the record is factor 1")
    ] = 1.0
    bias_sigma_degps: Annotated[
        YawRateDegps,
        about("of the bias, train to train", "the same record: some 0.8 at a stand; ASM330LHH: 1 typical"),
    ] = 0.5
    bias_walk_degps: Annotated[
        YawRateDegps,
        about("of the bias about that", "assumed: 0.005 deg/s a kelvin (ASM330LHH), 2 kelvin in the cab"),
    ] = 0.01
    bias_walk_s: Annotated[Wait, about("in which it is another", "assumed: a cab warms in an hour")] = 3600.0
    gain_sigma: Annotated[
        Sigma, about("of shown over real yaw rate, train to train", "assumed: calibrated on a turntable")
    ] = 0.001
    body_frequency_hz: Annotated[
        BodyFrequency, about("natural frequency of the car body in yaw", "assumed: as most cars have")
    ] = 1.0
    body_damping: Annotated[
        BodyDamping, about("its damping as a share of the critical one", "assumed: with yaw dampers")
    ] = 0.3
    body_spread: Annotated[
        SpreadShare, about("what both differ by from train to train, at most", "assumed: load and wear")
    ] = 0.1
    filter: Annotated[
        Filter,
        Field(strict=False),
        about("what map and run go through: by distance, by time, or nothing", "Harada, 3.3: by distance"),
    ] = Filter.SPACE
    filter_speed_mps: Annotated[
        SpeedMps, about("where a filter by time is as one by distance", "assumed: 72 km/h")
    ] = 20.0
    window_m: Annotated[MatchedWay, about("longest way that is compared, N_r", "Harada, figure 2: 600 m")] = (
        600.0
    )
    window_least_m: Annotated[
        MatchedWay, about("shortest, after a path has begun", "assumed: about a curve")
    ] = 100.0
    search_m: Annotated[
        SearchedWay,
        about(
            "furthest that is searched either way, N_s; never beyond the bounds", "Harada, figure 2: 200 m"
        ),
    ] = 200.0
    every_m: Annotated[
        MatchedWay, about("a comparison each so many metres", "assumed: about one a second at line speed")
    ] = 25.0
    transition_m: Annotated[
        MatchedWay,
        about("least way of transition curve in what is compared (section 3.4)", "assumed: half of one"),
    ] = 20.0
    mismatch_per_m: Annotated[
        CurvatureError,
        about(
            "root mean square of the difference beyond which the track counts as foreign (equation 3)",
            "assumed: four times what rails of high disturbance leave after the filter",
        ),
    ] = 2.5e-4
    sure_sigmas: Annotated[
        Sigmas, about("deviations that the bounds of a fix have room for", "assumed: one in two million")
    ] = 5.0

    wheels_vary_share: Annotated[
        WheelError,
        about(
            "what wheels count over a few hundred metres differs from their mean by no more: creep and the tread's"
            " slope, as far as they are no slip or slide",
            "assumed: creep of 0.15 % at half of the adhesion, 4 mm off the middle of a cone of 1 in 20 0.05 %",
        ),
    ] = 0.002

    def step_sigma_radps(self, step_s: float) -> float:
        """Standard deviation (rad/s) of the mean of the samples of a step."""
        return self.noise_factor * self.stated_sigma_radps(step_s)

    def stated_sigma_radps(self, step_s: float) -> float:
        """The same as units count on it."""
        return math.radians(self.sample_sigma_degps) / math.sqrt(self.sample_rate_hz * step_s)


class Load(Record):
    """The passengers: shares of the load when full, drawn per train number."""

    load_share_mean: Annotated[
        Share, about("mean load as a share of the full one", "assumed: a branch line")
    ] = 0.2
    load_share_spread: Annotated[
        SpreadShare, about("train to train, evenly within +-", "assumed: peak and off-peak")
    ] = 0.15


class Tuning(Record):
    """`[tuning]`: trains learn to stop; the table alone switches it on."""

    days: Annotated[Days, about("the same day that often; the last one is reported")] = 1
    learn: Annotated[bool, about("whether trains go on learning")] = True
    learned: Annotated[
        str | None, about("file that an earlier run left (`learned.json`), beside the scenario")
    ] = None


class LightHours(Record):
    """`vision.hours`: light and weather of a part of the day."""

    from_s: Annotated[TimeOfDay, Field(alias="from"), about("when it begins")]
    to_s: Annotated[TimeOfDay, Field(alias="to"), about("when it ends")]
    light: Annotated[Light, Field(strict=False), about("light and weather in it")]

    @field_validator("to_s")
    @classmethod
    def _later(cls, to_s: float, info: ValidationInfo) -> float:
        if to_s <= info.data.get("from_s", -1.0):
            raise ValueError("a time after that of from")
        return to_s


class Vision(Record):
    """`[vision]`: stop signs, and a camera on each train that looks for them; without the table there are none."""

    stations: Annotated[
        Literal["all"] | Annotated[tuple[str, ...], Field(strict=False)],
        about("ids of stations with signs, or all"),
    ] = "all"
    rate_hz: Annotated[
        FrameRate,
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
        Distance,
        about("curves and buildings hide signs that are further off", "assumed: nothing does"),
    ] = 1000.0
    false_share: Annotated[
        Share,
        about(
            "of the frames that show something else as the sign, anywhere in range",
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
        RunLimit, about("the run ends this long after the last planned time", "assumed: an hour of delay")
    ] = 3600.0
    stall_limit_s: Annotated[
        RunLimit,
        about(
            "or when no train has moved for this long although one waits for a section", "assumed: an hour"
        ),
    ] = 3600.0


class Operation(Record):
    """`[operation]`: what people do."""

    portal_lead_s: Annotated[
        Wait,
        about("a train stands at the portal this long before its first departure", "assumed: 3.5 min"),
    ] = 210.0
    change_ends_s: Annotated[
        Wait, about("the driver walks to the other end", "assumed: 40 m and the cabs")
    ] = 60.0
    reentry: Annotated[
        ReentryMode,
        Field(strict=False),
        about("how the block state comes back after the manager lost it", "assumed: people are helped"),
    ] = ReentryMode.ASSISTED


NO_TUNING: Final = Tuning(learn=False)  # a scenario without that table
NO_VISION: Final = Vision(stations=())
