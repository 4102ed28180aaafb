"""The tables of a scenario for what trains may carry beside tags: `[beacons]`, `[curvature]`, `[lidar]`."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated

from pydantic import Field

from network.files import quantities
from network.files.kinds import about
from network.files.toml_input import Record
from onboard.localisation.beacons import BeaconWindow
from onboard.localisation.curvature_row import CurvatureComparison


class BeaconTrust(StrEnum):
    """What a beacon noticed in its window may do."""

    BOUNDED = "bounded"  # move the estimate inside the bounds; one with a number cuts them
    PAPER = "paper"  # set the position and bounds, as in Harada, 2.2


class Beacons(BeaconWindow):
    """`[beacons]`: how trains that carry a receiver go by the beacons of the train stop."""

    trust: Annotated[
        BeaconTrust,
        Field(strict=False),
        about(
            "effect of a beacon detected in its window; with `paper` alone a mistaken one can make the bounds wrong"
        ),
    ] = BeaconTrust.BOUNDED
    notice_sigma_m: Annotated[
        quantities.ReadError,
        about(
            "standard deviation of the place where a beacon is detected",
            "assumed: a loop of half a metre under the car",
        ),
    ] = 0.15
    notice_max_m: Annotated[
        quantities.ReadError, about("greatest error of that place", "assumed: the edge of its field")
    ] = 0.5


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


class Curvature(CurvatureComparison):
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
            "alignment quality of the rails; units rely on no worse",
            "ORE B 176: spectra of low and high disturbance; assumed: a branch line has the high one",
        ),
    ] = Rails.HIGH
    sample_sigma_degps: Annotated[
        quantities.YawRateDegps,
        about(
            "standard deviation of one sample of the gyro",
            "ASM330LHH in the cab of an ETR103 (ETH-PBL/Railway-Precise-Localization): 0.16 to 0.21, mostly its own"
            " white noise",
        ),
    ] = 0.19
    sample_rate_hz: Annotated[
        quantities.SampleRate, about("sampling rate of the gyro", "the same record: 1.7 kHz")
    ] = 1700.0
    noise_factor: Annotated[
        quantities.NoiseFactor, about("factor of the gyro's noise; units rely on 1", "the record is factor 1")
    ] = 1.0
    bias_sigma_degps: Annotated[
        quantities.YawRateDegps,
        about(
            "standard deviation of the bias, among trains",
            "the same record: some 0.8 at a stand; ASM330LHH: 1 typical",
        ),
    ] = 0.5
    bias_walk_degps: Annotated[
        quantities.YawRateDegps,
        about(
            "standard deviation of the bias's slow change",
            "assumed: 0.005 deg/s a kelvin (ASM330LHH), 2 kelvin in the cab",
        ),
    ] = 0.01
    bias_walk_s: Annotated[
        quantities.CorrelationTime, about("time constant of that change", "assumed: a cab warms in an hour")
    ] = 3600.0
    gain_sigma: Annotated[
        quantities.Sigma,
        about(
            "standard deviation of shown over real yaw rate, among trains",
            "assumed: calibrated on a turntable",
        ),
    ] = 0.001
    body_frequency_hz: Annotated[
        quantities.BodyFrequency,
        about("natural frequency of the car body in yaw", "assumed: as most cars have"),
    ] = 1.0
    body_damping: Annotated[
        quantities.BodyDamping,
        about("damping of the car body in yaw, as a share of the critical one", "assumed: with yaw dampers"),
    ] = 0.3
    body_spread: Annotated[
        quantities.SpreadShare, about("greatest difference of both among trains", "assumed: load and wear")
    ] = 0.1
    filter: Annotated[
        Filter,
        Field(strict=False),
        about("filter of map and run: by distance, by time, or none", "Harada, 3.3: by distance"),
    ] = Filter.SPACE
    filter_speed_mps: Annotated[
        quantities.SpeedMps,
        about("speed at which a filter by time equals one by distance", "assumed: 72 km/h"),
    ] = 20.0

    def stated_sigma_radps(self, step_s: float) -> float:
        """The same as units count on it."""
        return math.radians(self.sample_sigma_degps) / math.sqrt(self.sample_rate_hz * step_s)


class Lidar(Record):
    """`[lidar]`: what the LiDARs of trains that carry one see of markers (`sensors.carries`)."""

    visibility_m: Annotated[
        quantities.VisibilityM,
        about(
            "visibility in fog, rain and snow; the LiDAR sees markers about as far as people do",
            "assumed: a clear day",
        ),
    ] = 20_000.0
    dirt_share: Annotated[
        quantities.Share,
        about("share of the light lost in dirt on its window, each way", "assumed: a day after cleaning"),
    ] = 0.05
    laid_within_m: Annotated[
        quantities.MarkerError,
        about("markers lie within so much of where the line has them", "assumed: laid by tape from a peg"),
    ] = 0.03
