"""How units drive and supervise, as a scenario has it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from network.files.kinds import about
from network.files.quantities import Deceleration, Gain, Reaction, Share, ShareAbove0, SpeedMarginMps, Wait
from network.files.toml_input import Record


class Driving(Record):
    """`[driving]`: how units drive and supervise; neither the line nor the paper gives figures."""

    law: Annotated[
        str, about("driving law of every stock that is not named", "assumed: notches about a speed")
    ] = "hold_speed"
    law_of: Annotated[dict[str, str], about("driving law by stock id")] = Field(default_factory=dict)

    service_guaranteed_share: Annotated[
        ShareAbove0,
        about(
            "share of the strongest service notch on which supervision relies", "assumed: worn pads, wet rail"
        ),
    ] = 0.8
    emergency_guaranteed_share: Annotated[
        ShareAbove0, about("share of the emergency brake on which supervision relies", "assumed: the same")
    ] = 0.8
    design_adhesion_share: Annotated[
        ShareAbove0,
        about(
            "share of the dry rail's adhesion down to which the brakes are guaranteed; what follows from less is"
            " reported as outside the design",
            "assumed: a damp rail, and what the guaranteed brakes need at the speeds of the lines here",
        ),
    ] = 0.8
    least_adhesion: Annotated[
        Share,
        about(
            "no rail is more slippery: by it supervision tells the true speed of a train whose wheels slide; 0: none is"
            " stated, and the speed before the slide counts until they roll again",
            "assumed: damp leaves leave as little as 0.015 (rail-traction.com/technical)",
        ),
    ] = 0.015
    reaction_reserve_s: Annotated[
        Reaction,
        about("reaction time allowed beyond dead time and lag of the brake", "assumed: ageing valves"),
    ] = 0.5
    service_margin_mps: Annotated[
        SpeedMarginMps,
        about("excess over the permitted speed at which the service brake comes", "assumed: 2 km/h"),
    ] = 0.6
    release_margin_mps: Annotated[
        SpeedMarginMps,
        about(
            "margin below the permitted speed at which the service brake is released",
            "assumed: so that it does not chatter",
        ),
    ] = 1.0
    emergency_margin_mps: Annotated[
        SpeedMarginMps,
        about("excess over the permitted speed at which the emergency brake comes", "assumed: 7 km/h"),
    ] = 2.0
    driving_margin_mps: Annotated[
        SpeedMarginMps, about("margin below the permitted speed that driving keeps", "assumed: 4 km/h")
    ] = 1.2
    stop_deceleration_mps2: Annotated[
        Deceleration,
        about("deceleration of the pattern to a stop at a mark", "assumed: a moderate stop, 2.2 km/h/s"),
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
        ShareAbove0,
        about("share of the brake notches applied while a train stands", "assumed: holds on 20 permille"),
    ] = 0.5
