"""`[substitute]` of a scenario, checked against its line, its timetable and its other tables."""

from __future__ import annotations

from collections.abc import Mapping

from network.errors import InputError
from network.files.toml_input import one_of
from simulation.procedure import PROCEDURES, WITHIN_STATION
from simulation.setup import Setup
from simulation.substitute.hops import RunsThrough, hops_of
from simulation.substitute.work import steps_by_post
from simulation.world.roster import drawn_up


def check_substitute(file: str, setup: Setup) -> None:
    """Stations, sections, trains and steps exist, staff react, and trains stop at every station, or InputError."""
    substitute = setup.substitute
    if substitute is None:
        return
    if not setup.people.react:
        raise InputError(
            file, "people.react", False, "true with [substitute]: staff restore the picture afterwards"
        )
    if setup.battery is not None:
        raise InputError(file, "substitute", None, "no such table with [battery]: nobody charges by hand")
    for i, station in enumerate(substitute.staffed):
        if station not in setup.line.stations:
            expected = f"a station: {one_of(sorted(setup.line.stations), station)}"
            raise InputError(file, f"substitute.staffed[{i}]", station, expected)
    try:
        hops = hops_of(drawn_up(setup, setup.line))
    except RunsThrough as error:
        expected = f"no such table where {error}: substitute working has trains stop at each"
        raise InputError(file, "substitute", None, expected) from error
    works = sorted({hop.work for hop in hops})
    for block in substitute.of_block:
        if block not in works:
            raise InputError(file, f"substitute.of_block.{block}", block, one_of(works, block))
    steps = [row.step.value for row in (*PROCEDURES[substitute.regime], *WITHIN_STATION)]
    steps += [row.step.value for regime in substitute.of_block.values() for row in PROCEDURES[regime]]
    for i, left in enumerate(substitute.left_out):
        key = f"substitute.left_out[{i}]"
        if left.step.value not in steps:
            expected = f"a step of {substitute.regime.value}: {one_of(steps, left.step.value)}"
            raise InputError(file, f"{key}.step", left.step.value, expected)
        if left.block and left.block not in works:
            raise InputError(file, f"{key}.block", left.block, one_of(works, left.block))
        if left.train and left.train not in setup.timetable.trains:
            expected = f"a train: {one_of(sorted(setup.timetable.trains), left.train)}"
            raise InputError(file, f"{key}.train", left.train, expected)


def steps_in(setup: Setup) -> Mapping[tuple[str, str], tuple[str, ...]]:
    """By post and section or station, the steps of substitute working that are that post's; none without it."""
    if setup.substitute is None or setup.line_signals is not None:
        return {}
    try:
        return steps_by_post(hops_of(drawn_up(setup, setup.line)), setup.substitute)
    except RunsThrough:  # which `check_substitute` refuses
        return {}
