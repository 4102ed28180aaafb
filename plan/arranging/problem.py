"""What is to be arranged: trains with their calls as printed, how long each runs, what each leg holds and when.

Times are whole seconds after midnight. A train goes from place to place (tracks and portals); what lies between two
places it has whole, from a time before it leaves the one to a time after it is at the other (docs/capacity.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum


class Standing(Enum):
    """Whether a train stands at a station of its way."""

    ALWAYS = "always"
    MAY = "may"  # where it is good for: to be met, which no public timetable prints (運転停車)
    NEVER = "never"


@dataclass(frozen=True, slots=True)
class ByStanding:
    """A length of time, s, for a train that stands and for one that runs through."""

    stands: int
    passes: int


@dataclass(frozen=True, slots=True)
class RunSeconds:
    """From one station to the next, s, by how the train is at its ends: it stands or passes."""

    stop_stop: int
    stop_pass: int
    pass_stop: int
    pass_pass: int

    def half(self) -> RunSeconds:
        """As far as the middle, or from there, as running and braking lengthen the whole."""
        through = self.pass_pass / 2
        starts, stops = self.stop_pass - self.pass_pass, self.pass_stop - self.pass_pass
        return RunSeconds(*(math.ceil(through + more) for more in (starts + stops, starts, stops, 0)))

    def ways(self) -> tuple[tuple[bool, bool, int], ...]:
        """Whether it stands at the one end and at the other, and how long it then takes."""
        return (
            (True, True, self.stop_stop),
            (True, False, self.stop_pass),
            (False, True, self.pass_stop),
            (False, False, self.pass_pass),
        )


@dataclass(frozen=True, slots=True)
class Leg:
    """What a train holds besides the tracks at both ends on its way from the place before, and around which times.

    `lead`: before it leaves the place before, `lag`: after it comes to this one; both may be negative. `overlaps`: what
    it has alone as it comes in, from `enters` before it comes to this place until `stood` after that.
    """

    section_ids: tuple[str, ...]
    lead: ByStanding
    lag: ByStanding
    overlaps: tuple[str, ...] = ()
    enters: ByStanding = ByStanding(0, 0)
    stood: ByStanding = ByStanding(0, 0)


@dataclass(frozen=True, slots=True)
class SlowerTrack:
    """How much longer a train takes to a track (section id) than to the usual one of its station, and from it, s."""

    section_id: str
    comes: ByStanding
    leaves: ByStanding


@dataclass(frozen=True, slots=True)
class Visit:
    """A train at a station of its way. `run`: from the station before, by the usual tracks; None at the first.

    `leg` ends here where the station has tracks of its own, and the train stood on others before; `tracks` are those
    (section ids) that it may have, the usual one first, of which some are `slower`.
    """

    station_id: str
    standing: Standing
    arrival_s: int | None = None  # as printed
    departure_s: int | None = None
    stay_s: int = 0
    run: RunSeconds | None = None
    leg: Leg | None = None
    tracks: tuple[str, ...] = ()
    slower: tuple[SlowerTrack, ...] = ()

    def longer_s(self, track: str | None, *, stands: bool, leaves: bool) -> int:
        """How much longer than on the usual track a run takes that ends on this one, or leaves it."""
        for one in self.slower:
            if one.section_id == track:
                by = one.leaves if leaves else one.comes
                return by.stands if stands else by.passes
        return 0

    def can(self, stands: bool) -> bool:
        """Whether a train may stand (run through) here."""
        return self.standing is not (Standing.NEVER if stands else Standing.ALWAYS)


@dataclass(frozen=True, slots=True)
class TrainToArrange:
    """A train. `follows`: what its set ran before, and `turn_s` the least time between; None: it stood there (留置).

    `enters` and `leaves`: the section of the portal by which it comes and goes, instead of standing there. A train of
    which nothing is printed runs between `from_s` and `until_s`.
    """

    number: str
    visits: tuple[Visit, ...]
    follows: str | None = None
    turn_s: int = 0
    from_s: int = 0
    until_s: int = 0
    enters: str | None = None
    leaves: str | None = None


@dataclass(frozen=True, slots=True)
class ArrangedVisit:
    """Where and when: `arrival_s` and `departure_s` are one where the train runs through."""

    station_id: str
    arrival_s: int
    departure_s: int
    stands: bool
    track: str | None


@dataclass(frozen=True, slots=True)
class PrintedMove:
    """A printed time that had to be moved, s; positive: later."""

    number: str
    station_id: str
    what: str
    printed_s: int
    by_s: int


@dataclass(frozen=True, slots=True)
class Arranged:
    """A plan that works.

    `proven`: none in which no time is moved by more than `reach_s` moves printed times by less in all (beyond the limit
    first), or takes fewer tracks, where these were looked for; `bound_s`: below which there is none.
    `more_tracks`: those that it takes and stations do not have.
    """

    visits: dict[str, tuple[ArrangedVisit, ...]]
    moves: tuple[PrintedMove, ...]
    proven: bool
    bound_s: float
    reach_s: int
    work: float
    more_tracks: dict[str, int] = field(default_factory=dict[str, int])
