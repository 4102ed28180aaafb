"""What tests of arranging reckon with by hand: A, a loop L and B; each run takes 300 s, a stop 20 s."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from plan.arranging.problem import ByStanding, Leg, RunSeconds, TrainToArrange, Visit

NONE = ByStanding(0, 0)
RUN = RunSeconds(300, 290, 290, 280)
NOON = 43_200


def train_of(number: str, visits: Sequence[Visit]) -> TrainToArrange:
    """A train whose legs hold what lies between its stations, as long as it is there."""
    legs = [
        replace(there, leg=Leg(("-".join(sorted((here.station_id, there.station_id))),), NONE, NONE))
        for here, there in pairwise(visits)
    ]
    return TrainToArrange(number, (replace(visits[0], run=None), *legs))
