"""What the rules of a duty are set to: times, and when a unit gives back what lies behind it."""

from __future__ import annotations

from enum import Enum

import msgspec


class ReleaseRule(Enum):
    """When a unit gives back what lies behind it."""

    ROUTE = "route"  # all of a route at once, at the arrival tag
    SECTION = "section"  # each section by itself, at the first tag that proves it to be behind


class DutyParameters(msgspec.Struct, frozen=True):
    """Times of the duty, s, and its rule of release."""

    dwell_min_s: float
    request_lead_s: float
    emergency_release_s: float
    release: ReleaseRule = ReleaseRule.ROUTE
