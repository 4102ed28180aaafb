"""What the feasibility check says: the meets of a plan, and what in it never goes on, runs late or leaves no room.

Three words, by what the run would make of it (`Severity`):

- impossible: a train would never get on. No way, no tag or no radio where its unit needs them, a track that never
  becomes free, trains that wait for each other in a circle. `branchline run` refuses this alone;
- late: it runs, but not as printed. A time is short by 60 s or more at one place (a leg, a turn-back, a section still
  taken), more than whole minutes can hide, or by 30 s where a plan gives seconds, and its trains do not make
  up for it; or a train would come or leave 60 s after its time or more by what adds up;
- tight: anything less. The trains run to time, or late by less than that, and recover.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

from network.clock import clock

HIDDEN_BY_MINUTES_S: Final = 60.0  # a plan in whole minutes is short of the truth by less than this
HIDDEN_BY_SECONDS_S: Final = 30.0  # assumed: two steps of 15 s, in which railways plan
SAID_IN_SECONDS_S: Final = 120  # longer times are given in minutes


class FindingKind(Enum):
    """What is wrong."""

    NO_WAY = "no way"  # the line has no route for a train
    OPPOSING = "opposing trains"  # meet where they cannot pass each other
    FOLLOWING = "following trains"  # one is still in the section that the next needs
    CROSSING = "crossing routes"  # two routes over the same points
    COMING_IN = "coming in at once"  # where one must stand before the other comes in
    TRACK = "track occupied"  # two trains on one track of a station
    TERMINAL = "terminal track occupied"  # the same at an end of the line
    PORTAL = "portal"  # cannot deliver, or not take, a train in time
    LEG = "running time"
    GRADIENT = "gradient"  # on which a train cannot start, or comes to a stand
    DWELL = "dwell"
    TURN_BACK = "turn-back time"
    LAYOVER = "layover"
    TAG = "tag missing"
    STOP = "stop off its mark"
    COVERAGE = "no radio"
    CHARGE = "charge"  # of a battery
    LEVEL_CROSSING = "level crossing"
    CIRCLE = "trains wait for each other"
    LATE = "lateness"  # what adds up


class Severity(Enum):
    """What becomes of a plan by it, the gravest first."""

    IMPOSSIBLE = "impossible"
    LATE = "late"
    TIGHT = "tight"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong with a plan; `place` is a station's id, or a section's where there is no station.

    `time_s` is of the plan, s after midnight; `short_s` by how much a time is short, None where no time would do.
    `text` says who, where, when and why; `remedy` what would mend it nearest at hand.
    """

    kind: FindingKind
    severity: Severity
    trains: tuple[str, ...]
    place: str
    time_s: float
    text: str
    remedy: str
    short_s: float | None = None

    @property
    def minute(self) -> str:
        """HH:MM of the plan."""
        return minute(self.time_s)

    @property
    def sentence(self) -> str:
        """Text and remedy."""
        return f"{self.text}; {self.remedy}"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "kind": self.kind.value,
            "severity": self.severity.value,
            "trains": list(self.trains),
            "place": self.place,
            "minute": self.minute,
            "time_s": round(self.time_s, 1),
            "short_s": None if self.short_s is None else round(self.short_s, 1),
            "text": self.text,
            "remedy": self.remedy,
        }


@dataclass(frozen=True, slots=True)
class PlannedMeet:
    """Two opposing trains at one place at one time, as planned, each on its track of the drawn missions.

    `station` is where they pass each other; None between stations, where `low` and `high` are the stations on either
    side and each has a track of its own if they can pass. Tracks are empty between stations.
    """

    down_train: str
    up_train: str
    time_s: float
    position_m: float
    station: str | None
    low: str | None
    high: str | None
    down_track: str
    up_track: str
    possible: bool = True

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "trains": [self.down_train, self.up_train],
            "station": self.station,
            "between": None if self.station is not None else [self.low, self.high],
            "minute": minute(self.time_s),
            "time_s": round(self.time_s, 1),
            "km": round(self.position_m / 1000.0, 3),
            "tracks": [self.down_track, self.up_track],
            "possible": self.possible,
        }


@dataclass(frozen=True, slots=True)
class Feasibility:
    """All of it, the gravest first, and in order of time."""

    meets: tuple[PlannedMeet, ...]
    findings: tuple[Finding, ...]

    def of_severity(self, *severities: Severity) -> tuple[Finding, ...]:
        """Those of some severities."""
        return tuple(f for f in self.findings if f.severity in severities)

    @property
    def impossible(self) -> tuple[Finding, ...]:
        """What never goes on: it refuses the plan."""
        return self.of_severity(Severity.IMPOSSIBLE)

    @property
    def not_as_printed(self) -> tuple[Finding, ...]:
        """What never goes on, or runs late."""
        return self.of_severity(Severity.IMPOSSIBLE, Severity.LATE)

    @property
    def good(self) -> bool:
        """Whether all trains of the plan come to their end."""
        return not self.impossible

    @property
    def on_time(self) -> bool:
        """Whether the plan runs as it is printed."""
        return not self.not_as_printed

    @property
    def tight_places(self) -> int:
        """At how many places a plan that runs as printed has no room."""
        return len({f.place for f in self.of_severity(Severity.TIGHT)})

    @property
    def verdict(self) -> str:
        """The plan in a word and a sentence."""
        if self.impossible:
            return f"impossible: it never goes on; {self.impossible[0].text}"
        if not self.on_time:
            latest = max(self.not_as_printed, key=lambda f: (f.kind is FindingKind.LATE, f.short_s or 0.0))
            return f"late: it runs, but not as printed; {latest.text}"
        places = self.tight_places
        return (
            f"tight: it runs as printed, without room at {places} place{'s' if places > 1 else ''}"
            if places
            else "good: it runs as printed"
        )


def minute(time_s: float) -> str:
    """HH:MM of the minute that a time (s after midnight) lies in."""
    return clock(time_s // 60 * 60)[:-3]


def length_of_time(time_s: float) -> str:
    """A length of time, s, as people say it: seconds up to two minutes, whole minutes beyond; rounded up."""
    whole_s = math.ceil(time_s)
    return f"{whole_s} s" if whole_s <= SAID_IN_SECONDS_S else f"{math.ceil(time_s / 60.0)} min"


def severity_of(short_s: float, *planned_s: float | None) -> Severity:
    """What a time short by that much comes to; `planned_s` are the times of the plan that it follows from."""
    whole = all(time_s is None or time_s % 60 == 0 for time_s in planned_s)
    hidden_s = HIDDEN_BY_MINUTES_S if whole else HIDDEN_BY_SECONDS_S
    if math.isinf(short_s):
        return Severity.IMPOSSIBLE
    return Severity.LATE if short_s >= hidden_s else Severity.TIGHT
