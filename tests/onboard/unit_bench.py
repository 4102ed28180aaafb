"""The bench of the unit's tests: a unit with its driving part, and the other ends of its channels."""

from collections.abc import Sequence
from typing import Final

from network.model import Line, Position
from onboard.driving.stop_keeper import StopKeeper
from onboard.duty.records import Begin, DutyPhase, Person, Sensed, Told
from onboard.mission import Mission
from onboard.motion import UnitMotion
from onboard.plan import plan_of
from onboard.records import EVENT_STOPPED, BehaviourRow, PathData, UnitRow
from onboard.unit import OnboardUnit, Report
from onboard.unit_records import UnitParameters
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import AnyMessage, Capability, PointsCommand, PointsProof
from tests.rows import Rows
from vehicle.records import TrainRow

MASTER: Final = b"m" * 32
UNIT, MANAGER, TERMINALS = "K1", "BM", ("A-E", "B-W")
DEPARTURE_S: Final = 36_000.0
LEAD_S, REAR_M = 45.0, 40.0
MARK_A_M, MARK_B_M = 80.0, 660.0
TOKEN: Final = 20
SECTIONS: Final = ("5", "6", "7", "8")


class Bench:
    """A unit and its driving part at the mark of section 3, and the other ends of its channels."""

    def __init__(
        self,
        line: Line,
        mission: Mission,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        keeper: StopKeeper,
        path: Rows,
    ) -> None:
        self.now_s = DEPARTURE_S - 300.0
        self.row, self.mission, self.path = row, mission, PathData(path, 0)
        self.plan = plan_of(mission, float(train.length_m))
        self.motion = UnitMotion(line, UnitParameters(), row, train, behaviour, keeper)
        self.unit = self.boot(1)
        self.devices = {d: Endpoint(key_ring(MASTER, d, (UNIT,)), epoch=1) for d in (MANAGER, *TERMINALS)}
        self.correlation: dict[str, int] = {}
        self.said: list[AnyMessage] = []
        self.notes: list[str] = []
        self.told: tuple[Told, ...] = ()
        self.wake_at_s: float | None = None

    def boot(self, epoch: int) -> OnboardUnit:
        ring = key_ring(MASTER, UNIT, (MANAGER, *TERMINALS))
        return OnboardUnit(UNIT, MANAGER, UnitParameters().duty, Endpoint(ring, epoch))

    def tell(self, happened: Sequence[Person | Sensed] = (), telegrams: Sequence[bytes] = ()) -> None:
        """As the world does it: the place as it is, the unit's answer obeyed."""
        answer = self.unit.advance(self.now_s, telegrams, Report(self.motion.place(), tuple(happened)))
        self.motion.obey(answer.command, self.now_s)
        noted = [*self.motion.taken_notes(), *answer.notes]
        self.notes = [str(type(note).__struct_config__.tag) for note in noted]
        self.told, self.wake_at_s = answer.told, answer.wake_at_s
        self.said = []
        for telegram in answer.telegrams:
            opened = self.devices[telegram.destination].open(telegram.data, self.now_s)
            assert isinstance(opened, Received)
            self.correlation[telegram.destination] = opened.correlation
            self.said.append(opened.message)

    @property
    def commanded(self) -> list[PointsCommand]:
        return [message for message in self.said if isinstance(message, PointsCommand)]

    @property
    def phase(self) -> DutyPhase:
        return self.unit.state.phase

    @property
    def held(self) -> tuple[str, ...]:
        return self.motion.command.held

    @property
    def waits_for(self) -> str:
        return self.motion.command.waits_for

    def begin(self) -> None:
        self.motion.stand_at_start(self.mission, self.path, float(self.row.odometer_m))
        self.row.speed_mps = 0.0
        self.tell([Begin(self.plan, signs_on=True)])

    def hear(self, device: str, message: AnyMessage, later_s: float = 0.2) -> None:
        """A device answers the last telegram it heard."""
        self.now_s += later_s
        data = self.devices[device].seal(UNIT, message, self.now_s, self.correlation.get(device, 0))
        self.tell(telegrams=[data])

    def at(self, now_s: float) -> None:
        """Time passes."""
        self.now_s = now_s
        self.tell()

    def read(self, tag_id: int) -> None:
        """It reads a tag where that lies."""
        tag = next(tag for tag in self.mission.tags if tag.tag_id == tag_id)
        self.row.odometer_m = self.row.odometer_m + tag.position_m - self.row.position_m
        self.row.position_m = tag.position_m
        self.now_s += 10.0
        self.tell(self.motion.tag_read(tag_id, float(self.row.odometer_m)))

    def ticked(self, bits: int, later_s: float = 1.0) -> None:
        """The compiled tick reports."""
        self.now_s += later_s
        self.tell(self.motion.events(bits))

    def stop(self, position_m: float) -> None:
        self.row.position_m, self.row.speed_mps = position_m, 0.0
        self.ticked(EVENT_STOPPED)


def capabilities() -> tuple[Capability, ...]:
    return Capability("A-E", "5", b"five"), Capability("B-W", "7", b"seven")


def proof(points_id: str, position: Position | None = Position.NORMAL) -> PointsProof:
    return PointsProof(points_id, position, position is not None, position is not None, TOKEN)
