"""A run that people work: the same simulation, driven to a time and not to its end, with faults and acts put into it.

Invariant: what was done is a script, and a run of that script from its beginning is this run, to the byte. So a deed
takes effect at a step to come at which nothing else of a script is due, and the stretch that the kernel has run ahead
is cut there as it would have been had the deed been known: when somebody looks, waits or goes on changes nothing.
Points to go back to are the run of the script up to them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, Final, Self

from console.forecast import DayForecast
from console.line_seen import LineSeen
from network.errors import InputError
from network.files.toml_input import validate
from scenario.scenario import Scenario
from scenario.script_file import ActTable, FaultTable, act_of, names_of, scripted_fault_of
from simulation.faults.fault import Names
from simulation.faults.script import Act, Script, ScriptedFault, Trigger
from simulation.foreseen import TrainMotion
from simulation.journal import Journal
from simulation.late_day import late_day
from simulation.loop import Simulation
from simulation.result import Ending, RunResult
from simulation.setup import STEPS_PER_S, step_not_before
from study.drilling.replay_file import clock_of, replay_of
from study.runner.run import CarrierKind, simulation_of

AT_DESK: Final = "desk"  # where a message says that what is wrong was entered
_IN_FORCE: Final = "the number of a fault in force that was begun here"


@dataclass(frozen=True, slots=True)
class Deed:
    """What somebody did: the item as it is in the script, and the step at which it takes effect.

    `over_step`: a person has ended the fault there. `said_step`: when it was done, of what was armed for later.
    """

    step: int
    item: ScriptedFault | Act
    over_step: int | None = None
    said_step: int | None = None

    @property
    def known_step(self) -> int:
        """From when on it belongs to the run."""
        return self.step if self.said_step is None else self.said_step

    def scripted(self) -> ScriptedFault | Act:
        """The item with its time, and with the duration that it came to have."""
        item = replace(self.item, trigger=Trigger(at_s=self.step / STEPS_PER_S))
        if isinstance(item, ScriptedFault) and self.over_step is not None:
            return replace(item, duration_s=(self.over_step - self.step) / STEPS_PER_S)
        return item

    def as_of(self, step: int) -> Deed:
        """As it was known at a step."""
        return replace(self, over_step=None) if (self.over_step or 0) > step else self


class Session:
    """A scenario's run that is worked; a context manager, since SUMO carries one run a process."""

    def __init__(self, scenario: Scenario, carrier: CarrierKind = CarrierKind.SUMO) -> None:
        self._scenario: Final = scenario
        self._carrier: Final = carrier
        _check(scenario)
        self.names: Final[Names] = names_of(scenario.setup)
        self.deeds: list[Deed] = []
        self.line = LineSeen(scenario.setup)  # anew with each run
        self.step = 0
        self.ended: Ending | None = None
        self._result: RunResult | None = None
        self._stack = ExitStack()
        self._simulation: Simulation | None = None

    def __enter__(self) -> Self:
        self._open()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def scenario(self) -> Scenario:
        """What is run."""
        return self._scenario

    @property
    def simulation(self) -> Simulation:
        """The run. RuntimeError before the context has begun."""
        if self._simulation is None:
            raise RuntimeError("the session is not open")
        return self._simulation

    @property
    def journal(self) -> Journal:
        """What has happened until now."""
        return self.simulation.journal

    @property
    def now_s(self) -> float:
        """The present, s since midnight."""
        return self.step / STEPS_PER_S

    @property
    def result(self) -> RunResult:
        """What the run left behind. RuntimeError before it has ended."""
        if self.ended is None:
            raise RuntimeError("the run goes on")
        if self._result is None:
            self._result = self.simulation.result_of(self.ended)
        return self._result

    def motion(self, slot: int) -> TrainMotion:
        """Where a train on the line is now, on its true path."""
        simulation = self.simulation
        if self.ended is not None:
            speed_mps = float(simulation.trains.plants[slot].speed_mps)
            return TrainMotion(float(simulation.trains.truths[slot].position_m), speed_mps)
        return simulation.motion_at(slot, self.step)

    # going on ---------------------------------------------------------------------------------------------------------

    def run_to(self, step: int) -> None:
        """Go on to a step, or to the end of the run; a step that has passed is left alone."""
        while self.ended is None and self._stretch_end <= step:
            self.simulation.go_on()
            self._settle()
        self.step = self.simulation.step if self.ended is not None else max(self.step, step)

    def next_event(self) -> None:
        """Go on to where the next thing happens or is due, at most some seconds."""
        if self.ended is None:
            self.run_to(self._stretch_end)

    def run_to_end(self) -> RunResult:
        """Go on until the run has ended."""
        while self.ended is None:
            self.next_event()
        return self.result

    def _open(self) -> None:
        setup = replace(self._scenario.setup, script=self._whole_script())
        self._simulation = self._stack.enter_context(simulation_of(setup, carrier=self._carrier))
        self.line = LineSeen(setup, DayForecast(setup))
        self._simulation.journal.watch(self.line.see)
        self.ended, self._result = None, None
        self.step = self._simulation.step
        self._simulation.begin()
        self._settle()

    def _settle(self) -> None:
        self.ended = self.simulation.settle()
        if self.ended is None:
            self._stretch_end = self.simulation.foresee()

    # what people do ---------------------------------------------------------------------------------------------------

    def fail(self, table: Mapping[str, Any]) -> int:
        """A fault begins as soon as it can, written as in a `[[fault]]` without its `start`; its number among deeds.

        InputError for what a drill could not have either.
        """
        timed = validate(self._timed(table), AT_DESK, FaultTable)
        return self._insert(scripted_fault_of(AT_DESK, "fault", timed, self.names))

    def act(self, table: Mapping[str, Any]) -> int:
        """A person acts as soon as possible, written as in an `[[act]]` without its `start`; its number among deeds.

        InputError for what a drill could not have either.
        """
        timed = validate(self._timed(table), AT_DESK, ActTable)
        return self._insert(act_of(AT_DESK, "act", timed, self.names))

    def arm(self, faults: Sequence[Mapping[str, Any]], acts: Sequence[Mapping[str, Any]]) -> list[int]:
        """Faults and acts at times to come, written as a drill has them; their numbers. InputError: none is armed."""
        items: list[ScriptedFault | Act] = []
        for k, table in enumerate(faults):
            items.append(
                scripted_fault_of(AT_DESK, f"fault[{k}]", validate(table, AT_DESK, FaultTable), self.names)
            )
        for k, table in enumerate(acts):
            items.append(act_of(AT_DESK, f"act[{k}]", validate(table, AT_DESK, ActTable), self.names))
        due = [self._due_step(item) for item in items]
        return [self._insert(item, step) for item, step in zip(items, due, strict=True)]

    def _due_step(self, item: ScriptedFault | Act) -> int:
        at_s = item.trigger.at_s
        step = -1 if at_s is None else step_not_before(at_s + item.trigger.after_s)
        if step <= self.step:
            raise InputError(
                AT_DESK, "start", "" if at_s is None else clock_of(step), "a time to come, not an event"
            )
        return step

    def change_fault(self, number: int, keys: Mapping[str, Any]) -> int:
        """A fault in force goes on with other figures: one with them begins, then it is over; the new number.

        InputError for one that is not in force, and for keys that its kind has not.
        """
        if not self.can_end(number):
            raise InputError(AT_DESK, "number", number, _IN_FORCE)
        fault = self.deeds[number].item
        if not isinstance(fault, ScriptedFault):
            raise InputError(AT_DESK, "number", number, _IN_FORCE)
        table = {
            "kind": fault.fault.kind,
            "target": str(fault.fault.target),
            **fault.fault.parameters(),
            **keys,
        }
        if fault.duration_s is not None:  # it is over when it would have been
            ends = self.deeds[number].step + round(fault.duration_s * STEPS_PER_S)
            table = {"duration_s": max(ends - self._free_step(), 1) / STEPS_PER_S, **table}
        changed = self.fail(table)
        self.end_fault(number)
        return changed

    def end_fault(self, number: int) -> None:
        """A fault that somebody began is over as soon as possible. InputError for one that is not in force."""
        key = self._key_in_force(number)
        if key is None:
            raise InputError(AT_DESK, "number", number, _IN_FORCE)
        step = self._free_step()
        self.simulation.end_fault(key, step)
        self._stretch_end = self.simulation.foresee()
        self.deeds[number] = replace(self.deeds[number], over_step=step)

    def can_end(self, number: int) -> bool:
        """Whether a deed is a fault in force."""
        return self._key_in_force(number) is not None

    def _key_in_force(self, number: int) -> int | None:
        """What the injector calls the fault in force that is this deed; None where it is none."""
        if self.ended is not None or not 0 <= number < len(self.deeds):
            return None
        deed = self.deeds[number]
        if not isinstance(deed.item, ScriptedFault) or deed.over_step is not None:
            return None
        before = sum(isinstance(other.item, ScriptedFault) for other in self.deeds[:number])
        key = len(self._scenario.setup.script.faults) + before
        return key if self.simulation.injector.in_force(key) else None

    def _timed(self, table: Mapping[str, Any]) -> dict[str, Any]:
        """As if written for the present; the step at which it takes effect replaces that."""
        return dict(table) | {"start": clock_of(self.step), "after_s": 0.0}

    def _insert(self, item: ScriptedFault | Act, due_step: int | None = None) -> int:
        if self.ended is not None:
            raise InputError(AT_DESK, "", None, "a run that has not ended")
        step = self._free_step(due_step)
        self.simulation.insert(item, step)
        self._stretch_end = self.simulation.foresee()
        self.deeds.append(Deed(step, item, said_step=None if due_step is None else self.step))
        return len(self.deeds) - 1

    def _free_step(self, due_step: int | None = None) -> int:
        """The next step, or the first from when it is due, at which nothing of a script is due: a drill file has no
        order between faults and acts.
        """
        step = self.step + 1 if due_step is None else due_step
        while not self.simulation.is_free(step):
            step += 1
        return step

    # the script -------------------------------------------------------------------------------------------------------

    def script(self) -> Script:
        """What was done here, in its order."""
        items = [deed.scripted() for deed in self.deeds]
        return Script(
            tuple(item for item in items if isinstance(item, ScriptedFault)),
            tuple(item for item in items if isinstance(item, Act)),
        )

    @property
    def has_script(self) -> bool:
        """Whether there is a fault or an act, of the scenario's or done here."""
        own = self._scenario.setup.script
        return bool(self.deeds or own.faults or own.acts)

    def _whole_script(self) -> Script:
        own, done = self._scenario.setup.script, self.script()
        return replace(own, faults=(*own.faults, *done.faults), acts=(*own.acts, *done.acts))

    def drill_text(self, own_id: str, title: str) -> str:
        """The drill file of what was done: `branchline drill` runs it to the journal of this run."""
        return replay_of(self._scenario, self.script(), own_id, title, beside=True)

    def go_back(self, step: int) -> None:
        """Be again where the run was at a step, by running the script up to it; what was done later is undone.

        InputError for a step that has not come yet.
        """
        first, last = self.simulation.begin_step, self.step
        if not first <= step <= last:
            expected = f"a time from {clock_of(first)} to {clock_of(last)}"
            raise InputError(AT_DESK, "time", clock_of(step), expected)
        self.deeds = [deed.as_of(step) for deed in self.deeds if deed.known_step <= step]
        self._stack.close()
        self._open()
        self.run_to(step)


def _check(scenario: Scenario) -> None:
    """InputError for a run that a script cannot give back."""
    if late_day(scenario.setup).failures:
        expected = "no failures and dead zones: what is broken here is numbered before what breaks by chance"
        raise InputError(scenario.file, "late", None, expected)
    if scenario.setup.tuning.days > scenario.setup.day:
        raise InputError(
            scenario.file, "tuning.days", scenario.setup.tuning.days, "no days of learning before this one"
        )
