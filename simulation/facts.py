"""What the independent checkers are told of line and trains, besides the net: plain figures, by name."""

from __future__ import annotations

import math
from collections.abc import Collection

from network.files.crossings import least_closed_s, least_warning_s
from network.model import CrossingClass, Direction, Line, SectionKind
from network.profile import heights_of
from simulation.judge.body import Heights
from simulation.judge.checkers import Checkers, GuaranteedBrake, PointsFacts
from simulation.judge.crossings import CrossingFacts
from simulation.judge.entering import TrackOverlap
from simulation.judge.speed import LimitBetween, TrueLimits
from simulation.procedure import WorkingStep, before_entry
from simulation.setup import Setup, behaviour_row
from simulation.world.trains import SIGN
from sumo_cfg.truth_map import NetMap
from vehicle.mass import GRAVITY_MPS2


def checkers_of(setup: Setup, net: NetMap, stock_ids: Collection[str]) -> Checkers:
    """The checkers of a run, with the facts of its line and trains as they are, not as units believe them."""
    line = setup.line
    points = {
        p.id: PointsFacts(p.section_id, p.stem_piece, p.normal_piece, p.reverse_piece, p.initial)
        for p in line.points.values()
    }
    brakes = {stock_id: brake_of(setup, stock_id) for stock_id in stock_ids}
    share = setup.driving.design_adhesion_share
    heights, overlaps = edge_heights(line), track_overlaps(line)
    needs, crossings = pilots_needs(setup), crossing_facts(line)
    creep_mps = setup.unit.restricted_mps
    limits = true_limits(setup, stock_ids)
    return Checkers(
        net, points, stock_ids, brakes, heights, share, overlaps, needs, crossings, creep_mps, limits
    )


def true_limits(setup: Setup, stock_ids: Collection[str]) -> TrueLimits:
    """Speed limits by SUMO's edges: of the alignment, and of points where a train goes over their reverse leg."""
    line = setup.line
    found: dict[str, list[LimitBetween]] = {}
    for piece in line.pieces.values():
        for limit in line.alignments[piece.alignment_id].limits:
            down_m = limit.from_m - piece.from_m, limit.to_m - piece.from_m
            up_m = piece.to_m - limit.to_m, piece.to_m - limit.from_m
            for direction in (
                limit.directions if down_m[0] < piece.length_m and up_m[0] < piece.length_m else ()
            ):
                along_m = down_m if direction is Direction.DOWN else up_m
                found.setdefault(piece.id + SIGN[direction], []).append(
                    LimitBetween(*along_m, limit.speed_mps)
                )
    for points in line.points.values():
        diverging = LimitBetween(0.0, math.inf, points.diverging_limit_mps)
        for direction in Direction:
            found.setdefault(points.reverse_piece + SIGN[direction], []).append(diverging)
    kinds = {stock_id: setup.trains[stock_id].row[0] for stock_id in stock_ids}
    tops_mps = {i: min(line.max_speed_mps, float(kind["speed_max_mps"])) for i, kind in kinds.items()}
    return TrueLimits(found, tops_mps, setup.driving.emergency_margin_mps)


def crossing_facts(line: Line) -> dict[str, CrossingFacts]:
    """The level crossings that have a device, by SUMO's edges."""
    found: dict[str, CrossingFacts] = {}
    for crossing in (crossing for crossing in line.crossings.values() if crossing.has_device):
        piece, barriers = line.pieces[crossing.piece_id], crossing.kind is CrossingClass.BARRIERS
        begins_m = {
            crossing.piece_id + SIGN[direction]: abs(
                crossing.edge_m(direction) - (piece.from_m if direction is Direction.DOWN else piece.to_m)
            )
            for direction in Direction
        }
        found[crossing.id] = CrossingFacts(
            begins_m, barriers, least_warning_s(crossing), least_closed_s(crossing)
        )
    return found


def pilots_needs(setup: Setup) -> dict[str, tuple[WorkingStep, ...]]:
    """By section between stations, what must be done before a train comes in by the pilot's leave; else nothing."""
    if setup.substitute is None:
        return {}
    blocks = [s.id for s in setup.line.sections.values() if s.kind is SectionKind.BETWEEN]
    return {block: before_entry(setup.substitute.regime_of(block)) for block in blocks}


def track_overlaps(line: Line) -> dict[str, TrackOverlap]:
    """What must be clear beyond a train's stop on each track, by SUMO's edge."""
    found: dict[str, TrackOverlap] = {}
    for track in (track for station in line.stations.values() for track in station.tracks):
        piece = line.pieces[track.piece_id]
        for direction, overlap_m in track.overlaps_m.items():
            begin_m = piece.from_m if direction is Direction.DOWN else piece.to_m
            mark_m = track.marks_m.get(direction)
            stops_m = piece.length_m if mark_m is None else abs(mark_m - begin_m)
            if overlap_m and not line.stations[track.station_id].is_halt:
                found[track.piece_id + SIGN[direction]] = TrackOverlap(stops_m, overlap_m)
    return found


def brake_of(setup: Setup, stock_id: str) -> GuaranteedBrake:
    """The emergency brake of a stock as it is guaranteed to be."""
    train = setup.trains[stock_id].row[0]
    guaranteed = behaviour_row(setup.driving, train)
    return GuaranteedBrake(
        float(guaranteed["emergency_guaranteed_mps2"]),
        float(guaranteed["emergency_reaction_s"]),
        GRAVITY_MPS2 / (1.0 + float(train["rotating_mass_factor"])),
    )


def edge_heights(line: Line) -> Heights:
    """Where along each of SUMO's edges the gradient changes, and how high the track lies there, m."""
    heights: dict[str, tuple[tuple[float, float], ...]] = {}
    for piece_id, row in heights_of(line).items():
        end_m = row[-1][0]
        heights[piece_id + SIGN[Direction.DOWN]] = row
        heights[piece_id + SIGN[Direction.UP]] = tuple(
            (end_m - at_m, height_m) for at_m, height_m in reversed(row)
        )
    return heights
