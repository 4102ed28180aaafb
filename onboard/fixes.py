"""What fixes other than those of tags mean to a unit: journal, a position found anew, virtual tags, the driver's word.

Part of the driving part (`onboard.motion`) between its events. A position that was unknown and that a sensor tells is
believed only where the unit holds all that its train may then stand in: curvature and satellites do not tell the loop
from the main track, while the register has which of them the points were locked for (decision 037).
"""

from __future__ import annotations

import math
from typing import Any, Final

from network.model import SectionKind
from onboard import notes
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.duty.records import AtMark, DrivingCommand, FoundByOtherSensor, Sensed, TagBelieved, TagReached
from onboard.localisation.fix import (
    FOREIGN,
    MISSED,
    NOTHING,
    OUTCOMES,
    REFUSED,
    TAKEN,
    cut_interval,
    missed_m,
)
from onboard.localisation.places import Places
from onboard.localisation.sighting import begin_slack, sign
from onboard.localisation.table import READER_NAMES
from onboard.localisation.tags import TagDoubt
from onboard.mission import Mission, PathTag, Target
from onboard.plan import ARRIVED_ON_SIGHT_WITHIN_M
from onboard.records import EVENT_FOUND, EVENT_PLACE, EVENT_POSITION, UnitRow
from onboard.unit_records import UnitParameters

SIGN: Final = sign.__name__
EYE: Final = "driver's eye"
EYE_WITHIN_M: Final = (
    ARRIVED_ON_SIGHT_WITHIN_M  # of what a driver says: ten metres to the nearest, and a metre
)
# bounds wider than what the driver's eye leaves are worth asking him
UNSURE_OVER_M: Final = EYE_WITHIN_M + 1.0


ROOM_M: Final = LIMIT_MARGIN_M + RESERVE_M  # nearer to its stop limit no train starts


class Fixes:
    """Of one unit; `virtual`: its train has no reader of tags, so that fixes pass the places of tags."""

    def __init__(
        self,
        doubt: TagDoubt,
        record: UnitRow,
        readers: Any,  # noqa: ANN401
        parameters: UnitParameters,
        length_m: float,
        said: list[notes.Note],
    ) -> None:
        self._row: Final = doubt.row
        self._record: Final = record  # the same memory, as compiled code takes it
        self._readers: Final = readers
        self._doubt: Final = doubt
        self._length_m: Final = length_m
        self._tag_within_m: Final = parameters.tag_accuracy_m
        self._places: Final = Places(doubt.row, parameters)
        self._mission: Mission | None = None
        self._outcomes = [NOTHING] * len(READER_NAMES)  # as last looked at
        self._virtual = False
        self._doubted = False  # a position found that is not believed, and said so
        self._elsewhere = False  # a tag was read that does not lie on its path
        self._tight = (
            False  # the position was given up since it left no room to go on, or was not the driver's
        )
        self.untold = False  # which track it is on rests on the register
        self.notes: Final = said

    def take_up(self, mission: Mission, *, virtual: bool) -> None:
        """Another mission, from where the train stands."""
        self._mission, self._virtual, self._elsewhere = mission, virtual, False
        if virtual:
            self._places.take_up(mission.tags)
        else:
            self._places.forget()
            self._doubt.watch()

    def forget_sign(self) -> None:
        """What came of the camera's readings so far is of no interest: it looks for another sign."""
        number = READER_NAMES.index(SIGN)
        self._outcomes[number] = self._readers.outcome[number] = NOTHING

    def doubt(self, *, tight: bool = False) -> None:
        """The position is lost; `tight`: given up, since with it the train would come no further."""
        self._places.doubt()
        self.untold, self._tight = False, self._tight or tight
        self._row.found = 0

    def stand_back(self) -> None:
        """A tag was read: what another sensor has found in this very step was not believed yet, and is not."""
        if self._row.found:
            self._row.position_known = self._row.found = 0

    def tag_believed(self, tag: PathTag, correction_m: float) -> None:
        """A real tag has told the position: it lies on one track only."""
        moved_m = round(correction_m, 3)
        self.notes.append(notes.TagRead(tag_id=tag.tag_id, purpose=tag.purpose, correction_m=moved_m))
        begin_slack(self._readers.sign, self._row, self._tag_within_m + self._row.pulse_m)
        self.untold = self._elsewhere = self._tight = False

    def tag_of_another_path(self) -> None:
        """A real tag was read that is not on the path: until one that is tells so, no other sensor can."""
        self._elsewhere = True

    @property
    def ask_m(self) -> float:
        """Where the estimate next reaches a virtual tag that asks for something ahead; +inf: nowhere."""
        return self._places.ask_m

    @property
    def unsure(self) -> bool:
        """Whether the bounds leave open whether the train is at its mark, and the driver may be asked."""
        return self._virtual and not self.narrow

    @property
    def narrow(self) -> bool:
        """Whether the bounds are as narrow as the driver's eye leaves them, wherever in them the estimate is."""
        return bool(self._row.bound_ahead_m + self._row.bound_behind_m <= 2.0 * UNSURE_OVER_M)

    # what came of readings ----------------------------------------------------------------------------------------

    def sign_missed(self, target: Target | None) -> bool:
        """Write down what came of readings where it is another than before; whether it is that no sign has come."""
        missed = False
        for number, name in enumerate(READER_NAMES):
            before, outcome = self._outcomes[number], int(self._readers.outcome[number])
            self._outcomes[number] = outcome
            if outcome in (before, NOTHING):
                continue
            moved_m = round(float(self._readers.moved_m[number]), 3)
            if outcome == REFUSED:
                self.notes.append(notes.FixRefused(reader=name))
            elif name == SIGN:
                missed = missed or outcome == MISSED
                if outcome == TAKEN and target is not None:
                    self.notes.append(notes.SignSeen(station=target.station_id, correction_m=moved_m))
            elif outcome == TAKEN:
                note = notes.FixTaken(reader=name, correction_m=moved_m, after=OUTCOMES[before])
                self.notes.append(note)
            elif outcome == FOREIGN:
                self.notes.append(notes.ForeignTrack(reader=name))
            elif outcome == MISSED:
                self.notes.append(notes.FixMissed(reader=name))
        return missed

    # what they mean to the duty -----------------------------------------------------------------------------------

    def take_events(self, bits: int, command: DrivingCommand) -> list[Sensed]:
        """What the tick reported of fixes."""
        happened: list[Sensed] = []
        if bits & EVENT_PLACE and not self._virtual:
            self._doubt.fix_came()
        if bits & EVENT_FOUND and self._row.found:  # and no tag read in the same step knows better
            self._row.found = 0
            happened += self._found(READER_NAMES[self._row.fix_reader], command, by_eye=False)
        if self._virtual and self._row.position_known and bits & (EVENT_PLACE | EVENT_FOUND):
            happened += self._passed(READER_NAMES[self._row.fix_reader])
        if self._virtual and self._row.position_known and bits & (EVENT_POSITION | EVENT_FOUND):
            happened += [TagReached(index) for index in self._places.tags_reached()]
        return happened

    def at_mark(self, event: AtMark, command: DrivingCommand) -> list[Sensed]:
        """The driver's eye has told where the train stands: what a unit without a reader of tags makes of it."""
        if not self._virtual or self._mission is None:
            return []
        row = self._row
        known, before_m = bool(row.position_known), float(row.position_m)
        front_m = self._mission.targets[event.stop].mark_m + event.beyond_m
        if missed_m(self._record, front_m, EYE_WITHIN_M, EYE_WITHIN_M) > 0.0:
            row.position_known = 0  # an eye that looks out stands against wheels and maps
        cut_interval(self._record, front_m, EYE_WITHIN_M, EYE_WITHIN_M)
        self._places.eye(front_m, EYE_WITHIN_M)
        moved_m = round(float(row.position_m) - before_m, 3) if known else 0.0
        self.notes.append(notes.FixTaken(reader=EYE, correction_m=moved_m, after=OUTCOMES[NOTHING]))
        happened = [] if known else self._found(EYE, command, by_eye=True)
        return [*happened, *self._passed(EYE)] if row.position_known else happened

    def _passed(self, reader: str) -> list[Sensed]:
        """The virtual tags that fixes prove to be behind the front; `reader` gave the last of them."""
        passed: list[Sensed] = []
        for index, tag in self._places.tags_proved():
            self.notes.append(notes.PlacePassed(tag_id=tag.tag_id, purpose=tag.purpose, reader=reader))
            passed.append(TagBelieved(index, found=False))
        return passed

    def _found(self, reader: str, command: DrivingCommand, *, by_eye: bool) -> list[Sensed]:
        """A position was told to a unit that had none: believed, or forgotten again."""
        if not (self._may_be_here(command, by_eye=by_eye) and (by_eye or self._leaves_room(command))):
            self._row.position_known = 0
            if not self._doubted:
                self.notes.append(notes.FoundElsewhere(reader=reader))
            self._doubted = True
            return []
        self._doubted, self._tight, self.untold = False, False, True
        return [FoundByOtherSensor()]

    def _leaves_room(self, command: DrivingCommand) -> bool:
        """Whether it is of more use than the one given up: as narrow as the driver's eye, or surely short of the mark.

        Otherwise the train would stand where it is, or be asked again whether it is at its mark.
        """
        row, mission = self._row, self._mission
        if not self._tight or mission is None or self.narrow:
            return True
        following, joint = command.at + 1, command.limit.joint
        mark_m = mission.targets[following].mark_m if following < len(mission.targets) else -math.inf
        limit_m = mission.spans[joint].start_m if joint < len(mission.spans) else mission.spans[-1].end_m
        front_m = float(row.position_m + row.bound_ahead_m)
        return front_m + ROOM_M < min(mark_m, limit_m)

    def _may_be_here(self, command: DrivingCommand, *, by_eye: bool) -> bool:
        """Whether the train may be on its own path where it was found: by the register, or where there is no other."""
        row, mission = self._row, self._mission
        if mission is None or self._elsewhere:
            return False
        low_m = row.position_m - row.bound_behind_m - self._length_m
        high_m = row.position_m + row.bound_ahead_m
        under = [span for span in mission.spans if span.start_m <= high_m and span.end_m > low_m]
        if not under:
            return False
        if command.on_line:
            return all(span.section_id in command.held for span in under)
        return by_eye or all(span.kind is SectionKind.BETWEEN for span in under)
