"""Self-tuning of TASC (自動調整): a train's dead time and deceleration offset, learned from its own stops.

Invariant: what is learned describes the train, not the day. A stop in which something passing took part (slide,
load beyond the load compensation, a waveform that fits nothing) is counted and left out; of the others the mode
(最頻値) counts, not the mean (Oda, chapter 4).

The evaluation function J is the mean square difference between the designed deceleration (設計減速度) and the
actual one (発生減速度) moved back by a dead time and, while a brake is asked for, down by an offset: a released brake
has none. All waveforms are smoothed alike by a Hann window of 1 s: a step of the brake then makes J the near
quadratic that the approximation needs, and the noise of a differentiated tachometer goes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from network.errors import InputError
from network.raw import is_list
from vehicle.compiled import compiled

Wave = NDArray[np.float64]

STEP_S: Final = 0.1
DEAD_TIMES: Final = 21  # 0 to 2 s by 0.1 s
OFFSETS: Final = 21  # -1 to +1 km/h/s by 0.1 km/h/s
OFFSET_STEP_MPS2: Final = 0.1 / 3.6
OFFSET_ZERO: Final = 10  # index of no offset
SMOOTHING_S: Final = 1.0
BRAKING_LEAST_S: Final = 2.0
LEAD_S: Final = 2.0  # quiet before the brake that belongs to the window
SEARCH_EVALUATIONS: Final = DEAD_TIMES * OFFSETS
REACH_X: Final = (
    2  # of the six points around their centre, in steps of the grid: J is quadratic only nearby in
)
REACH_Y: Final = 4  # dead time, but exactly so in the offset
SIX_POINTS: Final = (
    (0, 0),
    (REACH_X, 0),
    (-REACH_X, 0),
    (0, REACH_Y),
    (0, -REACH_Y),
    (REACH_X, REACH_Y),
)
LOAD_SHARE_MAX: Final = 0.9  # assumed: beyond it the load compensation is at its end
MISFIT_MAX_MPS2: Final = 0.10  # assumed: root mean square left at the best fit; more fits no characteristic


@dataclass(frozen=True, slots=True)
class StopDecelerations:
    """One stop at the unit's step of 0.1 s: designed and actual deceleration, m/s^2, equally long, up to rest.

    `actual_mps2` is without the part of gradient and running resistance; `slid` is what the slide protection
    says, `load_share` what the load sensor says (0 empty, 1 full).
    """

    designed_mps2: Wave
    actual_mps2: Wave
    slid: bool = False
    load_share: float = 0.5


@dataclass(frozen=True, slots=True)
class CharacteristicFit:
    """The best characteristic of one stop as places on the grid, its J (m/s^2)^2, and how many J were computed."""

    dead_time_index: int
    offset_index: int
    misfit_mps2_squared: float
    evaluations: int

    @property
    def dead_time_s(self) -> float:
        """Dead time (無駄時間), s."""
        return self.dead_time_index * STEP_S

    @property
    def offset_mps2(self) -> float:
        """Deceleration offset (減速度偏差), actual less designed, m/s^2."""
        return (self.offset_index - OFFSET_ZERO) * OFFSET_STEP_MPS2


class Quadratic(NamedTuple):
    """Coefficients of equation 5: Z = a x^2 + b y^2 + c x + d y + e x y + f."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float


def smoothed_wave(wave: Wave) -> Wave:
    """The waveform under a Hann window of `SMOOTHING_S`; same length, ends held."""
    half = round(SMOOTHING_S / STEP_S / 2.0)
    weights = np.hanning(2 * half + 3)[1:-1]
    padded = np.concatenate((np.full(half, wave[0]), wave, np.full(half, wave[-1])))
    return np.asarray(np.convolve(padded, weights / weights.sum(), mode="valid"), dtype=np.float64)


def waves(record: StopDecelerations) -> tuple[Wave, Wave, Wave]:
    """Designed and actual deceleration, m/s^2, and the share of time a brake is asked for; all smoothed."""
    asked = (record.designed_mps2 > 0.0).astype(np.float64)
    return smoothed_wave(record.designed_mps2), smoothed_wave(record.actual_mps2), smoothed_wave(asked)


@compiled
def misfit(
    designed: Wave, actual: Wave, asked: Wave, first: int, last: int, shift: int, offset_mps2: float
) -> float:
    """J: mean over `first`..`last` of (actual `shift` steps later - offset - designed)^2, (m/s^2)^2."""
    total = 0.0
    for i in range(first, last):
        difference = actual[i + shift] - offset_mps2 * asked[i] - designed[i]
        total += difference * difference
    return total / (last - first)


@compiled
def _best(designed: Wave, actual: Wave, asked: Wave, first: int, last: int) -> tuple[int, int, float]:
    """Place of the least J on the whole grid, and that J."""
    best_x, best_y, best_j = 0, 0, np.inf
    for x in range(DEAD_TIMES):
        for y in range(OFFSETS):
            j = misfit(designed, actual, asked, first, last, x, (y - OFFSET_ZERO) * OFFSET_STEP_MPS2)
            if j < best_j:
                best_x, best_y, best_j = x, y, j
    return best_x, best_y, best_j


def window(record: StopDecelerations) -> tuple[int, int] | None:
    """First and last step over which J is taken: from before the brake until every shift still sees braking.

    None where the stop is too short for that, or the brake was never applied.
    """
    applied = np.flatnonzero(record.designed_mps2 > 0.0)
    if applied.size == 0:
        return None
    first = max(0, int(applied[0]) - round(LEAD_S / STEP_S))
    last = record.designed_mps2.size - DEAD_TIMES - round(SMOOTHING_S / STEP_S / 2.0)
    return (first, last) if last - int(applied[0]) >= round(BRAKING_LEAST_S / STEP_S) else None


def search(record: StopDecelerations) -> CharacteristicFit | None:
    """The least J of all 441 points (総当たり法); None where the stop has no usable window."""
    span = window(record)
    if span is None:
        return None
    x, y, j = _best(*waves(record), *span)
    return CharacteristicFit(x, y, j, SEARCH_EVALUATIONS)


def quadratic_through(points: NDArray[np.float64], values: NDArray[np.float64]) -> Quadratic:
    """Coefficients of equation 5 through six points (shape (6, 2)) and their J (shape (6,)): equations 6 to 10."""
    x, y = points[:, 0], points[:, 1]
    matrix = np.stack((x * x, y * y, x, y, x * y, np.ones(6)), axis=1)
    return Quadratic(*(float(value) for value in np.linalg.solve(matrix, values)))


def minimum_of(z: Quadratic) -> tuple[float, float] | None:
    """Where equation 11 holds, by equation 13; None where Z has no minimum there.

    The paper found J convex beforehand and leaves the test out; a disturbed stop need not be.
    """
    determinant = z.e * z.e - 4.0 * z.a * z.b
    if determinant >= 0.0 or z.a <= 0.0:
        return None
    return (2.0 * z.b * z.c - z.d * z.e) / determinant, (2.0 * z.a * z.d - z.c * z.e) / determinant


def approximate(record: StopDecelerations, centre: tuple[int, int]) -> CharacteristicFit | None:
    """The least J by six points and the quadratic through them (近似関数法).

    `centre` is a place on the grid near what is expected: the designed dead time and no offset for a new train,
    then what it has learned. None where the window or the minimum is missing. The misfit is that of Z.
    """
    span = window(record)
    if span is None:
        return None
    smooth = waves(record)
    x0 = min(max(centre[0], REACH_X), DEAD_TIMES - 1 - REACH_X)
    y0 = min(max(centre[1], REACH_Y), OFFSETS - 1 - REACH_Y)
    points = np.array(SIX_POINTS, dtype=np.float64)
    values = np.array(
        [misfit(*smooth, *span, x0 + dx, (y0 + dy - OFFSET_ZERO) * OFFSET_STEP_MPS2) for dx, dy in SIX_POINTS]
    )
    z = quadratic_through(points, values)
    found = minimum_of(z)
    if found is None:
        return None
    p, q = found
    least = z.f + (z.c * p + z.d * q) / 2.0
    x = min(max(round(x0 + p), 0), DEAD_TIMES - 1)
    y = min(max(round(y0 + q), 0), OFFSETS - 1)
    return CharacteristicFit(x, y, max(least, 0.0), len(SIX_POINTS))


@dataclass(frozen=True, slots=True)
class Learned:
    """What one train has learned: how many stops fell on each place of the grid, and how many were left out.

    `design_dead_time_s` stands until the first stop is counted.
    """

    train_id: str
    design_dead_time_s: float
    dead_time_counts: tuple[int, ...] = (0,) * DEAD_TIMES
    offset_counts: tuple[int, ...] = (0,) * OFFSETS
    left_out: int = 0
    last: tuple[int, int] | None = None  # the last stop's place, where the next one's six points lie

    @property
    def stops(self) -> int:
        """Stops counted."""
        return sum(self.dead_time_counts)

    @property
    def dead_time_s(self) -> float:
        """Mode of the dead time, s: for the prediction."""
        return _mode(self.dead_time_counts) * STEP_S if self.stops else self.design_dead_time_s

    @property
    def offset_mps2(self) -> float:
        """Mode of the deceleration offset, m/s^2: for the bias of the brake command."""
        return (_mode(self.offset_counts) - OFFSET_ZERO) * OFFSET_STEP_MPS2 if self.stops else 0.0

    @property
    def centre(self) -> tuple[int, int]:
        """Place on the grid around which the approximation of the next stop is made."""
        if self.last is not None:
            return self.last
        return round(self.design_dead_time_s / STEP_S), OFFSET_ZERO

    def as_dict(self) -> dict[str, object]:
        """What the caller keeps between days (JSON or TOML)."""
        return {
            "train_id": self.train_id,
            "design_dead_time_s": self.design_dead_time_s,
            "dead_time_counts": list(self.dead_time_counts),
            "offset_counts": list(self.offset_counts),
            "left_out": self.left_out,
            "last": list(self.last or ()),
        }


def learned_from(file: str, kept: Mapping[str, object]) -> Learned:
    """What `Learned.as_dict` wrote; `file` is named in an InputError."""
    train_id, dead_time_s, left_out = (
        kept.get(key) for key in ("train_id", "design_dead_time_s", "left_out")
    )
    if not isinstance(train_id, str):
        raise InputError(file, "train_id", train_id, "the train's name")
    if not isinstance(dead_time_s, int | float) or not 0.0 <= dead_time_s <= (DEAD_TIMES - 1) * STEP_S:
        raise InputError(file, "design_dead_time_s", dead_time_s, "0 to 2 seconds")
    if not _is_count(left_out):
        raise InputError(file, "left_out", left_out, "a count of stops")
    dead_times = _counts(file, "dead_time_counts", kept.get("dead_time_counts"), DEAD_TIMES)
    offsets = _counts(file, "offset_counts", kept.get("offset_counts"), OFFSETS)
    if sum(dead_times) != sum(offsets):
        raise InputError(
            file, "offset_counts", sum(offsets), f"as many stops as dead times, {sum(dead_times)}"
        )
    last = kept.get("last")
    place = _counts(file, "last", last, 2) if last else None
    if place is not None and max(place) >= DEAD_TIMES:
        raise InputError(file, "last", last, "two places on the grid, 0 to 20")
    return Learned(
        train_id,
        float(dead_time_s),
        dead_times,
        offsets,
        int(str(left_out)),
        None if place is None else (place[0], place[1]),
    )


def disturbance(record: StopDecelerations, fit: CharacteristicFit | None) -> str | None:
    """Why a stop says nothing lasting about the train (外乱); None where it does."""
    if record.slid:
        return "slide"
    if record.load_share > LOAD_SHARE_MAX:
        return "load"
    if fit is None:
        return "no minimum"
    if fit.misfit_mps2_squared > MISFIT_MAX_MPS2**2:
        return "misfit"
    return None


def learned_after_stop(learned: Learned, record: StopDecelerations, fit: CharacteristicFit | None) -> Learned:
    """What the train knows after one more stop, fitted by `search` or `approximate`."""
    if fit is None or disturbance(record, fit) is not None:
        return replace(learned, left_out=learned.left_out + 1)
    return replace(
        learned,
        dead_time_counts=_counted(learned.dead_time_counts, fit.dead_time_index),
        offset_counts=_counted(learned.offset_counts, fit.offset_index),
        last=(fit.dead_time_index, fit.offset_index),
    )


def _mode(counts: tuple[int, ...]) -> int:
    """Place of the highest count; of equals the middle one, so that a tie leans to neither side."""
    highest = max(counts)
    places = [index for index, count in enumerate(counts) if count == highest]
    return places[(len(places) - 1) // 2]


def _counted(counts: tuple[int, ...], index: int) -> tuple[int, ...]:
    return (*counts[:index], counts[index] + 1, *counts[index + 1 :])


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _counts(file: str, key: str, value: object, size: int) -> tuple[int, ...]:
    if not is_list(value) or len(value) != size or not all(_is_count(item) for item in value):
        raise InputError(file, key, value, f"{size} whole numbers of at least 0")
    return tuple(int(item) for item in value)
