"""The small line of these tests: a portal, two tracks at A, the halt H, two tracks at B."""

from pathlib import Path
from typing import Final

from network.files.line_file import parse_line
from network.model import Line
from network.path import Path as Way

SAMPLE_FILE: Final = Path(__file__).with_name("sample_line.toml")
SAMPLE: Final = SAMPLE_FILE.read_text("utf-8")
LINE: Final[Line] = parse_line(SAMPLE, "sample.toml")


def changed(old: str, new: str, count: int = 1) -> str:
    """Its file with the first `count` places of `old` replaced; fails when there is none."""
    assert old in SAMPLE, old
    return SAMPLE.replace(old, new, count)


def gradient_permille_at(line: Line, path: Way, path_m: float) -> float:
    """Gradient (permille) at a path coordinate (m), positive where the train climbs."""
    step = path.step_at(path_m)
    kilometrage_m = step.kilometrage_m(path_m)
    gradients = line.alignments[line.pieces[step.piece_id].alignment_id].gradients
    for gradient in gradients:
        if kilometrage_m < gradient.to_m:
            return gradient.permille * step.direction
    return gradients[-1].permille * step.direction


def curvature_at(line: Line, path: Way, path_m: float) -> float:
    """Curvature (1/m) at a path coordinate (m), positive where the train turns to the right."""
    step = path.step_at(path_m)
    kilometrage_m = step.kilometrage_m(path_m)
    for curve in line.alignments[line.pieces[step.piece_id].alignment_id].curves:
        if curve.from_m <= kilometrage_m <= curve.to_m:
            from_end_m = min(kilometrage_m - curve.from_m, curve.to_m - kilometrage_m)
            share = min(from_end_m / curve.transition_m, 1.0) if curve.transition_m > 0 else 1.0
            return share * step.direction / curve.radius_m
    return 0.0
