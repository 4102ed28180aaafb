"""`branchline reproduce one-beacon`: a made-up paper, by which one beacon makes good what wheels count wrongly.

Wheels count up to 1 % too much or too little from a beacon 1 km before the mark on. With another one 20 m before it
every stop ends within half a metre.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from papers.parameter_sets import LINE, coasting
from papers.reproduction import CaseRow, NullMethod, Options, Parameter
from papers.single_run import new_stops
from papers.single_train import Bench
from papers.specification import Evenly, Findings, Specification, at_most
from radio.chance import generator
from vehicle.train_file import load_train, shipped_train

NAME: Final = "one-beacon"
STOPS: Final = 100
STOPS_QUICK: Final = 3
BEACON_M: Final = 20.0
FIRST_M: Final = 1000.0
START_M: Final = 200.0
SPEED_MPS: Final = 12.0
COUNT_ERROR: Final = Evenly("counted too much", -0.01, 0.01, "share", "made up, section 2")
WORST: Final = "worst stop, m"
PAPERS_WORST_M: Final = 0.5


def worst_row(options: Options, beacons: int) -> CaseRow:
    """How far from its mark the worst stop ends."""
    rng = generator(options.seed, NAME)
    stops = new_stops(STOPS_QUICK if options.quick else STOPS)
    stops["speed_mps"], stops["start_m"], stops["since_fix_m"] = SPEED_MPS, START_M, FIRST_M - START_M
    stops["count_error"] = COUNT_ERROR.at(rng.uniform(size=stops.size))
    stops["beacons"], stops["beacon_m"][:, 0] = beacons, BEACON_M
    train = load_train(shipped_train("oda_train"))
    outcomes, _ = Bench(train, coasting(LINE.driving), LINE.unit).run(stops)
    worst_m = float(np.abs(outcomes["error_m"]).max())
    return at_most(WORST, f"within {PAPERS_WORST_M:g}", worst_m, PAPERS_WORST_M)


def experiment(options: Options) -> Findings:
    """Stops by one beacon."""
    distance = Parameter("beacon before the mark", BEACON_M, "m", "made up, figure 1")
    return Findings([worst_row(options, beacons=1)], [COUNT_ERROR.parameter, distance])


def wheels_alone(options: Options) -> Iterable[CaseRow]:
    """The same stops without it."""
    return [worst_row(options, beacons=0)]


reproduce: Final = Specification(
    NAME,
    "Stops by one beacon (nobody, 2)",
    experiment,
    NullMethod("wheels alone", (WORST,), wheels_alone),
    LINE,
    f"A short slice: {STOPS_QUICK} of {STOPS} stops.",
)
