"""What could be built or changed on a line, what it costs, and the tables of a scenario that say so.

Costs are in no money: a loop is 100, all else in proportion. All are assumed, for a user to put others in their place.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import Field

from network.files.kinds import about
from network.files.names import Identifier, Prose
from network.files.toml_input import Record, parse_toml, read_text
from network.files.toml_text import put_value, steps_of
from network.model import Line, SectionKind
from plan.where_to_meet import halts_of, laying
from simulation.setup import Setup

LOOP_COST: Final = 100.0  # assumed: the unit of all costs; two sets of points, 240 m of track, a platform
POINTS_COST: Final = 4.0  # assumed, a set of points: a quicker machine in place of the one that is there
LIMIT_COST: Final = 3.0  # assumed, a limit: cant and transition of a curve made over
RELEASE_COST: Final = 20.0  # assumed: the program of manager and units, proven anew
COVERAGE_COST_KM: Final = 4.0  # assumed, a kilometre of line without radio: a mast every three or four
BLOCKS_COST: Final = 15.0  # assumed: more tags where blocks end, data of the line
RADIO_COST: Final = 10.0  # assumed: telegrams that have precedence
QUICK_THROW_S: Final = 3.0  # the quicker end of `study.capacity.equipment`
BLOCKS: Final = 3
HIGHER: Final = 1.1  # of each limit


@dataclass(frozen=True, slots=True)
class EquipmentOption:
    """Something that can be had or not. `loop`: the halt at which it is one; `needs`: what it is nothing without."""

    name: str
    what: str
    cost: float
    tables: Mapping[str, Any] = field(default_factory=dict[str, Any])
    needs: tuple[str, ...] = ()
    loop: str = ""


class OptionTable(Record):
    """`[[option]]`: something that can be had or not, as its cost and what a scenario then says."""

    name: Annotated[Identifier, about("name, for `needs` and --without")]
    what: Annotated[Prose, about("in words")]
    cost: Annotated[float, Field(ge=0.0, le=1e12), about("cost, in the unit of the file")]
    says: Annotated[dict[str, Any], about("values of the scenario by key path")] = Field(
        default_factory=dict, alias="set"
    )
    needs: Annotated[list[Identifier], about("options without which it is not had")] = Field(
        default_factory=list
    )


class EquipmentFile(Record):
    """A file of options for `branchline best equipment --options`."""

    option: Annotated[list[OptionTable], about("options")]


def options_of_file(path: Path) -> list[EquipmentOption]:
    """The options of a file. Raises InputError."""
    found: list[EquipmentOption] = []
    for i, one in enumerate(parse_toml(read_text(path), str(path), EquipmentFile).option):
        tables: dict[str, Any] = {}
        for key, value in one.says.items():
            put_value(tables, steps_of(key, str(path), f"option[{i}].set"), value)
        found.append(EquipmentOption(one.name, one.what, one.cost, tables, tuple(one.needs)))
    return found


def loops_to_lay(line: Line) -> list[EquipmentOption]:
    """A loop at each halt."""
    return [
        EquipmentOption(
            f"loop_{halt}", f"a loop at {line.stations[halt].name}", LOOP_COST, laying([halt]), loop=halt
        )
        for halt in halts_of(line)
    ]


def options_of(setup: Setup) -> Iterator[EquipmentOption]:
    """All but loops, for a line with the loops that it has; what costs by number is for that line."""
    line = setup.line
    quick = {"points.*.throw_time_s": QUICK_THROW_S}
    count = len(line.points)
    if any(one.throw_time_s > QUICK_THROW_S for one in line.points.values()):
        what = f"{count} points that throw in {QUICK_THROW_S:g} s"
        yield EquipmentOption("quick_points", what, POINTS_COST * count, _of_line(set=quick))
    limits = {a.id: len(a.limits) for a in line.alignments.values() if a.limits}
    if limits:
        times = {f"alignments.{name}.limits.*.speed_kmh": HIGHER for name in limits}
        what = f"{sum(limits.values())} limits a tenth higher"
        yield EquipmentOption("limits", what, LIMIT_COST * sum(limits.values()), _of_line(times=times))
    if setup.air.delay_mean_s > setup.air.delay_min_s:
        air = {"air": {"delay_mean_s": setup.air.delay_min_s}}
        yield EquipmentOption(
            "quick_radio", f"telegrams that take {setup.air.delay_min_s:g} s", RADIO_COST, air
        )
    yield EquipmentOption(
        "by_section", "release section by section", RELEASE_COST, {"operation": {"release": "section"}}
    )
    covered, uncovered_km = _covered(line)
    yield EquipmentOption(
        "coverage",
        f"radio on {uncovered_km:.1f} km more",
        COVERAGE_COST_KM * uncovered_km,
        _of_line(set=covered),
    )
    between = [s.id for s in line.sections.values() if s.kind is SectionKind.BETWEEN]
    cut = {f"sections.{section_id}.virtual_blocks": BLOCKS for section_id in between}
    what = f"{BLOCKS} virtual blocks a section"
    yield EquipmentOption("blocks", what, BLOCKS_COST, _of_line(set=cut), ("by_section", "coverage"))


def _of_line(**words: Mapping[str, Any]) -> dict[str, Any]:
    return {"patch": {"line": words}}


def _covered(line: Line) -> tuple[dict[str, Any], float]:
    """The radio from end to end, and how much of the line has none yet, km."""
    values: dict[str, Any] = {}
    uncovered_m = 0.0
    for axis in line.alignments.values():
        own = [p for p in line.pieces.values() if p.alignment_id == axis.id]
        from_m, to_m = min(p.from_m for p in own), max(p.to_m for p in own)
        has_m = sum(max(min(c.to_m, to_m) - max(c.from_m, from_m), 0.0) for c in axis.coverage)
        uncovered_m += to_m - from_m - has_m
        values[f"alignments.{axis.id}.coverage"] = [{"from_km": from_m / 1000.0, "to_km": to_m / 1000.0}]
    return values, uncovered_m / 1000.0


def tables_of(options: Iterable[EquipmentOption]) -> dict[str, Any]:
    """The tables of a scenario that has all of them: loops together, other words key by key."""
    own = tuple(options)
    loops = [one.loop for one in own if one.loop]
    found: dict[str, Any] = {}
    for tables in (laying(loops), *(one.tables for one in own if not one.loop)):
        for key, value in tables.items():
            put_value(found, (key,), value)
    return found
