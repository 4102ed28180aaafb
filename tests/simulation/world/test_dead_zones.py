"""Stretches that the radio does not reach: on all tracks beside each other, and nowhere else."""

from network.model import Direction
from network.path import path_of
from simulation.faults.links import LineStretch
from simulation.setup import Setup
from simulation.world.dead_zones import DeadZonesInForce


def test_a_front_is_hidden_within_the_stretch_on_either_track_and_not_beyond(karasuyama_setup: Setup) -> None:
    line = karasuyama_setup.line
    zones = DeadZonesInForce(line)
    sections = [line.sections[name] for name in ("OGN.1", "OGN.2")]
    piece = line.pieces[sections[0].piece_ids[0]]
    length_m = 0.25 * (piece.to_m - piece.from_m)
    zones.put_stretches("OGN.1", (LineStretch("OGN.1", 0.5, length_m),))
    for section in sections:
        own = line.pieces[section.piece_ids[0]]
        path = path_of(line, section.piece_ids, Direction.DOWN)
        for share, hidden in ((0.49, False), (0.51, True), (0.74, True), (0.76, False)):
            at_m = piece.from_m + share * (piece.to_m - piece.from_m)
            assert zones.hides(path, path.to_path_m(own.id, at_m)) is hidden
    zones.put_stretches("OGN.1", ())
    path = path_of(line, sections[0].piece_ids, Direction.DOWN)
    assert not zones.hides(path, path.to_path_m(piece.id, piece.from_m + 0.6 * (piece.to_m - piece.from_m)))
