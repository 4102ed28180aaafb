"""How an on-board unit (車上装置) behaves: its parameters."""

from __future__ import annotations

from dataclasses import dataclass

from onboard.duty.turn import DutyParameters


@dataclass(frozen=True, slots=True)
class UnitParameters:
    """How a unit behaves; `assumed` unless the scenario says otherwise (the paper gives no figures)."""

    dwell_min_s: float = 20.0
    request_lead_s: float = 45.0  # a route is asked for this long before the departure
    time_margin_s: float = 10.0  # arrive this much before the time
    standoff_m: float = 15.0  # stop this far before a stop limit that is no mark
    tag_accuracy_m: float = 0.5
    wheel_error_share: float = 0.02  # worn wheels: growth of the bounds
    doubt_error_share: float = 0.2  # the same after a position fault, until two tags agree with it
    doubt_bound_max_m: float = 60.0  # a train that cannot go on for bounds wider than this goes on sight
    wheel_scale_limit: float = 0.015
    tag_window_m: float = 5.0
    emergency_release_s: float = 30.0  # the driver's acknowledgement after an emergency stop
    restricted_mps: float = 15.0 / 3.6  # on sight while the position is unknown

    @property
    def duty(self) -> DutyParameters:
        """Those that the duty works with."""
        return DutyParameters(self.dwell_min_s, self.request_lead_s, self.emergency_release_s)
