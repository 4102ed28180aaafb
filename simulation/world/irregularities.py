"""The rails as laid: how far they point off the alignment, by kilometrage and track (通り変位).

Lateral alignment irregularity by the spectrum of ORE B 176 (one-sided, over the wave number O in rad/m),

    S(O) = A Oc^2 / ((O^2 + Or^2) (O^2 + Oc^2)),    Or = 0.0206, Oc = 0.8246 rad/m,

A = 2.119e-7 m rad for low, 6.125e-7 m rad for high disturbance; that of the heading is O^2 S(O), which falls to nothing
for long waves: a straight stays straight. Harada, Maki, Kazato and Ishiguri, section 3.3: waves over 50 m hardly change
in ten years (here they belong to the line alone), those under 25 m do from run to run (drawn by seed and day); those
between, which the paper leaves open, by the seed. Every path over a track meets the same rails, either way; a leg of
points goes over from those of the one track to those of the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.model import Line
from network.offsets import end_offsets_m
from network.path import Path
from radio.chance import generator
from simulation.sensor_settings import Rails

Floats = NDArray[np.float64]

LEVELS_M_RAD: Final = {Rails.STRAIGHT: 0.0, Rails.LOW: 2.119e-7, Rails.HIGH: 6.125e-7}
LONG_RADPM: Final = 0.0206
SHORT_RADPM: Final = 0.8246
LASTING_M: Final = 50.0  # longer waves stay with the line
FLEETING_M: Final = 25.0  # shorter ones change from run to run


def heading_density(wave_radpm: Floats, rails: Rails) -> Floats:
    """One-sided spectral density of the heading, rad^2 per rad/m, at wave numbers (rad/m)."""
    square = wave_radpm * wave_radpm
    level = LEVELS_M_RAD[rails] * SHORT_RADPM**2
    return level * square / ((square + LONG_RADPM**2) * (square + SHORT_RADPM**2))


@dataclass(frozen=True, slots=True)
class Irregularities:
    """Where the rails of a line point. `seed` and `today`: of the run."""

    line: Line
    rails: Rails
    seed: int
    today: tuple[str, ...] = ()
    _laid: dict[tuple[str, float], Floats] = field(default_factory=dict[tuple[str, float], Floats])

    def on_path_rad(self, path: Path) -> Floats:
        """How far the rails point to the right of the alignment's track, as trains see it, at every metre of a path."""
        count = math.ceil(path.length_m) + 1
        at_m = np.minimum(np.arange(count, dtype=np.float64), path.length_m)
        points_rad = np.zeros(count)
        for step in path.steps:
            last = step is path.steps[-1]
            here = slice(math.ceil(step.start_m), count if last else math.ceil(step.end_m))
            kilometrage_m = step.entry_m + step.direction * (at_m[here] - step.start_m)
            points_rad[here] = self.on_piece_rad(step.piece_id, kilometrage_m)
        return points_rad

    def on_piece_rad(self, piece_id: str, kilometrage_m: Floats) -> Floats:
        """The same at kilometrages (m) of a piece. A track's bearing is the same either way, so is this."""
        piece = self.line.pieces[piece_id]
        low_m, high_m = end_offsets_m(self.line, piece)
        alignment = self.line.alignments[piece.alignment_id]
        at_m = kilometrage_m - alignment.from_m
        low = np.interp(
            at_m,
            np.arange(0.0, self._track(piece.alignment_id, low_m).size),
            self._track(piece.alignment_id, low_m),
        )
        if high_m == low_m:
            return np.asarray(low, dtype=np.float64)
        other = self._track(piece.alignment_id, high_m)
        high = np.interp(at_m, np.arange(0.0, other.size), other)
        share = (kilometrage_m - piece.from_m) / piece.length_m
        return np.asarray(low + share * (high - low), dtype=np.float64)

    def _track(self, alignment_id: str, offset_m: float) -> Floats:
        """At every metre of the alignment, for the track at a lateral offset from it."""
        key = (alignment_id, round(offset_m, 3))
        if key not in self._laid:
            alignment = self.line.alignments[alignment_id]
            metres = math.ceil(alignment.to_m - alignment.from_m) + 2
            names = ("rails", self.line.id, alignment_id, f"{key[1]:.3f}")
            layers = (
                (math.inf, LASTING_M, generator(0, *names)),
                (LASTING_M, FLEETING_M, generator(self.seed, *names)),
                (FLEETING_M, 0.0, generator(self.seed, *names, "of the day", *self.today)),
            )
            self._laid[key] = np.sum(
                [_drawn_rad(metres, self.rails, longest, shortest, rng) for longest, shortest, rng in layers],
                axis=0,
            )
        return self._laid[key]


def _drawn_rad(
    metres: int, rails: Rails, longest_m: float, shortest_m: float, rng: np.random.Generator
) -> Floats:
    """Headings (rad) a metre apart with the spectrum between two wavelengths (m): white noise, coloured."""
    count = 1 << (metres - 1).bit_length()
    waves_radpm = np.arange(count // 2 + 1, dtype=np.float64) * (2.0 * math.pi / count)
    white = np.fft.rfft(rng.standard_normal(count))
    # one-sided over rad/m; white noise of variance 1 a metre has 1 / pi
    shape = np.sqrt(math.pi * heading_density(waves_radpm, rails))
    shape[waves_radpm <= 2.0 * math.pi / longest_m] = 0.0
    if shortest_m > 0.0:
        shape[waves_radpm > 2.0 * math.pi / shortest_m] = 0.0
    return np.asarray(np.fft.irfft(white * shape, count)[:metres], dtype=np.float64)
