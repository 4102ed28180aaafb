"""Recounts a roster, and why fewer sets cannot do, from the facts of trains; it shares no code with what finds them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from plan.roster.cover import FewerCannot
from plan.roster.facts import RosterTerms, RosterTrain


class RosterRecount:
    """The trains of a day, and by which least times one set may run two of them."""

    def __init__(self, trains: Sequence[RosterTrain], terms: RosterTerms) -> None:
        self._trains = {train.number: train for train in trains}
        self._terms = terms

    def refuse(self, sets: Sequence[Sequence[str]], why: FewerCannot) -> None:
        """ValueError where a roster or its certificate is not as it says."""
        run = sorted(number for own in sets for number in own)
        if run != sorted(self._trains):
            raise ValueError("not every train is run once")
        for own in sets:
            for before, after in pairwise(own):
                if not self._may(before, after):
                    raise ValueError(f"{after} cannot follow {before}")
        self.refuse_bound(why)
        if why.sets != len(sets):
            raise ValueError(f"it has {len(sets)} sets, not {why.sets}")

    def objections(self, why: FewerCannot) -> list[str]:
        """What is wrong with a certificate; nothing where it holds."""
        try:
            self.refuse_bound(why)
        except ValueError as error:
            return [str(error)]
        return []

    def refuse_bound(self, why: FewerCannot) -> None:
        """ValueError where the certificate does not show that many sets to be needed."""
        if len(set(why.begin)) != len(why.begin) or not set(why.begin) <= self._trains.keys():
            raise ValueError("it names a train twice, or none of the day")
        could = {before for after in why.begin for before in self._trains if self._may(before, after)}
        if not could <= set(why.after):
            raise ValueError(f"{min(could - set(why.after))} could come before one of them")
        if len(why.begin) - len(set(why.after)) != why.sets:
            raise ValueError(f"it shows {len(why.begin) - len(set(why.after))} sets, not {why.sets}")

    def _may(self, before: str, after: str) -> bool:
        one, other, terms = self._trains[before], self._trains[after], self._terms
        if one is other or one.kind != other.kind:
            return False
        waits_s = other.begins.time_s - one.ends.time_s
        at_home = other.begins.place == one.ends.place and other.begins.outside is one.ends.outside
        if terms.empty_mps is None and not at_home:
            return False
        if terms.empty_mps is None and not one.ends.outside and any(self._between(one, other)):
            return False
        if other.follows == before and terms.turn_s == 0 and waits_s >= 0:
            return True
        if not at_home:
            assert terms.empty_mps is not None
            way_m = abs(one.ends.position_m - other.begins.position_m)
            return waits_s >= 0 and waits_s * terms.empty_mps >= way_m
        return waits_s >= (terms.outside_s if one.ends.outside else terms.turn_s + other.turns_s)

    def _between(self, one: RosterTrain, other: RosterTrain) -> Iterator[bool]:
        """Of each other train: whether it ends or begins on the same track meanwhile."""
        for train in self._trains.values():
            if train is not one and train is not other:
                for event in (train.begins, train.ends):
                    same = event.place == one.ends.place
                    yield same and one.ends.time_s <= event.time_s <= other.begins.time_s
