"""What level crossings cost: a day without them, with twenty that trains close by radio, and with a road over each.

The crossings lie evenly along the line, where neither points nor a portal is, with radio all along. Each day runs in
a fresh process that has run it once before. What is compared is the time of its processor; of that, what the carrier
takes is told apart: SUMO's steps and, with a road, all that is done for its vehicles. The rest is the trains' side.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from network.files.crossing_road import CrossingRoad
from network.files.crossings import CLOSED_S, CLOSING_S
from network.model import Coverage, CrossingClass, CrossingControl, LevelCrossing, Line, Piece
from study.evaluate.afresh import budget_of, figures_afresh
from study.evaluate.bench import Metered, Recorder

if TYPE_CHECKING:
    from host.parties import Parties
    from simulation.carriers.carrier import Carrier
    from simulation.setup import Setup

WITHOUT: Final = "without level crossings"
RADIO: Final = "20 by radio"
ROAD: Final = "20 by radio, with their roads"
WAYS: Final = (WITHOUT, RADIO, ROAD)
COUNT: Final = 20
VEHICLES_PER_H: Final = 3000.0  # over all of them together
WIDTH_M: Final = 6.0
LOWERING_S: Final = 8.0
TRAIN_SIDE_MAX: Final = 1.3


@dataclass(slots=True)
class TimedCarrier(Recorder):
    """A carrier that says how long its steps took by the processor, and remembers no speeds."""

    spent_s: float = 0.0
    calls: int = 0

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Pass on, and time."""
        began_s = time.process_time()
        hit = self.inner.run(columns, steps)
        self.spent_s += time.process_time() - began_s
        self.calls += 1
        return hit


def crossed(setup: Setup, count: int, vehicles_per_h: float = 0.0) -> Setup:
    """The setup on its line with so many crossings by radio instead of its own, and with roads if any vehicle comes."""
    line = setup.line
    room = [piece for piece in line.pieces.values() if _has_room(line, piece)]
    whole_m = sum(piece.length_m for piece in room)
    crossings: dict[str, LevelCrossing] = {}
    for number in range(count):
        left_m = (number + 0.5) * whole_m / count
        for piece in room:
            if left_m <= piece.length_m:
                crossings[f"X{number}"] = _crossing(f"X{number}", piece, left_m)
                break
            left_m -= piece.length_m
    covered = {
        name: replace(one, coverage=(Coverage(one.from_m, one.to_m),))
        for name, one in line.alignments.items()
    }
    road = CrossingRoad(vehicles_per_h=(vehicles_per_h / count,))
    roads = dict.fromkeys(crossings, road) if vehicles_per_h else {}
    return replace(setup, line=replace(line, alignments=covered, crossings=crossings), roads=roads)


def _has_room(line: Line, piece: Piece) -> bool:
    kind = line.sections[piece.section_id].kind
    return kind.value not in ("points", "portal") and piece.length_m > 4.0 * WIDTH_M


def _crossing(name: str, piece: Piece, left_m: float) -> LevelCrossing:
    at_m = piece.from_m + min(max(left_m, WIDTH_M), piece.length_m - WIDTH_M)
    times = LOWERING_S, CLOSING_S, CLOSED_S
    return LevelCrossing(
        name, name, CrossingClass.BARRIERS, CrossingControl.RADIO, piece.id, at_m, WIDTH_M, *times
    )


def run_child(way: str, scenario: str) -> dict[str, Any]:
    """The second day of one way in this process."""
    from scenario.scenario import load_scenario
    from study.runner.run import PartyLink, execute

    loaded = load_scenario(scenario)
    if way != WITHOUT:
        setup = crossed(loaded.setup, COUNT, VEHICLES_PER_H if way == ROAD else 0.0)
        loaded = replace(loaded, setup=setup)
    carriers: list[TimedCarrier] = []
    meters: list[Metered] = []

    def wrap(carrier: Carrier) -> Carrier:
        carriers.append(TimedCarrier(carrier))
        return carriers[-1]

    def watch(parties: Parties) -> Parties:
        meters.append(Metered(parties))
        return meters[-1]

    before = execute(loaded, PartyLink.SIMULATED)
    began_s = time.process_time()
    run = execute(loaded, PartyLink.SIMULATED, wrap=wrap, watch=watch)
    cpu_s = time.process_time() - began_s
    digests = {each.summary["digest"] for each in (before, run)}
    return {
        "cpu_s": cpu_s,
        "carrier_s": carriers[-1].spent_s,
        "carried": carriers[-1].calls,
        "telegrams": sum(count["sent"] for count in run.result.telegrams.values()),
        "queries": meters[-1].queries,
        "digests": sorted(digests),
    }


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Medians of processor time of all ways; that with roads, of minutes, has no budget and is run in the first round
    alone. `tell` gets every figure as soon as it is there.
    """
    figures: dict[str, list[dict[str, Any]]] = {way: [] for way in WAYS}
    for number in range(rounds):
        for way in WAYS if number == 0 else (WITHOUT, RADIO):
            found = figures_afresh("study.evaluate.crossings_bench", way, way, scenario)
            figures[way].append(found)
            tell(
                f"{scenario}, round {number + 1} of {rounds}: {way}: {found['cpu_s']:.2f} cpu s,"
                f" {found['carrier_s']:.2f} of them the carrier's, {found['telegrams']} telegrams"
            )
    return {"scenario": scenario, "rounds": rounds} | report(figures)


def report(figures: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """What the figures of all rounds come to: a row each, and the budget with whether it is kept."""

    def median(way: str, key: str) -> float:
        return statistics.median(float(one[key]) for one in figures[way])

    def trains_s(way: str) -> float:
        return statistics.median(float(one["cpu_s"]) - float(one["carrier_s"]) for one in figures[way])

    rows = [
        {
            "way": way,
            "cpu_s": round(median(way, "cpu_s"), 3),
            "of_without": round(median(way, "cpu_s") / median(WITHOUT, "cpu_s"), 3),
            "carrier_s": round(median(way, "carrier_s"), 3),
            "trains_s": round(trains_s(way), 3),
            "telegrams": median(way, "telegrams"),
            "queries": median(way, "queries"),
            "carried": median(way, "carried"),
        }
        for way in WAYS
    ]
    found = round(median(RADIO, "cpu_s") / median(WITHOUT, "cpu_s"), 3)
    same = all(len({digest for one in figures[way] for digest in one["digests"]}) == 1 for way in WAYS)
    what = f"{RADIO} of {WITHOUT}"
    return {"rows": rows, "same_digest": same, "budgets": [budget_of(what, TRAIN_SIDE_MAX, found)]}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(run_child(*sys.argv[1:])) + "\n")
