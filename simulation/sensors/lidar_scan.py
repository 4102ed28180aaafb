"""A LiDAR that scans without repeating (非反復走査), and what it sees of reflective markers between the rails.

A stack of beams sweeps fast across the field and nods slowly, at frequencies without a common measure, so that no two
figures are alike. Each shot goes out at its own time, from where the train then is. Distances run forwards from the
LiDAR along the track, x ahead and y to the left of the track's middle. Other surfaces than markers and track are left
out: none stands between the rails.

Mochizuki, Kudo and Yamaguchi, sections 2.1 and 4.1; Livox Horizon user manual v1.0 (2019), specifications; how the
maker counts what a scan has covered: issue 57 of its repository Livox-SDK.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.marker_patterns import COLUMN_M, COLUMNS, MARKERS, ROWS, is_marked
from vehicle.compiled import compiled
from vehicle.record import dtype_of

Floats = NDArray[np.float64]

WHITE: Final = (
    150.0  # reading of a white surface that scatters evenly; what is above returns to where it came from
)
BRIGHTEST: Final = 255.0
LOOKS_EVERY: Final = 24  # shots from one geometry of the markers to the next: 0.1 ms
POINTS_MAX: Final = 60_000
FWHM_OF_SIGMA: Final = 2.0 * math.sqrt(2.0 * math.log(2.0))
BEAM_EDGE_SIGMAS: Final = 4.0  # beyond them no beam brings back what counts


@dataclass(frozen=True, slots=True)
class Scanner:
    """A LiDAR of the class of Livox Horizon; figures of its manual unless another origin is named."""

    field_deg: tuple[float, float] = (81.7, 25.1)  # horizontal, vertical
    points_per_s: float = 240_000.0
    range_sigma_m: float = 0.02  # 1 sigma at 20 m
    angle_sigma_deg: float = 0.05  # "below 0.05 degrees"
    # of a beam, horizontal and vertical, taken as its half width
    divergence_deg: tuple[float, float] = (0.03, 0.28)
    beams: int = 6  # lines in the driver's records of this model
    # assumed: about as fast as a prism of its Mid-40 (7294/min; Liu, Wu and Zhang 2022), and by the golden ratio away
    # from any that would repeat. 0.1 s leave lines 0.3 degrees apart (the maker: 0.2 to 0.4), 0.5 s cover 98 % (2.1).
    shots_a_sweep: float = 329.618  # there and back, of one beam
    sweeps_a_nod: float = 10.691
    beam_gap_deg: float = 0.56

    @property
    def volley_s(self) -> float:
        """From one shot of a beam to its next."""
        return self.beams / self.points_per_s

    @property
    def sweep_hz(self) -> float:
        """How often it sweeps there and back."""
        return 1.0 / (self.shots_a_sweep * self.volley_s)

    @property
    def nod_hz(self) -> float:
        """How often it nods."""
        return self.sweep_hz / self.sweeps_a_nod


@dataclass(frozen=True, slots=True)
class Mount:
    """Where it is on the train (4.1): above the track, left of the middle, pitched down."""

    height_m: float = 1.870
    left_m: float = 0.279
    pitch_down_deg: float = 12.5
    setback_m: float = 0.5  # behind the train's front; assumed: behind the windscreen


@dataclass(frozen=True, slots=True)
class Plate:
    """One marker (ターゲットマーカ); assumed, the paper gives none: a square of the sheeting that road signs have.

    It stands upright: from 5 to 30 m light meets it within 21 degrees, such sheeting is made for 45, and it stays below
    the rails' heads. The side is such that hardly a tenth of a second goes by from 30 m on without a point on any
    marker: with 100 mm one passage in six has one, then loses way (equation 3).
    """

    side_m: float = 0.15
    lean_deg: float = 90.0  # of the face over the track
    # cd/lx/m2: white, class RA2 of EN 12899-1 at 12 minutes and 30 degrees
    retroreflection: float = 150.0

    @property
    def gain(self) -> float:
        """How much more it returns than a white surface that scatters evenly."""
        return math.pi * self.retroreflection


HORIZON: Final = Scanner()
TRAM_MOUNT: Final = Mount()
SIGN_SHEETING: Final = Plate()
TRACK_READING: Final = 15.0  # of ballast and asphalt, about 10 % of white; assumed
SWAY_SIGMA_M: Final = (
    0.02  # by which a train runs beside the track's middle; assumed: half the play of wheels
)


class ScanRow(Protocol):
    """Scanner, mount and plates, as compiled code takes them; angles in rad."""

    half_azimuth: float
    half_elevation: Annotated[float, "of the nodding; the stack of beams adds to it"]
    shot_s: float
    range_sigma_m: float
    angle_sigma: float
    beam_azimuth: Annotated[float, "sigma of a beam"]
    beam_elevation: float
    sweep_turn: Annotated[float, "rad a volley of all beams"]
    nod_turn: float
    beams: int
    beam_gap: float
    height_m: float
    left_m: float
    pitch_cos: float
    pitch_sin: float
    half_side_m: float
    lean_cos: float
    lean_sin: float
    gain: float
    least_reading: Annotated[float, "points that read no more are left out"]


SCAN: Final = dtype_of(ScanRow)


class MarkerMotion(NamedTuple):
    """How the train runs at the markers: from the LiDAR to the first row at time 0 (m), m/s, m/s2."""

    from_m: float
    speed_mps: float
    acceleration_mps2: float


class ScanPoints(NamedTuple):
    """What it returns: when each point was taken (s), where (m), its reading (0 to 255); in order of time."""

    time_s: Floats
    x_m: Floats
    y_m: Floats
    reading: Floats


def scan_row(
    scanner: Scanner = HORIZON,
    mount: Mount = TRAM_MOUNT,
    plate: Plate = SIGN_SHEETING,
    least_reading: float = WHITE,
) -> ScanRow:
    """The row of a scanner on a train, for markers of a kind."""
    row: ScanRow = cast("ScanRow", np.zeros(1, SCAN).view(np.recarray)[0])
    stack_deg = (scanner.beams - 1) / 2.0 * scanner.beam_gap_deg
    row.half_azimuth = math.radians(scanner.field_deg[0] / 2.0)
    row.half_elevation = math.radians(scanner.field_deg[1] / 2.0 - stack_deg)
    row.shot_s = 1.0 / scanner.points_per_s
    row.range_sigma_m, row.angle_sigma = scanner.range_sigma_m, math.radians(scanner.angle_sigma_deg)
    row.beam_azimuth = math.radians(scanner.divergence_deg[0]) / FWHM_OF_SIGMA
    row.beam_elevation = math.radians(scanner.divergence_deg[1]) / FWHM_OF_SIGMA
    row.sweep_turn = 2.0 * math.pi * scanner.sweep_hz * scanner.volley_s
    row.nod_turn = 2.0 * math.pi * scanner.nod_hz * scanner.volley_s
    row.beams, row.beam_gap = scanner.beams, math.radians(scanner.beam_gap_deg)
    row.height_m, row.left_m = mount.height_m, mount.left_m
    row.pitch_cos = math.cos(math.radians(mount.pitch_down_deg))
    row.pitch_sin = math.sin(math.radians(mount.pitch_down_deg))
    row.half_side_m = plate.side_m / 2.0
    row.lean_cos, row.lean_sin = (
        math.cos(math.radians(plate.lean_deg)),
        math.sin(math.radians(plate.lean_deg)),
    )
    row.gain, row.least_reading = plate.gain, least_reading
    return row


def marker_places(pattern: int, spacing_m: float) -> Floats:
    """Places of a pattern's markers (MARKERS, 2): behind the first row and left of the middle, m."""
    places = [
        (row * spacing_m, (column - (COLUMNS - 1) / 2.0) * COLUMN_M)
        for row in range(ROWS)
        for column in range(COLUMNS)
        if is_marked(pattern, row, column)
    ]
    assert len(places) == MARKERS
    return np.array(places, dtype=np.float64)


def coverage(scanner: Scanner, time_s: float, begins_s: float = 0.0, cell_rad: float = 5e-3) -> float:
    """Share of the field that has been hit after a time, in cells of 5 mrad, as the maker counts it."""
    shots = np.arange(round(time_s * scanner.points_per_s))
    at_s = begins_s + shots / scanner.points_per_s
    half_x, half_y = (math.radians(deg / 2.0) for deg in scanner.field_deg)
    stack = (np.arange(scanner.beams) - (scanner.beams - 1) / 2.0) * math.radians(scanner.beam_gap_deg)
    x = half_x * np.sin(2.0 * np.pi * scanner.sweep_hz * at_s)
    y = (half_y - stack[-1]) * np.sin(2.0 * np.pi * scanner.nod_hz * at_s) + stack[shots % scanner.beams]
    columns, rows = math.ceil(2.0 * half_x / cell_rad), math.ceil(2.0 * half_y / cell_rad)
    hit = np.zeros((columns, rows), dtype=bool)
    i, j = ((x + half_x) / cell_rad).astype(int), ((y + half_y) / cell_rad).astype(int)
    hit[np.clip(i, 0, columns - 1), np.clip(j, 0, rows - 1)] = True
    return float(hit.mean())


def scan(
    row: ScanRow,
    markers_m: Floats,
    motion: MarkerMotion,
    duration_s: float,
    rng: np.random.Generator,
) -> ScanPoints:
    """Points of a passage, from time 0 on; `markers_m` as `laid` gives them. `rng` draws phases, sway and noise."""
    points = np.empty((4, POINTS_MAX))
    sway_m = SWAY_SIGMA_M * float(rng.standard_normal())
    phases = rng.uniform(0.0, 2.0 * np.pi, 2)
    count = _scanned(
        row, markers_m, motion, duration_s, (float(phases[0]), float(phases[1]), sway_m), rng, points
    )
    if count > POINTS_MAX:
        raise ValueError(f"more than {POINTS_MAX} points in a passage of {duration_s:g} s")
    return ScanPoints(*points[:, :count].copy())


@compiled
def distance_m(motion: MarkerMotion, at_s: float) -> float:
    """From the LiDAR to the first row at a time."""
    return motion.from_m - motion.speed_mps * at_s - 0.5 * motion.acceleration_mps2 * at_s * at_s


@compiled
def _share(offset: float, half: float, sigma: float) -> float:
    """Share of a beam whose middle is `offset` beside a target's that falls on the target."""
    scale = 1.0 / (sigma * math.sqrt(2.0))
    return 0.5 * (math.erf((offset + half) * scale) - math.erf((offset - half) * scale))


@compiled
def _directions(row: ScanRow, markers_m: Floats, ahead_m: float, sway_m: float, seen: Floats) -> None:
    """Fill `seen` (n, 6) for each marker: azimuth, elevation from the axis, range, half sizes, foreshortening.

    Angles in rad; a marker that lies behind the LiDAR has range 0.
    """
    for k in range(markers_m.shape[0]):
        x_m, y_m = ahead_m + markers_m[k, 0], markers_m[k, 1] + sway_m - row.left_m
        z_m = row.half_side_m * row.lean_sin - row.height_m
        forward_m = x_m * row.pitch_cos - z_m * row.pitch_sin
        up_m = x_m * row.pitch_sin + z_m * row.pitch_cos
        range_m = math.sqrt(x_m * x_m + y_m * y_m + z_m * z_m)
        if x_m < 0.5:
            seen[k, 2] = 0.0
            continue
        seen[k, 0] = math.atan2(y_m, forward_m)
        seen[k, 1] = math.atan2(up_m, math.sqrt(forward_m * forward_m + y_m * y_m))
        seen[k, 2] = range_m
        # sine of the angle between face and sight: lean plus depression
        foreshortened = (row.lean_sin * x_m - row.lean_cos * z_m) / range_m
        seen[k, 3] = row.half_side_m / range_m
        seen[k, 4] = row.half_side_m * foreshortened / range_m
        seen[k, 5] = foreshortened


@compiled
def _box(row: ScanRow, seen: Floats, box: Floats) -> None:
    """Azimuths and elevations (rad) within which a shot may meet any marker."""
    box[0], box[1], box[2], box[3] = np.inf, -np.inf, np.inf, -np.inf
    side, above = BEAM_EDGE_SIGMAS * row.beam_azimuth, BEAM_EDGE_SIGMAS * row.beam_elevation
    for k in range(seen.shape[0]):
        if seen[k, 2] > 0.0:
            box[0] = min(box[0], seen[k, 0] - seen[k, 3] - side)
            box[1] = max(box[1], seen[k, 0] + seen[k, 3] + side)
            box[2] = min(box[2], seen[k, 1] - seen[k, 4] - above)
            box[3] = max(box[3], seen[k, 1] + seen[k, 4] + above)


@compiled
def _strongest(row: ScanRow, seen: Floats, azimuth: float, elevation: float) -> tuple[int, float]:
    """The marker that returns most of a shot, -1 for none, and how much over a white surface."""
    best, most = -1, 0.0
    for k in range(seen.shape[0]):
        if seen[k, 2] <= 0.0:
            continue
        above = elevation - seen[k, 1]
        if abs(above) > seen[k, 4] + BEAM_EDGE_SIGMAS * row.beam_elevation:
            continue
        share = _share(azimuth - seen[k, 0], seen[k, 3], row.beam_azimuth)
        share *= _share(above, seen[k, 4], row.beam_elevation)
        if share * row.gain > most:
            best, most = k, share * row.gain
    return best, most


@compiled
def _reading(row: ScanRow, over_white: float) -> float:
    """What the scanner reads: linear up to white, then by the logarithm up to the brightest (assumed)."""
    if over_white <= 1.0:
        return WHITE * over_white
    return min(WHITE + (BRIGHTEST - WHITE) * math.log(over_white) / math.log(row.gain), BRIGHTEST)


@compiled
def _range_m(
    row: ScanRow, marker_m: Floats, seen: Floats, ahead_m: float, offsets: tuple[float, float, float]
) -> float:
    """Range of a shot (m): to where it meets the marker, or the marker's edge. `offsets`: azimuth, elevation, sway."""
    along = offsets[1] * seen[2] / seen[5]
    along = min(max(along, -row.half_side_m), row.half_side_m)
    side = min(max(offsets[0] * seen[2], -row.half_side_m), row.half_side_m)
    x_m = ahead_m + marker_m[0] + along * row.lean_cos
    y_m = marker_m[1] + offsets[2] - row.left_m + side
    z_m = (row.half_side_m + along) * row.lean_sin - row.height_m
    return math.sqrt(x_m * x_m + y_m * y_m + z_m * z_m)


@compiled
def _placed(row: ScanRow, azimuth: float, elevation: float, range_m: float) -> tuple[float, float]:
    """Forwards along the track and left of its middle (m), by a shot's angles and range."""
    forward_m = range_m * math.cos(elevation) * math.cos(azimuth)
    up_m = range_m * math.sin(elevation)
    left_m = range_m * math.cos(elevation) * math.sin(azimuth)
    return forward_m * row.pitch_cos + up_m * row.pitch_sin, left_m + row.left_m


@compiled
def _track_range_m(row: ScanRow, azimuth: float, elevation: float) -> float:
    """Range of a shot that meets the track, m; 0: it goes over it."""
    down = math.cos(elevation) * math.cos(azimuth) * row.pitch_sin - math.sin(elevation) * row.pitch_cos
    return row.height_m / down if down > 1e-3 else 0.0


@compiled
def _scanned(
    row: ScanRow,
    markers_m: Floats,
    motion: MarkerMotion,
    duration_s: float,
    begins: tuple[float, float, float],
    rng: np.random.Generator,
    points: Floats,
) -> int:
    """Fill `points` (4, POINTS_MAX) and count them, those too that do not fit.

    `begins`: phases of sweep and nod (rad), sway (m).
    """
    seen, box = np.zeros((markers_m.shape[0], 6)), np.zeros(4)
    sweep, nod, sway_m = begins
    count, since = 0, LOOKS_EVERY
    ahead_m = motion.from_m
    for volley in range(int(duration_s / (row.beams * row.shot_s))):
        sweep, nod = (sweep + row.sweep_turn) % (2.0 * np.pi), (nod + row.nod_turn) % (2.0 * np.pi)
        if since >= LOOKS_EVERY:
            ahead_m = distance_m(motion, volley * row.beams * row.shot_s)
            _directions(row, markers_m, ahead_m, sway_m, seen)
            _box(row, seen, box)
            since = 0
        since += row.beams
        middle = row.half_elevation * math.sin(nod)
        if (
            middle + 0.5 * row.beams * row.beam_gap < box[2]
            or middle - 0.5 * row.beams * row.beam_gap > box[3]
        ):
            continue
        for beam in range(row.beams):
            azimuth = row.half_azimuth * math.sin(sweep + row.sweep_turn * beam / row.beams)
            elevation = middle + (beam - 0.5 * (row.beams - 1)) * row.beam_gap
            if not (box[2] <= elevation <= box[3] and box[0] <= azimuth <= box[1]):
                continue
            k, over_white = _strongest(row, seen, azimuth, elevation)
            reading = max(_reading(row, over_white), TRACK_READING)
            if reading <= row.least_reading:
                continue
            if reading > TRACK_READING:
                offsets = (azimuth - seen[k, 0], elevation - seen[k, 1], sway_m)
                range_m = _range_m(row, markers_m[k], seen[k], ahead_m, offsets)
            else:
                range_m = _track_range_m(row, azimuth, elevation)
            if count < POINTS_MAX:
                range_m += row.range_sigma_m * rng.standard_normal()
                shown = azimuth + row.angle_sigma * rng.standard_normal()
                raised = elevation + row.angle_sigma * rng.standard_normal()
                points[0, count] = (volley * row.beams + beam) * row.shot_s
                points[1, count], points[2, count] = _placed(row, shown, raised, range_m)
                points[3, count] = reading
            count += 1
    return count
