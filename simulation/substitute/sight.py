"""What those who work a line by substitute working see of it, and what it lets them do.

They see the truth of what is before their eyes: where trains stand, whether points are free, whether a section is.
"""

from __future__ import annotations

from typing import Final

from simulation.duties import Duties
from simulation.procedure import Part, ProcedureRow, WorkingStep
from simulation.setup import STEPS_PER_S
from simulation.substitute.by_hand import HandDriver
from simulation.substitute.hops import Hop, hops_of
from simulation.substitute.work import Work
from simulation.world.roster import Duty
from simulation.world.stage import World
from wayside.config import MANAGER_ID

BY_ROAD = True  # off: a pilot waits for a train that brings him to where he is needed
AT_TRAIN: Final = frozenset({WorkingStep.TICKET, WorkingStep.BOARD, WorkingStep.CUT_OUT, WorkingStep.GO})
NOT_HERE: Final = "the train does not stand there"
NO_PILOT: Final = "the pilot is not there"
UNDER_TRAIN: Final = "a train is on the points"
NOT_CUT_OUT: Final = "its unit is not cut out"
WAY_IN_TAKEN: Final = "another train stands where it would come in"
NOT_ABOARD: Final = "the pilot is not aboard"
STILL_RUNS: Final = "the train has not come to a stand there"
REFUSALS: Final = (NOT_HERE, NO_PILOT, UNDER_TRAIN, NOT_CUT_OUT, WAY_IN_TAKEN, NOT_ABOARD, STILL_RUNS)


class LineSight:
    """The line as its people see it."""

    def __init__(self, world: World, duties: Duties, drivers: HandDriver) -> None:
        self._setup = world.setup
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._duties, self._drivers = duties, drivers
        self._ways_of: tuple[tuple[Duty, ...], ...] = ()
        self._ways: tuple[Hop, ...] = ()

    @property
    def hops(self) -> tuple[Hop, ...]:
        """All ways of the day, as orders have changed them: another track, a train ended early."""
        duties = self._duties.of_stock
        if (now := tuple(duties.values())) != self._ways_of:
            self._ways_of, self._ways = now, hops_of(duties)
        return self._ways

    def lets(self, work: Work, row: ProcedureRow, hop: Hop | None, step: int) -> bool:
        """Whether the world lets a step be done as its table has it: what the step waits for has come."""
        if row.part is Part.TRAIN and hop is not None:
            return self._lets_train(work, row.step, hop, step)
        if row.step in (WorkingStep.CLEAR, WorkingStep.EMPTY):
            return not work.block or self._is_clear(work.name)
        return row.step is not WorkingStep.STOP or MANAGER_ID not in self._wayside.down

    def refuses(self, work: Work, row: ProcedureRow, hop: Hop | None) -> str:
        """Why a step cannot be done at all, whoever wants it: equipment, or where people and trains are."""
        if hop is None:
            return NOT_HERE if row.part is Part.TRAIN else ""
        why = ""
        match row.step:
            case WorkingStep.POINTS if not self._are_free(self._points_sections(hop), hop.stock_id):
                why = UNDER_TRAIN
            case step if step in AT_TRAIN and not self.stands(hop):
                why = NOT_HERE
            case WorkingStep.TICKET if work.book.pilot != hop.origin:
                why = NO_PILOT
            case WorkingStep.BOARD if not self._can_board(work, hop):
                why = NO_PILOT
            case WorkingStep.CUT_OUT if not self._may_come_in(hop):
                why = WAY_IN_TAKEN
            case WorkingStep.GO if self._trains.slot_of[hop.stock_id] not in self._drivers.driven:
                why = NOT_CUT_OUT
            case WorkingStep.GO if not self._has_turned(hop):
                why = NOT_HERE
            case WorkingStep.ALIGHT if work.book.pilot != hop.stock_id:
                why = NOT_ABOARD
            case WorkingStep.ALIGHT if not self._has_come(hop):
                why = STILL_RUNS
            case _:
                pass
        return why

    def _lets_train(self, work: Work, kind: WorkingStep, hop: Hop, step: int) -> bool:
        match kind:
            case WorkingStep.AGREE:
                lets = self._may_be_let_in(hop, hop.after_block)
            case WorkingStep.POINTS:
                lets = self._are_free(self._points_sections(hop), hop.stock_id)
                if all(each.step is not WorkingStep.AGREE for each in work.table):  # nobody has looked before
                    lets = lets and self._may_be_let_in(
                        hop, hop.after_block if work.block else hop.section_ids
                    )
            case WorkingStep.BOARD:
                lets = self._can_board(work, hop)
            case WorkingStep.CUT_OUT:
                lets = self._may_come_in(hop)
            case WorkingStep.GO:
                lets = step / STEPS_PER_S >= hop.planned_s and self._has_turned(hop)
            case WorkingStep.ARRIVED:
                lets = self._has_come(hop)
            case WorkingStep.ALIGHT:  # who has it reported too early does not get off sooner by that
                lets = WorkingStep.ARRIVED in work.book.left_out or self.is_over(hop)
            case _:
                lets = True
        return lets

    def _can_board(self, work: Work, hop: Hop) -> bool:
        return work.book.pilot in (*(work.ends if BY_ROAD else (hop.origin,)), hop.stock_id)

    def _is_clear(self, block: str) -> bool:
        """No train is in the section, and no unit that works shows its driver that it may run into it."""
        if self._trains.stands_in(block):
            return False
        slots = (slot for slot in self._trains.active() if slot not in self._on_board.unpowered)
        return not any(block in self._on_board.shown_to_driver(slot).held for slot in slots)

    def _are_free(self, section_ids: tuple[str, ...], stock_id: str) -> bool:
        under = self._trains.sections_under()
        others = (sections for other, sections in under.items() if other != stock_id)
        return not any(sections.intersection(section_ids) for sections in others)

    def _may_be_let_in(self, hop: Hop, section_ids: tuple[str, ...]) -> bool:
        """No train is in these sections, no unit that works shows its driver that it may run there, and none that ends
        there before by the plan, coming another way, is yet to come: who lets them in keeps several books.
        """
        wanted, slots = set(section_ids), self._trains.slot_of.items()
        others = (slot for stock_id, slot in slots if stock_id != hop.stock_id)
        under_authority = (slot for slot in others if slot not in self._on_board.unpowered)
        if any(wanted.intersection(self._on_board.shown_to_driver(slot).held) for slot in under_authority):
            return False
        return self._are_free(section_ids, hop.stock_id) and all(
            self.is_over(other)
            for other in self.hops
            if other.stock_id != hop.stock_id
            and other.work != hop.work
            and other.section_ids[-1] in wanted
            and other.ends_s < hop.ends_s
        )

    def _points_sections(self, hop: Hop) -> tuple[str, ...]:
        return tuple(self._setup.line.points[points].section_id for points, _ in hop.points)

    def _may_come_in(self, hop: Hop) -> bool:
        slot = self._trains.slot_of[hop.stock_id]
        outside = not self._trains.truths[slot].active
        return not (outside and self._trains.stands_in(hop.begins_in))

    # where trains are -------------------------------------------------------------------------------------------------

    def stands(self, hop: Hop) -> bool:
        """Whether the train stands where the way begins, on the line or outside its portal, or is yet to turn there."""
        slot = self._trains.slot_of[hop.stock_id]
        duty, at = self._duties.progress(slot)
        turns = hop.begin == 0 and duty == hop.duty - 1 and self._duties.is_to_turn(slot)
        begins = (-1.0, 0.0) if hop.begin == 0 else (float(hop.begin),)
        if not turns and (duty, at) not in [(hop.duty, target) for target in begins]:
            return False
        return at < 0.0 or self.stands_still(slot)

    def _has_turned(self, hop: Hop) -> bool:
        """Whether the train before it is over, and its driver has this one's number."""
        return self._duties.progress(self._trains.slot_of[hop.stock_id])[0] == hop.duty

    def is_over(self, hop: Hop) -> bool:
        """Whether the train has come to where the way ends, or further."""
        return self._duties.progress(self._trains.slot_of[hop.stock_id]) >= (hop.duty, float(hop.end))

    def _has_come(self, hop: Hop) -> bool:
        return self.is_over(hop) and self.stands_still(self._trains.slot_of[hop.stock_id])

    def stands_still(self, slot: int) -> bool:
        """Whether a train does not move, or is off the line."""
        return not self._trains.truths[slot].active or self._trains.plants[slot].speed_mps == 0.0

    def next_hop(self, work: Work, after: Hop | None = None) -> Hop | None:
        """The next way by the plan whose train has not come, as far as people know."""
        over = work.taken_as_over
        return next(
            (hop for hop in work.hops if hop not in over and hop != after and not self.is_over(hop)), None
        )
