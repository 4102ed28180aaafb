"""`pilots-leave`: a train whose unit is cut out comes into a section between stations by the pilot's leave alone.

By the truth, and by what people wrote down as done: to begin there, for this very train since it was taken up, and of
the train before it that it has arrived. While such working is in force there, no train comes in under authority either.
Rules of trains under authority are for those; that two trains are in one section is a breach whoever leads them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from simulation.events import CutIn, CutOut, Event, ProcedureStep
from simulation.judge.log import Checker, Log
from simulation.procedure import WorkingStep


class PilotWatch:
    """`needs`: by section between stations, the steps that must have been done before a train comes in."""

    def __init__(self, needs: Mapping[str, Sequence[WorkingStep]], log: Log) -> None:
        self._needs = needs
        self._log = log
        self._done: dict[str, set[str]] = {section_id: set() for section_id in needs}
        self._of_train: dict[tuple[str, str], set[str]] = {}
        self._let_in: dict[str, dict[str, None]] = {section_id: {} for section_id in needs}
        self._rides: dict[str, str] = {}  # with which train the pilot of a section is under way
        self.cut_out: set[str] = set()  # units

    def see(self, event: Event) -> None:
        """Somebody wrote something down, or a driver cut his unit out or in."""
        match event:
            case CutOut(unit_id=unit_id):
                self.cut_out.add(unit_id)
            case CutIn(unit_id=unit_id):
                self.cut_out.discard(unit_id)
            case ProcedureStep(block=block, step=step, unit_id="") if block in self._needs:
                self._done[block].add(step)
                nobody = WorkingStep.PILOT.value not in self._done[block]
                if step == WorkingStep.RELEASE.value or (step == WorkingStep.STOP.value and nobody):
                    self._is_over(block)
            case ProcedureStep(block=block, step=step, unit_id=unit_id) if block in self._needs:
                self._of_train.setdefault((block, unit_id), set()).add(step)
                if step == WorkingStep.ARRIVED.value:
                    self._let_in[block].pop(unit_id, None)
                elif step == WorkingStep.BOARD.value:  # there is one pilot
                    self._rides[block] = unit_id
                    for other, steps in self._of_train.items():
                        if other[0] == block and other[1] != unit_id:
                            steps.discard(step)
                elif step == WorkingStep.ALIGHT.value:
                    self._rides.pop(block, None)
                elif step == WorkingStep.TICKET.value and block in self._rides:
                    self._of_train[block, unit_id].discard(step)  # he is not there, so it is none
            case _:
                pass

    def _is_over(self, block: str) -> None:
        """What was done in a section, and for trains that did not come, is for no later working there."""
        self._done[block].clear()
        self._let_in[block].clear()
        self._rides.pop(block, None)
        self._of_train = {key: steps for key, steps in self._of_train.items() if key[0] != block}

    def came_in(self, t_s: float, unit_id: str, section_ids: Iterable[str]) -> None:
        """A train came into these sections."""
        for section_id in sorted(set(section_ids).intersection(self._needs)):
            done = self._done[section_id]
            of_train = self._of_train.pop((section_id, unit_id), set())
            subject = f"{section_id} {unit_id}"
            if unit_id not in self.cut_out:
                if WorkingStep.PILOT.value in done:
                    text = f"{unit_id} came into section {section_id} under authority, where a pilot has it"
                    self._log.note(t_s, Checker.PILOTS_LEAVE, subject, text)
                continue
            if WorkingStep.TICKET.value in of_train:  # as good as the pilot
                of_train.add(WorkingStep.BOARD.value)
            missing = [s.value for s in self._needs[section_id] if s.value not in done | of_train]
            missing += [
                f"{WorkingStep.ARRIVED.value} of {o}" for o in self._let_in[section_id] if o != unit_id
            ]
            self._let_in[section_id][unit_id] = None
            if missing:
                text = f"{unit_id} came into section {section_id} without the pilot's leave: no {', '.join(missing)}"
                self._log.note(t_s, Checker.PILOTS_LEAVE, subject, text)
