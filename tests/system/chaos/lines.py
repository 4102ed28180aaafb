"""Lines that are drawn: two to five stations with loops, halts or a dead end, of varying lengths, gradients and speeds.

Stations, points and portals have the measures of the busy line, tags lie by the rule of `network.tag_layout`.
"""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import Any

from network.files.line_file import parse_line
from network.tag_layout import lay_tags, tags_toml
from tests.system.chaos.crossings import crossings_on
from tests.system.chaos.draw import Draw
from tests.system.chaos.timetables import Stop
from tests.system.chaos.toml_text import toml_of

HALF_KM = 0.2  # from the middle of a loop to its ends
TOE_KM = 0.18
TRACK_KM = 0.12
DEAD_END_KM = 0.15
PORTAL_KM = 1.0
LEVEL_KM = 0.4
SECOND_P = 0.6  # a second network, which reaches everywhere


class Kind(Enum):
    """What a station is."""

    LOOP = "loop"
    HALT = "halt"
    DEAD_END = "dead end"

    @property
    def half_km(self) -> float:
        """From its middle to where its sections end."""
        return {Kind.LOOP: HALF_KM, Kind.HALT: 0.0, Kind.DEAD_END: DEAD_END_KM}[self]


@dataclass(frozen=True, slots=True)
class DrawnLine:
    """Text of the line file, and what a timetable needs to know of it."""

    id: str
    text: str
    stops: tuple[Stop, ...]
    second_network: bool = False


def drawn_line(line_id: str, draw: Draw, *, crossed: bool = False) -> DrawnLine:
    """A line; `crossed`: with level crossings, most of them where some network reaches."""
    kinds = _kinds(draw.of("kinds"))
    speed_kmh = draw.one_of((45, 60, 70, 85))
    kms = [0.0]
    for _ in kinds[1:]:
        kms.append(round(kms[-1] + draw.between(1.8, 3.6, 2), 2))
    table = _tables(line_id, kinds, kms, speed_kmh, draw)
    bare = toml_of(table)
    line = parse_line(bare, line_id)
    tags = tags_toml(line, lay_tags(line))
    if crossed:
        table["crossings"] = crossings_on(line, speed_kmh, draw.of("crossings"))
        (alignment,) = table["alignments"]
        if draw.of("second network").chance(SECOND_P):
            alignment["second_coverage"] = [{"from_km": alignment["from_km"], "to_km": alignment["to_km"]}]
        bare = toml_of(table)
    second = "second_coverage" in table["alignments"][0]
    return DrawnLine(line_id, f"{tags}\n{bare}", _stops(kinds, kms, speed_kmh), second)


def _kinds(draw: Draw) -> list[Kind]:
    count = draw.whole(2, 5)
    ends = [Kind.LOOP if draw.chance(0.65) else Kind.DEAD_END for _ in range(2)]
    middle = [Kind.LOOP if draw.chance(0.5) else Kind.HALT for _ in range(count - 2)]
    if Kind.LOOP not in (*ends, *middle):  # somewhere two trains must pass
        if middle:
            middle[0] = Kind.LOOP
        else:
            ends[0] = Kind.LOOP
    return [ends[0], *middle, ends[1]]


def _stops(kinds: list[Kind], kms: list[float], speed_kmh: int) -> tuple[Stop, ...]:
    stops: list[Stop] = []
    for k, (kind, km) in enumerate(zip(kinds, kms, strict=True)):
        run_s = 0 if k == 0 else round((km - kms[k - 1]) * 3600.0 / (0.6 * speed_kmh)) + 45
        at_end = k in (0, len(kinds) - 1)
        portal = f"S{k + 1}.P" if at_end and kind is Kind.LOOP else ""
        stops.append(Stop(f"S{k + 1}", run_s, 2 if kind is Kind.LOOP else 1, portal))
    return tuple(stops)


def _tables(line_id: str, kinds: list[Kind], kms: list[float], speed_kmh: int, draw: Draw) -> dict[str, Any]:
    own = [
        (k, kind, km) for k, (kind, km) in enumerate(zip(kinds, kms, strict=True)) if kind is not Kind.HALT
    ]
    low_km = kms[0] - (PORTAL_KM if kinds[0] is Kind.LOOP else DEAD_END_KM)
    high_km = kms[-1] + (PORTAL_KM if kinds[-1] is Kind.LOOP else DEAD_END_KM)
    alignment = {
        "id": "main",
        "from_km": low_km,
        "to_km": high_km,
        "gradients": _gradients(kms, low_km, high_km, draw.of("gradients")),
        "coverage": _coverage([km for _, _, km in own], low_km, high_km, draw.of("coverage")),
    }
    sections, points, joints, stations = _places(kinds, kms, low_km, high_km, draw.of("points"))
    return {
        "line": {
            "id": line_id,
            "name": line_id,
            "max_speed_kmh": speed_kmh,
            "assumed": ["everything: drawn by chance"],
        },
        "alignments": [alignment],
        "sections": sections,
        "points": points,
        "joints": joints,
        "stations": stations,
    }


def _gradients(kms: list[float], low_km: float, high_km: float, draw: Draw) -> list[dict[str, float]]:
    """Level at stations; a rise or fall, or two, between them."""
    marks = [(low_km, 0.0)]
    for before_km, after_km in pairwise(kms):
        middle_km = round((before_km + after_km) / 2.0, 3)
        marks += [
            (round(before_km + LEVEL_KM, 3), draw.between(-20.0, 20.0, 1)),
            (middle_km, draw.between(-20.0, 20.0, 1)),
            (round(after_km - LEVEL_KM, 3), 0.0),
        ]
    ends_km = [*(km for km, _ in marks[1:]), high_km]
    return [
        {"from_km": km, "to_km": end_km, "permille": permille}
        for (km, permille), end_km in zip(marks, ends_km, strict=True)
    ]


def _coverage(kms: list[float], low_km: float, high_km: float, draw: Draw) -> list[dict[str, float]]:
    """The whole line, or what lies round its stations, as in the paper; portals too, where units sign on and off."""
    if draw.chance(0.5):
        return [{"from_km": low_km, "to_km": high_km}]
    reach_km = draw.between(PORTAL_KM + 0.1, 1.6, 2)
    spans: list[dict[str, float]] = []
    for km in kms:
        from_km, to_km = round(max(km - reach_km, low_km), 3), round(min(km + reach_km, high_km), 3)
        if spans and spans[-1]["to_km"] >= from_km:
            spans[-1]["to_km"] = to_km
        else:
            spans.append({"from_km": from_km, "to_km": to_km})
    return spans


Rows = list[dict[str, Any]]


def _places(
    kinds: list[Kind], kms: list[float], low_km: float, high_km: float, draw: Draw
) -> tuple[Rows, Rows, Rows, Rows]:
    """Sections from west to east, points, joints and stations."""
    own = [k for k, kind in enumerate(kinds) if kind is not Kind.HALT]
    opens = [f"S{a + 1}-S{b + 1}" for a, b in pairwise(own)]
    before = {k: opens[i - 1] if i else f"S{k + 1}.P" for i, k in enumerate(own)}
    after = {k: opens[i] if i < len(opens) else f"S{k + 1}.P" for i, k in enumerate(own)}
    sections: Rows = []
    points: Rows = []
    joints: Rows = []
    stations: Rows = []
    open_section = ""
    for k, (kind, km) in enumerate(zip(kinds, kms, strict=True)):
        name, first, last = f"S{k + 1}", k == 0, k == len(kinds) - 1
        if kind is Kind.HALT:
            stations.append(_station(name, km, [(open_section, "1")], halt=True))
            continue
        if first and kind is Kind.LOOP:
            sections.append(_section(f"{name}.P", "portal", low_km, km - HALF_KM))
        if kind is Kind.LOOP:
            sections += _loop_sections(name, km)
            points += _loop_points(name, km, before[k], after[k], draw)
            stations.append(_station(name, km, [(f"{name}.1", "1"), (f"{name}.2", "2")]))
        else:
            sections.append(_section(f"{name}.1", "track", km - DEAD_END_KM, km + DEAD_END_KM))
            low, high = (f"{name}.1", after[k]) if first else (before[k], f"{name}.1")
            joints.append({"low": low, "high": high})
            stations.append(_station(name, km, [(f"{name}.1", "1")]))
        if last and kind is Kind.LOOP:
            sections.append(_section(f"{name}.P", "portal", km + HALF_KM, high_km))
        if not last:
            following = own[own.index(k) + 1]
            open_section = after[k]
            end_km = kms[following] - kinds[following].half_km
            sections.append(_section(open_section, "between", km + kind.half_km, end_km))
    return sections, points, joints, stations


def _section(section_id: str, kind: str, from_km: float, to_km: float) -> dict[str, Any]:
    return {"id": section_id, "kind": kind, "from_km": round(from_km, 3), "to_km": round(to_km, 3)}


def _loop_sections(name: str, km: float) -> Rows:
    tracks = [
        _section(f"{name}.{track}", "track", km - TRACK_KM, km + TRACK_KM) | {"offset_m": offset_m}
        for track, offset_m in (("1", -4.0), ("2", 4.0))
    ]
    return [{"id": f"{name}.W", "kind": "points"}, *tracks, {"id": f"{name}.E", "kind": "points"}]


def _loop_points(name: str, km: float, before: str, after: str, draw: Draw) -> Rows:
    common = {"throw_time_s": draw.between(3.0, 8.0, 1), "diverging_limit_kmh": draw.one_of((25, 35, 45))}
    ends = (
        ("W", "11", "down", before, (km - HALF_KM, km - TOE_KM, km - TRACK_KM)),
        ("E", "21", "up", after, (km + TRACK_KM, km + TOE_KM, km + HALF_KM)),
    )
    return [
        {
            "id": f"{name}.{number}",
            "section": f"{name}.{end}",
            "terminal": f"{name}-{end}",
            "from_km": round(from_km, 3),
            "toe_km": round(toe_km, 3),
            "to_km": round(to_km, 3),
            "faces": faces,
            "stem": stem,
            "normal": f"{name}.1",
            "reverse": f"{name}.2",
            "initial": draw.one_of(("normal", "reverse")),
            **common,
        }
        for end, number, faces, stem, (from_km, toe_km, to_km) in ends
    ]


def _station(name: str, km: float, tracks: list[tuple[str, str]], *, halt: bool = False) -> dict[str, Any]:
    return {
        "id": name,
        "name": name,
        "km": km,
        "halt": halt,
        "tracks": [
            {
                "name": track,
                "section": section,
                "platform_from_km": round(km - 0.04, 3),
                "platform_to_km": round(km + 0.04, 3),
                "mark_down_km": round(km + 0.02, 3),
                "mark_up_km": round(km - 0.02, 3),
                "directions": ["down", "up"],
            }
            for section, track in tracks
        ],
    }
