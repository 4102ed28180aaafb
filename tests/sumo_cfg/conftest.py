"""A passing loop made by hand on a circle of known radius, and where its kilometrages lie."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from network.model import (
    Alignment,
    Direction,
    Gradient,
    Line,
    Piece,
    Points,
    PointsLeg,
    Position,
    Section,
    SectionKind,
)

RADIUS_M = 400.0
LOOP_OFFSET_M = 4.0
GRADIENTS = (Gradient(0.0, 303.0, 10.0), Gradient(303.0, 700.0, 0.0), Gradient(700.0, 1000.123456, -15.0))

Array = NDArray[np.float64]


def elevation_m(alignment: Alignment, kilometrage_m: float) -> float:
    """Elevation (m) summed over the gradient table, by its definition."""
    rise = sum(
        max(0.0, min(kilometrage_m, g.to_m) - g.from_m) * g.permille / 1000.0 for g in alignment.gradients
    )
    return alignment.elevation_m + rise


def circle(alignment: Alignment, kilometrage_m: Array, offset_m: float = 0.0, /) -> Array:
    """A circle of RADIUS_M to the right, from the origin eastwards; its centre is (0, -RADIUS_M)."""
    angle, radius_m = kilometrage_m / RADIUS_M, RADIUS_M - offset_m
    z = [elevation_m(alignment, float(m)) for m in kilometrage_m]
    return np.column_stack((radius_m * np.sin(angle), radius_m * np.cos(angle) - RADIUS_M, z))


def passing_loop() -> Line:
    """A single track with two tracks between two sets of points, 1000.123456 m long."""
    alignment = Alignment("a", 0.0, 1000.123456, 0.0, 0.0, 90.0, 50.0, GRADIENTS, (), (), ())
    pieces = (
        Piece("west", "west", "a", 0.0, 300.0, "w", "j1"),
        Piece("stem1", "p1", "a", 300.0, 310.0, "j1", "t1", points_id="1", leg=PointsLeg.STEM),
        Piece("normal1", "p1", "a", 310.0, 340.0, "t1", "n1", points_id="1", leg=PointsLeg.NORMAL),
        Piece("reverse1", "p1", "a", 310.0, 340.0, "t1", "r1", LOOP_OFFSET_M, "1", PointsLeg.REVERSE),
        Piece("track1", "track1", "a", 340.0, 600.0, "n1", "n2"),
        Piece("track2", "track2", "a", 340.0, 600.0, "r1", "r2", LOOP_OFFSET_M),
        Piece("normal2", "p2", "a", 600.0, 630.0, "n2", "t2", points_id="2", leg=PointsLeg.NORMAL),
        Piece("reverse2", "p2", "a", 600.0, 630.0, "r2", "t2", LOOP_OFFSET_M, "2", PointsLeg.REVERSE),
        Piece("stem2", "p2", "a", 630.0, 640.0, "t2", "j2", points_id="2", leg=PointsLeg.STEM),
        Piece("east", "east", "a", 640.0, 1000.123456, "j2", "e"),
    )
    points = (
        Points("1", "p1", "T1", "t1", Direction.DOWN, "stem1", "normal1", "reverse1", 5.0, 10.0),
        Points(
            "2", "p2", "T2", "t2", Direction.UP, "stem2", "normal2", "reverse2", 5.0, 10.0, Position.NORMAL
        ),
    )
    kinds = {"p1": SectionKind.POINTS, "p2": SectionKind.POINTS}
    kinds |= {"track1": SectionKind.TRACK, "track2": SectionKind.TRACK}
    sections = {
        s: Section(s, kinds.get(s, SectionKind.BETWEEN), tuple(p.id for p in pieces if p.section_id == s))
        for s in dict.fromkeys(p.section_id for p in pieces)
    }
    return Line(
        id="hand",
        name="Hand-made",
        name_ja="",
        max_speed_mps=25.0,
        stations={},
        alignments={"a": alignment},
        sections=sections,
        pieces={p.id: p for p in pieces},
        points={p.id: p for p in points},
        tags={},
        assumed=(),
    )


@pytest.fixture(scope="session")
def line() -> Line:
    return passing_loop()


@pytest.fixture(scope="session")
def positions() -> Callable[..., Array]:
    return circle


@pytest.fixture(scope="session")
def with_gradient() -> Callable[[Line, float], Line]:
    """The same line with another first gradient, permille."""

    def change(line: Line, permille: float) -> Line:
        alignment = line.alignments["a"]
        gradients = (replace(alignment.gradients[0], permille=permille), *alignment.gradients[1:])
        return replace(line, alignments={"a": replace(alignment, gradients=gradients)})

    return change


@pytest.fixture(scope="session")
def elevation() -> Callable[[Alignment, float], float]:
    return elevation_m
