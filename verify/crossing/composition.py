"""One state of a crossing and its train at a time: what may follow, in words. It shares the parties with the search,
and nothing of how that composes them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from verify.crossing.explored_crossing import ON_AIR_MAX, CrossingTrouble, ExploredCrossing
from verify.crossing.facts import has_passed, rests, seen_of
from verify.crossing.gate import BROKEN, GateModel, GateState, GateStep, Rider, RoadRule, Shut
from verify.crossing.rider import RiderModel, RiderState, RiderStep, of_before
from verify.on_air import InAir

Down = tuple[tuple[InAir, bool], ...]  # telegrams of the device, and whether the closure that is was so then
NETWORKS: Final = "both networks"


class CrossingWhole(NamedTuple):
    """All of it: telegrams `up` to the device and `down` from it, in order; `cut`: both networks are lost."""

    rider: RiderState
    gate: GateState
    up: tuple[InAir, ...]
    down: Down
    cut: bool
    left: tuple[int, ...]


class Happened(NamedTuple):
    """What happens, to whom, in words, and the state after it."""

    who: str
    what: str
    state: CrossingWhole
    trouble: CrossingTrouble
    telegram: InAir | None = None


class CrossingComposition:
    """The rules by which the parties are put together."""

    def __init__(self, explored: ExploredCrossing) -> None:
        self.explored: Final = explored
        self._riders, self._gates = RiderModel(explored), GateModel(explored)

    def start(self) -> CrossingWhole:
        """A train far away, and an open road."""
        return CrossingWhole(
            RiderState(), self._gates.start(), (), (), cut=False, left=tuple(self.explored.budgets)
        )

    def following(self, state: CrossingWhole) -> Iterator[Happened]:
        """All that may happen next and can be afforded."""
        for found in self._any(state):
            if found.trouble is CrossingTrouble.NONE:
                yield found
            elif state.left[found.trouble - 1] > 0:
                left = tuple(n - (i == found.trouble - 1) for i, n in enumerate(state.left))
                yield found._replace(state=found.state._replace(left=left))

    def _any(self, state: CrossingWhole) -> Iterator[Happened]:
        free = CrossingTrouble.NONE
        if state.up:
            first, rest = state.up[0], state._replace(up=state.up[1:])
            yield Happened("device", "does not hear", rest, CrossingTrouble.LOSS, first)
            heard = self._gates.hear(state.gate, first)
            yield Happened("device", "hears", self._at_gate(rest, heard), free, first)
        if state.down:
            (first, of_now), rest = state.down[0], state._replace(down=state.down[1:])
            yield Happened("unit", "does not hear", rest, CrossingTrouble.LOSS, first)
            taken = self._riders.hear(state.rider, first, of_now)
            yield Happened("unit", "hears", self._at_train(rest, taken), free, first)
        for step in self._riders.events(state.rider):
            if not (step.repeats and state.up):
                yield Happened("train", step.name, self._at_train(state, step), step.trouble)
        seen = _seen(state)
        for made in self._gates.events(state.gate):
            if not ((made.alone and seen.comes) or (made.unproven and seen.believes)):
                yield Happened("device", made.name, self._at_gate(state, made), made.trouble)
        if state.cut:
            yield Happened(NETWORKS, "are there again", state._replace(cut=False), free)
        else:
            lost = state._replace(up=(), down=(), cut=True)
            yield Happened(NETWORKS, "are lost", lost, CrossingTrouble.CARRIERS)

    def _at_train(self, state: CrossingWhole, step: RiderStep) -> CrossingWhole:
        gate = self._gates.told(state.gate, step.told)
        up, down = state.up, state.down
        if step.anew:
            gate = self._gates.anew(gate)
            up, down = tuple(map(of_before, up)), tuple((of_before(t), now) for t, now in down)
        if not state.cut:
            up = (*up, *step.sends)[-ON_AIR_MAX:]
        return state._replace(rider=step.state, gate=gate, up=up, down=down)

    def _at_gate(self, state: CrossingWhole, step: GateStep) -> CrossingWhole:
        gate = self._gates.judged(step.state, _seen(state), ceases=step.ceases, opens=step.opens)
        down = tuple((t, False) for t, _ in state.down) if step.ceases else state.down
        if not state.cut:
            closed = step.state.judge.shut is not Shut.NOT
            down = (*down, *((t, closed) for t in step.sends))[-ON_AIR_MAX:]
        return state._replace(gate=gate, down=down)

    def broken(self, state: CrossingWhole) -> str:
        """The rule that it breaks; empty: none."""
        rule = state.gate.judge.broken
        return "" if rule is RoadRule.NONE else BROKEN[rule]

    def finished(self, state: CrossingWhole) -> bool:
        """Whether the train has passed, its unit has nothing more to say, and the road is open again."""
        return has_passed(state.rider) and rests(state.gate)


def _seen(state: CrossingWhole) -> Rider:
    return seen_of(state.rider, (telegram for telegram, _ in state.down), cut=state.cut)
