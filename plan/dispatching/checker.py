"""What is wrong with a solution, told after the description of DISPLIB (section 1.1); it shares nothing with a solver.

Time and the order of events are both judged: at equal times a resource must be released before it is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

from plan.dispatching.instance import Instance, Solution, StartEvent

SAID_MAX: Final = 20  # of what is wrong; one is enough to refuse


def objections(instance: Instance, solution: Solution) -> list[str]:
    """What is wrong with it, at most `SAID_MAX`; nothing where it is one."""
    said = list(_unknown(instance, solution.events))
    if not said:
        said = [
            *_unordered(solution.events),
            *_paths(instance, solution.events),
            *_shared(instance, solution.events),
            *_cost(instance, solution),
        ]
    return said[:SAID_MAX]


def _name(event: StartEvent) -> str:
    return f"train {event.train}, operation {event.operation}, at {event.time}"


def _unknown(instance: Instance, events: tuple[StartEvent, ...]) -> Iterator[str]:
    for event in events:
        if event.train >= len(instance.trains) or event.operation >= len(instance.trains[event.train]):
            yield f"{_name(event)}: the instance has no such operation"


def _unordered(events: tuple[StartEvent, ...]) -> Iterator[str]:
    for before, after in pairwise(events):
        if after.time < before.time:
            yield f"{_name(after)}: comes after {_name(before)}"


def _paths(instance: Instance, events: tuple[StartEvent, ...]) -> Iterator[str]:
    """Whether each train runs from its entry to its exit, each operation as early, late and long as it may be."""
    for a, train in enumerate(instance.trains):
        own = [event for event in events if event.train == a]
        if not own or own[0].operation != 0:
            yield f"train {a}: does not begin with its operation 0"
        if own and own[-1].operation != len(train) - 1:
            yield f"{_name(own[-1])}: is the train's last one, and not its exit"
        for event in own:
            operation = train[event.operation]
            if event.time < operation.start_lb:
                yield f"{_name(event)}: earlier than {operation.start_lb}"
            if operation.start_ub is not None and event.time > operation.start_ub:
                yield f"{_name(event)}: later than {operation.start_ub}"
        for event, following in pairwise(own):
            operation = train[event.operation]
            if following.operation not in operation.successors:
                yield f"{_name(following)}: cannot follow operation {event.operation}"
            if following.time - event.time < operation.min_duration:
                yield f"{_name(event)}: ends at {following.time}, before it has lasted {operation.min_duration}"


def _shared(instance: Instance, events: tuple[StartEvent, ...]) -> Iterator[str]:
    """Whether each resource was let go of by all others, in the order of events and for as long as it has to be."""
    running: dict[int, StartEvent] = {}
    had: dict[str, dict[int, StartEvent]] = {}  # who has a resource now, by train
    free_at: dict[str, dict[int, int]] = {}  # when those who had it have let go of it, by train
    for event in events:
        ended = running.pop(event.train, None)
        if ended is not None:
            for use in instance.trains[event.train][ended.operation].resources:
                del had[use.resource][event.train]
                times = free_at.setdefault(use.resource, {})
                times[event.train] = max(times.get(event.train, 0), event.time + use.release_time)
        for use in instance.trains[event.train][event.operation].resources:
            for other in had.get(use.resource, {}).values():
                yield f"{_name(event)}: takes {use.resource}, which {_name(other)} still has"
            for other_train, free in free_at.get(use.resource, {}).items():
                if other_train != event.train and event.time < free:
                    yield f"{_name(event)}: takes {use.resource}, which train {other_train} leaves at {free}"
            had.setdefault(use.resource, {})[event.train] = event
        running[event.train] = event


def _cost(instance: Instance, solution: Solution) -> Iterator[str]:
    cost = cost_of(instance, solution.events)
    if cost != solution.objective_value:
        yield f"objective_value is {solution.objective_value}, and the events cost {cost}"


def cost_of(instance: Instance, events: tuple[StartEvent, ...]) -> int:
    """The sum of what the delays cost; an operation that no train runs costs nothing."""
    starts = {(event.train, event.operation): event.time for event in events}
    times = ((delay, starts.get((delay.train, delay.operation))) for delay in instance.objective)
    return sum(delay.cost(start) for delay, start in times if start is not None)
