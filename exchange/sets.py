"""Which set runs which trains, once it is known how each of them begins and ends: named, in as few sets as can be."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from exchange.planned import TrainOnLine, Working
from network.errors import InputError
from network.files.names import is_identifier


@dataclass(frozen=True, slots=True)
class SetPlan:
    """Trains in order of time, how each begins and ends, and of each portal the place where its sets wait."""

    trains: Mapping[str, TrainOnLine]
    begins: Mapping[str, str]
    ends: Mapping[str, str]
    outside: Mapping[str, str]
    outside_min_s: int
    stock: tuple[str, ...] = ()  # the sets there are; as few as can run the day where none are named
    taken: Collection[str] = ()  # names that no set may have


@dataclass(slots=True)
class _Round:
    """Sets so far: what each ran, where it was left and when, and the working that it belongs to."""

    plan: SetPlan
    file: str
    runs: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    left: dict[str, tuple[str, int]] = field(default_factory=dict[str, tuple[str, int]])
    working: dict[str, str] = field(default_factory=dict[str, str])  # of a set
    owner: dict[str, str] = field(default_factory=dict[str, str])  # of a working
    to_come: dict[str, int] = field(default_factory=dict[str, int])  # runs of a working not given yet

    def run(self, name: str, head: str) -> None:
        """A set runs a train and those that it becomes."""
        plan = self.plan
        numbers = chain(plan.ends, head)
        last = plan.trains[numbers[-1]]
        self.runs.setdefault(name, []).extend(numbers)
        where = _place(plan, plan.ends[last.number], last.calls[-1].station_id)
        self.left[name] = (where, last.calls[-1].last_s)
        working = _working(plan, numbers)
        if working:
            self.to_come[working] -= 1
            self.owner.setdefault(working, name)
            self.working.setdefault(name, working)

    def new(self, head: str) -> str:
        """A name for one more set: of the stock, of its working, or V1, V2, ... InputError where the stock ends."""
        plan = self.plan
        if plan.stock:
            free = [name for name in plan.stock if name not in self.runs]
            if not free:
                none_for = (
                    f"none is free for {head}" if plan.begins[head] != "stabled" else f"{head} needs one"
                )
                expected = f"a day that {len(plan.stock)} sets can run: {none_for}"
                raise InputError(self.file, "", None, expected)
            return free[0]
        wish = _working(plan, chain(plan.ends, head))
        if wish and self._may_be(wish) and wish not in self.owner:
            return wish
        number = 1
        while not self._may_be(f"V{number}") or f"V{number}" in self.to_come:
            number += 1
        return f"V{number}"

    def _may_be(self, name: str) -> bool:
        return is_identifier(name) and name not in self.runs and name not in self.plan.taken

    def own(self, head: str) -> str | None:
        """The set of the head's working, where it stands (waits) and in time."""
        working = _working(self.plan, chain(self.plan.ends, head))
        name = self.owner.get(working) if working else None
        if name is None:
            return None
        first = self.plan.trains[head].calls[0]
        where = _place(self.plan, self.plan.begins[head], first.station_id)
        was, ended_s = self.left[name]
        return name if was == where and ended_s <= first.first_s else None

    def longest_outside(self, head: str) -> str | None:
        """The set that has waited longest beyond the head's portal, and is not wanted by a working of its own."""
        first = self.plan.trains[head].calls[0]
        where = _place(self.plan, self.plan.begins[head], first.station_id)
        back = [
            (ended_s, list(self.runs).index(name), name)
            for name, (was, ended_s) in self.left.items()
            if was == where
            and ended_s + self.plan.outside_min_s <= first.first_s
            and not self.to_come.get(self.working.get(name, ""), 0)
        ]
        return min(back)[2] if back else None


def give_sets(plan: SetPlan, file: str) -> tuple[Working, ...]:
    """A set for every train: those that stand on the line in the morning first, then as trains come in by portals.

    Trains of one published working have one set where it can be. `file` names the source in the InputError where the
    stock does not suffice.
    """
    sets = _Round(plan, file)
    heads = [number for number in plan.trains if not plan.begins[number].startswith("from:")]
    first_of: dict[str, str] = {}
    for head in heads:
        working = _working(plan, chain(plan.ends, head))
        if working:
            sets.to_come[working] = sets.to_come.get(working, 0) + 1
            first_of.setdefault(working, head)
    morning = [
        head
        for head in heads
        if plan.begins[head] == "stabled"
        and first_of.get(_working(plan, chain(plan.ends, head)), head) == head
    ]
    for head in morning:
        sets.run(sets.new(head), head)
    for head in heads:
        if head in morning:
            continue
        name = sets.own(head)
        unnamed = not _working(plan, chain(plan.ends, head))
        spare = any(known not in sets.runs for known in plan.stock)
        if name is None and unnamed and not spare and plan.begins[head] != "stabled":
            name = sets.longest_outside(head)
        sets.run(name if name is not None else sets.new(head), head)
    return tuple(Working(name, tuple(numbers)) for name, numbers in sets.runs.items())


def chain(ends: Mapping[str, str], number: str) -> list[str]:
    """Numbers of a train and of those its set becomes without leaving the line."""
    numbers = [number]
    while (end := ends[numbers[-1]]).startswith("becomes:"):
        numbers.append(end.removeprefix("becomes:"))
    return numbers


def _working(plan: SetPlan, numbers: Sequence[str]) -> str:
    """The published working of trains that one set runs; empty where none of them has one."""
    return next((text for number in numbers if (text := plan.trains[number].working)), "")


def _place(plan: SetPlan, how: str, station_id: str) -> str:
    """Where a set is that begins or ends so: outside a station, or at it."""
    portal = how.removeprefix("portal:")
    return f"outside {plan.outside[portal]}" if portal != how else f"at {station_id}"
