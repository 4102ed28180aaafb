"""Crowded lines, with plans that can be run and plans that cannot, and a search of all states of such a line.

Every second plan is what trains did that were moved at random, so it can be run, in some order that nobody tells; the
others send trains anywhere. When a move is due says nothing of either. The search leaves nothing out and shares no code
with the certificate.
"""

import random
from collections.abc import Sequence

from tests.wayside.loop_line import Play, config_of

STATES_MAX = 150_000  # a case with more is none: another is drawn
DUE_EVERY_S = 100.0  # of a stock's moves: see `loop_line.config_of`


class AllStates:
    """Whether all can finish from where they are: every state that can be reached is looked at, once."""

    def __init__(self, ways: Sequence[Sequence[str]]) -> None:
        self._ways = ways
        self._dead: set[tuple[int, ...]] = set()

    def finish(self, at: Sequence[int]) -> bool | None:
        """`at`: the place of each on its way, -1 outside its portal. None: more states than are looked at."""
        start, ends = tuple(at), tuple(len(way) - 1 for way in self._ways)
        seen, open_states = {start}, [start]
        while open_states:
            state = open_states.pop()
            if state == ends:
                return True
            if state in self._dead:
                continue
            if len(seen) > STATES_MAX:
                return None
            held = [self._held(k, place) for k, place in enumerate(state)]
            for k, place in enumerate(state):
                if place == ends[k] or self._ways[k][place + 1] in held[:k] + held[k + 1 :]:
                    continue
                following = (*state[:k], place + 1, *state[k + 1 :])
                if following not in seen:
                    seen.add(following)
                    open_states.append(following)
        self._dead |= seen
        return False

    def _held(self, k: int, place: int) -> str:
        return "" if place < 0 or (place and self._ways[k][place] in "PQ") else self._ways[k][place]


def crowded_case(chance: random.Random) -> tuple[list[int], list[list[str]]]:
    """Three to six stations, three to eight stocks, some nine moves each; of those that come to an end some leave."""
    tracks = [chance.choice((1, 1, 2, 2, 3)) for _ in range(chance.randint(3, 6))]
    starts = [f"{s}.{t}" for s, count in enumerate(tracks) for t in range(1, count + 1)]
    chance.shuffle(starts)
    ways = [[start] for start in starts[: min(chance.randint(3, 8), len(starts) - 1)]]
    really = chance.random() < 0.5
    down = [chance.random() < 0.5 for _ in ways]
    for _ in range(chance.randint(2, 9) * len(ways)):
        k = chance.randrange(len(ways))
        here = ways[k][-1]
        if here in "PQ":
            continue
        if chance.random() < 0.1:
            down[k] = not down[k]
        station = int(here.split(".")[0]) + (1 if down[k] else -1)
        if not 0 <= station < len(tracks):
            if chance.random() < 0.25:
                ways[k].append("Q" if down[k] else "P")
            else:
                down[k] = not down[k]
            continue
        taken = {way[-1] for way in ways} if really else set[str]()
        there = [f"{station}.{t}" for t in range(1, tracks[station] + 1)]
        if free := [track for track in there if track not in taken]:
            ways[k].append(chance.choice(free))
    return tracks, [way for way in ways if len(way) > 1] if not really else ways


def places(play: Play) -> tuple[int, ...]:
    """Where each is on its way, -1 outside."""
    return tuple(-1 if out else at for at, out in zip(play.at, play.outside, strict=True))


def planned_before(play: Play, until_s: float) -> list[Sequence[str]]:
    """The ways as far as they are planned before a time, or have been run already."""
    return [
        way[: 1 + max(at, sum(DUE_EVERY_S * k + number < until_s for k in range(1, len(way))))]
        for number, (way, at) in enumerate(zip(play.ways, play.at, strict=True))
    ]


def crowded_play(seed: int) -> tuple[Play, AllStates, bool] | None:
    """A case with the search of all its states, and whether all can finish; None where it has too many states."""
    tracks, ways = crowded_case(random.Random(seed))
    play = Play(config_of(tracks, ways, certificate=True), ways)
    truth = AllStates(ways)
    can = truth.finish(places(play))
    return None if can is None else (play, truth, can)
