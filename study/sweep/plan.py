"""A sweep file made into points and days: which there are, in which order, and what each is made of."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any, Final

from host.scratch import scratch
from network.errors import InputError
from network.files.chances import SWEEP_DAYS
from network.files.quantities import SEED
from network.files.shipped import find_file
from network.files.text_input import existing_file
from network.files.toml_input import parse_toml, read_text
from network.files.toml_text import steps_of, value_text
from scenario.scenario import find_scenario
from scenario.sweep_file import AxisTable, StopTable, SweepFile
from study.runner.run import TEMPORARY, CarrierKind
from study.sweep.digest import inputs_digest
from study.sweep.draws import chance_of, check_draw, drawn_value, value_at
from study.sweep.figures import figure_of
from study.sweep.point import scenario_of
from study.sweep.records import DaySpec, Said
from study.sweep.statistics import looks, of_each_look

FOLDER: Final = "sweeps"
POINTS_MAX: Final = 2000  # assumed: more nobody reads, and each is loaded before the first day runs
AGAIN_EVERY: Final = 10  # every so many days carried on plain track one runs again on SUMO
_OWN: Final = frozenset({"id", "name", "seed"})  # a day's scenario has its own


@dataclass(frozen=True, slots=True)
class AxisPlace:
    """One place of an axis: what people call it and what it says."""

    label: str
    said: Said


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of the grid; the first place is what others are compared with."""

    name: str
    places: tuple[AxisPlace, ...]


@dataclass(frozen=True, slots=True)
class GridPoint:
    """A point of the grid: by axis the number of its place, what it says, and the digest of what it is made of."""

    number: int
    places: tuple[int, ...]
    label: str
    said: Said
    inputs: str


@dataclass(frozen=True, slots=True)
class SweepPlan:
    """A sweep as it is to be run. `scenario` is found from anywhere: a shipped name, or a file's whole path."""

    file: str
    table: SweepFile
    scenario: str
    axes: tuple[Axis, ...]
    points: tuple[GridPoint, ...]
    days: int
    carrier: CarrierKind

    @property
    def stop(self) -> StopTable | None:
        """When a point has days enough."""
        return self.table.stop

    @property
    def looks(self) -> tuple[int, ...]:
        """After how many days it is looked whether a point has enough."""
        least = self.days if self.stop is None else self.stop.least_days
        return looks(least, self.days)

    @property
    def confidence(self) -> float:
        """Of each interval: so much that, with a stop rule, what is said holds for all looks together."""
        return of_each_look(self.table.confidence, len(self.looks))

    def spec(self, point: GridPoint, index: int) -> DaySpec:
        """Day `index` of a point."""
        seed = self.table.seeds.first + index
        drawn = tuple((draw.key, drawn_value(draw, seed)) for draw in self.table.draw)
        return DaySpec(self.scenario, point.inputs, point.said, seed, self.carrier.value, drawn)

    def runs_twice(self, index: int) -> bool:
        """Whether a day is run a second time, on SUMO."""
        return self.carrier is CarrierKind.PLAIN and index % AGAIN_EVERY == 0


def load_plan(name: str, days: int | None = None, carrier: str | None = None) -> SweepPlan:
    """Read a sweep file, shipped or given; every point is loaded once, so nothing is found wrong later. InputError."""
    path = find_file(Path(str(files("study"))) / FOLDER, "sweep", name)
    name = str(path)
    table = parse_toml(read_text(path), name, SweepFile)
    folder = path.resolve().parent
    _check(name, table)
    count = table.seeds.days if days is None else days
    if not SWEEP_DAYS.holds(count):
        raise InputError("command line", "--days", days, f"{SWEEP_DAYS.text()} ({SWEEP_DAYS.name})")
    if not SEED.holds(table.seeds.first + count - 1):
        raise InputError(
            name,
            "seeds.first",
            table.seeds.first,
            f"a first seed at least {count - 1} below the greatest seed",
        )
    scenario = _found(folder, table.scenario)
    try:
        find_scenario(scenario)
    except InputError as error:
        raise InputError(name, "scenario", table.scenario, error.expected) from error
    axes = _axes(name, folder, table)
    plan = SweepPlan(
        name, table, scenario, axes, (), count, CarrierKind(table.carrier if carrier is None else carrier)
    )
    return replace(plan, points=_points(plan))


def _check(file: str, table: SweepFile) -> None:
    """What no schema says: names of figures, draws that make sense, nothing said twice."""
    for i, name in enumerate(table.watch):
        figure_of(name, file, f"watch[{i}]")
    if table.stop is not None:
        figure_of(table.stop.figure, file, "stop.figure")
        if table.stop.narrower_than <= 0.0:
            raise InputError(file, "stop.narrower_than", table.stop.narrower_than, "more than 0")
    said: dict[tuple[str, ...], str] = {}
    names: set[str] = set()
    for i, draw in enumerate(table.draw):
        where = f"draw[{i}]"
        check_draw(file, where, draw)
        if draw.name in names:
            raise InputError(file, f"{where}.name", draw.name, "a name that no other draw has")
        names.add(draw.name)
        _check_key(file, f"{where}.key", draw.key, said)
    for i, axis in enumerate(table.axis):
        where = f"axis[{i}]"
        if axis.name in names:
            raise InputError(file, f"{where}.name", axis.name, "a name that no other axis or draw has")
        names.add(axis.name)
        for key in _keys_of(file, where, axis):
            _check_key(file, where, key, said)


def _keys_of(file: str, where: str, axis: AxisTable) -> tuple[str, ...]:
    """The key paths of an axis, each once. InputError for an axis in neither or both of its forms."""
    if (axis.key is None) == (not axis.point):
        raise InputError(file, where, axis.name, "either key and values, or [[axis.point]], and not both")
    if axis.key is None:
        if axis.values or axis.labels:
            raise InputError(file, f"{where}.values", None, "a key to which the values belong")
        return tuple(dict.fromkeys(key for point in axis.point for key in point.says))
    if not axis.values:
        raise InputError(file, f"{where}.values", None, "at least one value")
    if axis.labels and len(axis.labels) != len(axis.values):
        raise InputError(file, f"{where}.labels", axis.labels, f"{len(axis.values)} labels, one a value")
    return (axis.key,)


def _check_key(file: str, where: str, key: str, said: dict[tuple[str, ...], str]) -> None:
    """A key path that a scenario may have, and that nothing else of the sweep says, or says a part of."""
    steps = steps_of(key, file, where)
    if steps[0] in _OWN:
        raise InputError(
            file, where, key, f"another key than {', '.join(sorted(_OWN))}, which each day has its own"
        )
    for other, by in said.items():
        shorter = min(len(other), len(steps))
        if other[:shorter] == steps[:shorter]:
            raise InputError(file, where, key, f"a key that is said once; {by} says it too")
    said[steps] = where


def _axes(file: str, folder: Path, table: SweepFile) -> tuple[Axis, ...]:
    axes: list[Axis] = []
    for i, axis in enumerate(table.axis):
        if axis.key is None:
            places = [
                AxisPlace(p.label, tuple((key, _found(folder, value)) for key, value in p.says.items()))
                for p in axis.point
            ]
        else:
            labels = axis.labels or [v if isinstance(v, str) else value_text(v) for v in axis.values]
            places = [
                AxisPlace(label, ((axis.key, _found(folder, value)),))
                for label, value in zip(labels, axis.values, strict=True)
            ]
        labels = [place.label for place in places]
        for label in labels:
            if labels.count(label) > 1:
                raise InputError(file, f"axis[{i}]", label, "places that are called differently")
        axes.append(Axis(axis.name, tuple(places)))
    return tuple(axes)


def _points(plan: SweepPlan) -> tuple[GridPoint, ...]:
    """All points, the last axis going through its places first; each is loaded, with the ends of what is drawn."""
    shape = [range(len(axis.places)) for axis in plan.axes]
    count = math.prod(map(len, shape))
    if count > POINTS_MAX:
        raise InputError(plan.file, "axis", f"{count} points", f"a grid of at most {POINTS_MAX} points")
    points: list[GridPoint] = []
    with scratch(TEMPORARY) as folder:
        for number, chosen in enumerate(product(*shape)):
            places = tuple(chosen)
            taken = [axis.places[place] for axis, place in zip(plan.axes, places, strict=True)]
            said = tuple(item for place in taken for item in place.said)
            label = ", ".join(
                f"{axis.name} {place.label}" for axis, place in zip(plan.axes, taken, strict=True)
            )
            point = GridPoint(number, places, label or "as it is", said, "")
            found = _loaded(plan, point, (), folder)
            for drawn in _extremes(plan):
                _loaded(plan, point, (drawn,), folder)
            points.append(replace(point, inputs=found))
    return tuple(points)


def _extremes(plan: SweepPlan) -> Iterator[tuple[str, Any]]:
    """The least and greatest value that each draw takes on any day, and each choice."""
    seeds = range(plan.table.seeds.first, plan.table.seeds.first + plan.days)
    for draw in plan.table.draw:
        if draw.distribution == "choice":
            yield from ((draw.key, value) for value in draw.values)
            continue
        chances = [chance_of(draw, seed) for seed in seeds]
        ends = (value_at(draw, min(chances)), value_at(draw, max(chances)))
        yield from ((draw.key, value) for value in dict.fromkeys(ends))


def _loaded(plan: SweepPlan, point: GridPoint, drawn: Said, folder: Path) -> str:
    """The digest of what a point is made of. InputError is put down to the sweep file."""
    spec = DaySpec(plan.scenario, "", point.said, plan.table.seeds.first, plan.carrier.value, drawn)
    try:
        return inputs_digest(scenario_of(spec, folder).setup)
    except InputError as error:
        made = str(folder)
        own = error.file.startswith(made)
        what = [f"{key} = {value_text(value)}" for key, value in (*point.said, *drawn)]
        expected = error.expected if own else f"a point that can be run; {error}"
        key = error.key if own else point.label
        raise InputError(
            plan.file, key, error.value if own else None, f"{expected} (at {', '.join(what)})"
        ) from error


def _found(folder: Path, value: Any) -> Any:  # noqa: ANN401 - a value of a file, as it is
    """A value; a file that is named beside the sweep file by its whole path, since days run elsewhere."""
    if isinstance(value, str) and value.endswith(".toml") and existing_file(folder / value):
        return str(folder / value)
    return value
