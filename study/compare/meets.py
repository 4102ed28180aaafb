"""Where trains met as they ran (行違い), by their true courses, and what became of each meet in another run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.model import Direction, Line
from study.report.data import ReportedRun
from study.wording import compared as words
from study.wording.phrase import NOTHING, Phrase, joined

Floats: TypeAlias = NDArray[np.float64]
Pair: TypeAlias = tuple[str, str]  # the train that runs down, and the one that runs up


@dataclass(frozen=True, slots=True)
class RunMeet:
    """Two opposing trains side by side: `time_s` is when their fronts pass, `at` a station or the two around."""

    down_train: str
    up_train: str
    time_s: float
    position_m: float
    at: tuple[str, ...]


class MeetFate(Enum):
    """What became of a meet."""

    ELSEWHERE = "elsewhere"
    OTHER_TIME = "another time"
    GONE = "gone"
    NEW = "new"


@dataclass(frozen=True, slots=True)
class MeetChange:
    """A meet that is not where or when it was; `why` is said where one of the trains ran in one run only."""

    down_train: str
    up_train: str
    fate: MeetFate
    old: RunMeet | None
    new: RunMeet | None
    why: Phrase = NOTHING

    @property
    def by_s(self) -> float | None:
        """How much later it is in the new run, s."""
        return None if self.old is None or self.new is None else round(self.new.time_s - self.old.time_s, 1)

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        row: dict[str, Any] = {
            "down_train": self.down_train,
            "up_train": self.up_train,
            "fate": self.fate.value,
        }
        for name, meet in (("old", self.old), ("new", self.new)):
            row[f"{name}_at"] = None if meet is None else " – ".join(meet.at)
            row[f"{name}_s"] = None if meet is None else meet.time_s
        return row | {"by_s": self.by_s, "why": self.why.en}


@dataclass(frozen=True, slots=True)
class _SampledTrain:
    number: str
    t_s: Floats
    at_m: Floats
    pieces: pl.Series

    def piece_at(self, time_s: float) -> str:
        """The piece of track on which the front was."""
        return str(self.pieces[max(int(np.searchsorted(self.t_s, time_s, side="right")) - 1, 0)])


def meets_of(run: ReportedRun) -> tuple[RunMeet, ...]:
    """All meets of a run in order of time, from the true trajectories; between two samples trains run evenly."""
    courses: dict[Direction, list[_SampledTrain]] = {Direction.DOWN: [], Direction.UP: []}
    for (_, number), samples in run.courses.items():
        courses[run.directions[number]].append(_course(number, samples))
    found: list[RunMeet] = []
    for down, up in product(courses[Direction.DOWN], courses[Direction.UP]):
        crossing = _crossing(down, up)
        if crossing is not None and _side_by_side(run.line, down, up, crossing[0]):
            time_s, at_m = crossing
            found.append(RunMeet(down.number, up.number, round(time_s, 1), at_m, place_at(run.line, at_m)))
    return tuple(sorted(found, key=lambda meet: (meet.time_s, meet.down_train, meet.up_train)))


def compare_meets(base: ReportedRun, new: ReportedRun, over_s: float) -> tuple[MeetChange, ...]:
    """Meets elsewhere, at a time that differs by more than `over_s`, gone and new, in order of time."""
    olds, news = _by_pair(meets_of(base)), _by_pair(meets_of(new))
    changes = [
        change
        for pair in dict.fromkeys((*olds, *news))
        if (change := _change(pair, olds.get(pair), news.get(pair), (base, new), over_s)) is not None
    ]
    return tuple(sorted(changes, key=_time))


def place_at(line: Line, at_m: float) -> tuple[str, ...]:
    """The station whose tracks lie at a kilometrage, m, or the two that it is between."""
    for station in line.stations.values():
        if station.is_halt:
            continue
        for track in station.tracks:
            piece = line.pieces[track.piece_id]
            if piece.from_m <= at_m <= piece.to_m:
                return (station.id,)
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    low = [station.id for station in stations if station.position_m <= at_m][-1:]
    high = [station.id for station in stations if station.position_m > at_m][:1]
    return (*low, *high)


def _course(number: str, samples: pl.DataFrame) -> _SampledTrain:
    return _SampledTrain(
        number, samples["t_s"].to_numpy(), samples["kilometrage_m"].to_numpy(), samples["piece"]
    )


def _crossing(down: _SampledTrain, up: _SampledTrain) -> tuple[float, float] | None:
    """Time (s) and kilometrage (m) at which two fronts pass each other; None where they do not."""
    from_s, to_s = max(down.t_s[0], up.t_s[0]), min(down.t_s[-1], up.t_s[-1])
    if to_s <= from_s:
        return None
    times = np.union1d(down.t_s, up.t_s)
    times = np.union1d(times[(times > from_s) & (times < to_s)], [from_s, to_s])
    gap_m = np.interp(times, down.t_s, down.at_m) - np.interp(times, up.t_s, up.at_m)
    passed = np.flatnonzero(gap_m >= 0.0)
    if passed.size == 0 or passed[0] == 0:
        return None
    after = int(passed[0])
    share = -gap_m[after - 1] / (gap_m[after] - gap_m[after - 1])
    time_s = float(times[after - 1] + share * (times[after] - times[after - 1]))
    return time_s, float(np.interp(time_s, down.t_s, down.at_m))


def _side_by_side(line: Line, down: _SampledTrain, up: _SampledTrain, time_s: float) -> bool:
    """Whether one kilometrage is one place: branches have kilometrages of their own, and a station may be on both."""
    pieces = [line.pieces[course.piece_at(time_s)] for course in (down, up)]
    stations = {line.sections[piece.section_id].station_id for piece in pieces}
    return pieces[0].alignment_id == pieces[1].alignment_id or (len(stations) == 1 and None not in stations)


def _by_pair(meets: Iterable[RunMeet]) -> Mapping[Pair, RunMeet]:
    return {(meet.down_train, meet.up_train): meet for meet in meets}


def _change(
    pair: Pair, old: RunMeet | None, new: RunMeet | None, runs: tuple[ReportedRun, ReportedRun], over_s: float
) -> MeetChange | None:
    if old is not None and new is not None:
        if old.at != new.at:
            return MeetChange(*pair, MeetFate.ELSEWHERE, old, new)
        later = MeetChange(*pair, MeetFate.OTHER_TIME, old, new)
        return later if abs(later.by_s or 0.0) > over_s else None
    missing_in = runs[1] if new is None else runs[0]
    ran = {number for _, number in missing_in.courses}
    absent = [number for number in pair if number not in ran]
    which = words.compared_name("new" if new is None else "base")
    trains = joined(map(Phrase, absent), words.AND.en, words.AND.ja)
    why = words.DID_NOT_RUN.of(trains=trains, which=which) if absent else NOTHING
    return MeetChange(*pair, MeetFate.GONE if new is None else MeetFate.NEW, old, new, why)


def _time(change: MeetChange) -> tuple[float, str, str]:
    meet = change.new or change.old
    return (meet.time_s if meet else 0.0, change.down_train, change.up_train)
