"""Trains on a passing loop that meet in all ways, carried step for step by a carrier: what it says of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from hypothesis import strategies as st

from network.model import Direction, Line
from simulation.carriers.carrier import Carrier, Truth
from sumo_cfg.build import convert
from sumo_cfg.writer import write_plain
from tests.sumo_cfg.conftest import circle, passing_loop

STEP_S: Final = 0.1
STEPS: Final = 80
ENDS_M: Final = 1.0  # from the end of all track, where SUMO takes a train away
LINE: Final[Line] = passing_loop()
LENGTHS_M: Final = {piece.id: piece.length_m for piece in LINE.pieces.values()}
WAYS: Final = (
    ("west", "stem1", "normal1", "track1", "normal2", "stem2", "east"),
    ("west", "stem1", "reverse1", "track2", "reverse2", "stem2", "east"),
)


def net_in(folder: Path) -> Path:
    """The net of the loop."""
    net = folder / "loop.net.xml"
    net.write_bytes(convert(write_plain(LINE, circle), "loop"))
    return net


@dataclass(frozen=True)
class Going:
    """A train: its way, where its front is on it, m, and its speed at the end of each step.

    It turns where it stands before the step `turns_at`, if it then stands whole on one piece.
    """

    unit_id: str
    direction: Direction
    way: tuple[str, ...]
    front_m: float
    length_m: float
    speeds_mps: tuple[float, ...] = field(repr=False)
    asked: tuple[tuple[int, float], ...]  # the same, in steps and m/s
    turns_at: int | None = None

    @property
    def start(self) -> tuple[tuple[str, ...], float]:
        """The pieces from its front on, and the offset on the first."""
        offset_m, first = self.front_m, 0
        while offset_m >= LENGTHS_M[self.way[first]]:
            offset_m -= LENGTHS_M[self.way[first]]
            first += 1
        return self.way[first:], offset_m


def going(
    number: int,
    direction: Direction,
    side: int,
    front_m: float,
    length_m: float,
    *speeds: tuple[int, float],
    turns_at: int | None = None,
) -> Going:
    """A train as `Going`, its speeds as (steps, m/s) and then none."""
    flat = [mps for steps, mps in speeds for _ in range(steps)][:STEPS]
    flat += [0.0] * (STEPS - len(flat))
    way = WAYS[side] if direction is Direction.DOWN else tuple(reversed(WAYS[side]))
    end_m, at_m, before_mps = sum(LENGTHS_M[piece] for piece in way) - ENDS_M, front_m, 0.0
    for k, mps in enumerate(flat):
        at_m, before_mps = at_m + (before_mps + mps) / 2.0 * STEP_S, mps
        if at_m + mps * STEP_S > end_m:
            flat[k:] = [0.0] * (STEPS - k)
            break
    return Going(f"K{number}", direction, way, front_m, length_m, tuple(flat), speeds, turns_at)


SPEEDS: Final = st.lists(
    st.tuples(st.integers(1, 40), st.sampled_from((0.0, 0.3, 10.0)) | st.floats(0.0, 40.0)),
    min_size=1,
    max_size=6,
)
# Half of them about the loop, where ways part and join.
FRONTS_M: Final = st.floats(1.0, 980.0) | st.floats(250.0, 700.0)


@st.composite
def meetings(draw: st.DrawFn, trains: int = 2) -> tuple[Going, ...]:
    """Trains anywhere on the loop, one put on another too, that run anyhow; one may turn on a track after a while."""
    return tuple(draw(_going(number)) for number in range(trains))


@st.composite
def _going(draw: st.DrawFn, number: int) -> Going:
    direction, side = draw(st.sampled_from(Direction)), draw(st.sampled_from((0, 1)))
    length_m = draw(st.sampled_from((7.5, 18.0, 40.0)))
    if not draw(st.integers(0, 4)):
        stands = draw(st.integers(1, 40))
        front_m, speed_mps = draw(st.floats(450.0, 550.0)), draw(st.floats(0.0, 30.0))
        return going(
            number, direction, side, front_m, length_m, (stands, 0.0), (STEPS, speed_mps), turns_at=stands
        )
    return going(number, direction, side, draw(FRONTS_M), length_m, *draw(SPEEDS))


@dataclass(frozen=True)
class Came:
    """What a carrier says: after which step trains had collided (0: none), in what words, and where all were then.

    `turned_ahead`: one turned on a piece ahead of another that went that way already, which SUMO then has out of order.
    """

    step: int
    said: tuple[str, ...]
    truths: tuple[Truth, ...]
    turned_ahead: bool = field(default=False, compare=False)


def carried(carrier: Carrier, trains: Sequence[Going], stretch: int) -> Came:
    """The trains on a carrier, in stretches of so many steps; who stands is not told of, as in a run."""
    for train in trains:
        pieces, offset_m = train.start
        carrier.insert(train.unit_id, pieces, train.direction, offset_m, train.length_m)
    turns = {train.turns_at for train in trains if train.turns_at is not None}
    step, turned_ahead = 0, False
    while step < STEPS:
        for train in trains:
            if train.turns_at == step:
                here = carrier.truth(train.unit_id)
                back = train.way[train.way.index(here.piece_id) :: -1]
                carrier.reverse(train.unit_id, back, here.direction.opposite)
                turned_ahead |= _is_ahead(carrier, train, trains)
        steps = min([stretch, STEPS - step, *(turn - step for turn in turns if turn > step)])
        columns = []
        for train in trains:
            row = train.speeds_mps[step : step + steps]
            if any(row) or (step > 0 and train.speeds_mps[step - 1] > 0.0):
                columns.append((train.unit_id, row))
        if hit := carrier.run(columns, steps):
            return Came(step + hit, carrier.collisions(), _truths(carrier, trains), turned_ahead)
        step += steps
    return Came(0, (), _truths(carrier, trains), turned_ahead)


def _is_ahead(carrier: Carrier, turned: Going, trains: Sequence[Going]) -> bool:
    """On plain track alone, which turns it at once: SUMO does in its next step."""
    mine = carrier.truth(turned.unit_id)
    others = [carrier.truth(train.unit_id) for train in trains if train is not turned]
    return any(other[:2] == mine[:2] and other.offset_m < mine.offset_m for other in others)


def _truths(carrier: Carrier, trains: Sequence[Going]) -> tuple[Truth, ...]:
    return tuple(_rounded(carrier.truth(train.unit_id), train) for train in trains)


def _rounded(truth: Truth, train: Going) -> Truth:
    """A front on a joint is on the piece that it comes to, as on plain track; SUMO has it on the one before."""
    at, offset_m = train.way.index(truth.piece_id), round(truth.offset_m, 6)
    ahead = train.way[at + 1 :] if truth.direction is train.direction else train.way[:at][::-1]
    if ahead and offset_m == round(LENGTHS_M[truth.piece_id], 6):
        return Truth(ahead[0], truth.direction, 0.0, round(truth.speed_mps, 6))
    return Truth(truth.piece_id, truth.direction, offset_m, round(truth.speed_mps, 6))
