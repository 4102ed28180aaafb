"""What is written down about each train as the run goes: its stops by the truth, its energy, where its trace begins.

Where a train has called is judged by where it truly stands, never by what its unit believes or its driver says.
"""

from __future__ import annotations

from typing import Final

from network.model import SectionKind
from network.timetable import TimetableTrain
from onboard.mission import Target
from simulation.result import EnergyRecord, StopRecord, TraceSpan
from simulation.setup import STEPS_PER_S
from simulation.subscribers import Subscribers
from simulation.tolerance import CALLS_BEYOND_M, CALLS_SHORT_M
from simulation.world.energy_book import EnergyBook
from simulation.world.roster import Duty
from simulation.world.trains import Trains


class Books:
    """The records of one run."""

    def __init__(self, trains: Trains) -> None:
        self.stands: Final = Subscribers[int, int, float]()  # a train (slot) stands at a target, since when
        self.stops: list[StopRecord] = []
        self.spans: list[TraceSpan] = []
        self.arrived: list[str] = []  # numbers of trains at their last call
        self._trains = trains
        self._energy = EnergyBook(trains)
        self._open_stop: dict[int, StopRecord | None] = {}
        self._at: dict[int, int] = {}  # slot: the target where the train truly called last
        self._called: dict[int, StopRecord] = {}  # its record
        self._moved: set[int] = set()  # slots that have moved since

    @property
    def energy(self) -> list[EnergyRecord]:
        """What each stock took and gave, by phase."""
        return self._energy.records

    def begin_train(self, slot: int, duty: Duty, step: int) -> None:
        """A stock has taken up a train: its trace begins, and its stop at the first station."""
        self.follow(slot, duty, step)
        self._energy.begin(slot, duty, step)
        self._at[slot] = 0
        self._called.pop(slot, None)
        first = duty.mission.targets[0]
        if first.station_id is not None:
            self._open_stop[slot] = self._record(slot, duty, 0)
            self.stands(slot, 0, step / STEPS_PER_S)

    def follow(self, slot: int, duty: Duty, step: int) -> None:
        """A train goes by this way from now on."""
        path = duty.mission.path
        starts_m = tuple(step.start_m for step in path.steps)
        entries_m = tuple(step.entry_m for step in path.steps)
        direction = int(duty.mission.direction)
        load_share = float(self._trains.plants[slot].load_share)
        span = TraceSpan(
            slot, step, duty.train.number, direction, starts_m, path.piece_ids, entries_m, load_share
        )
        self.spans.append(span)

    def cancel(
        self, slot: int, train: TimetableTrain, calls: range, stated_late_s: float, *, begins: bool = False
    ) -> None:
        """These calls of a train do not come; it ends at the first of them, or `begins` at the last."""
        for index in calls:
            call = train.calls[index]
            comes = index == 0 or (index == calls[0] and not begins)
            leaves = begins and index == calls[-1]
            arrival_s = None if comes or not call.stops else call.arrival_s
            self.stops.append(
                StopRecord(
                    self._trains.stock_ids[slot],
                    train.number,
                    train.revenue,
                    call.station_id,
                    call.track or "",
                    arrival_s,
                    None if leaves else call.departure_s,
                    kind=call.kind,
                    stated_late_s=stated_late_s,
                )
            )

    def ends_here(self, slot: int) -> None:
        """A train that stands at a stop leaves it no more."""
        stop = self._open_stop.get(slot)
        if stop is not None:
            stop.planned_departure_s = None
        self._open_stop[slot] = None

    def next_target(self, slot: int) -> int:
        """Index of the first target at which the train has not called yet; one too many where it has at all."""
        return self._at.get(slot, 0) + 1

    def stands_at(self, slot: int) -> int | None:
        """The target at which the train truly stands, its front in that section; None where it does not."""
        duty = self._trains.duties[slot]
        if duty is None or self._trains.plants[slot].speed_mps > 0.0:
            return None
        at = self._at.get(slot, 0)
        here = duty.mission.span_at(float(self._trains.truths[slot].position_m)).section_id
        if here != duty.mission.targets[at].section_id:
            return None
        return at if self._near(slot, duty, at) and self._on_its_way(slot, duty) else None

    def look_for_departure(self, slot: int, now_s: float) -> None:
        """A train that moves has left the stop that was open."""
        if self._trains.plants[slot].speed_mps <= 0.0:
            return
        self._moved.add(slot)
        self._energy.moves(slot, round(now_s * STEPS_PER_S))
        stop, duty = self._open_stop.get(slot), self._trains.duties[slot]
        if stop is not None and duty is not None:
            stop.departure_s = now_s
            self._open_stop[slot] = None
            self._come_to(duty, self._at.get(slot, 0))  # a train may call but once, where it begins

    def look_for_arrival(self, slot: int, now_s: float) -> None:
        """A train that has come to a stand at a target at which it had not called has arrived there."""
        duty = self._trains.duties[slot]
        if duty is None or self._trains.plants[slot].speed_mps > 0.0:
            return
        self._look_where_it_stands(slot, duty, now_s)
        self._energy.stands(slot, round(now_s * STEPS_PER_S), self._at.get(slot, 0))

    def _look_where_it_stands(self, slot: int, duty: Duty, now_s: float) -> None:
        targets = duty.mission.targets
        at = self._at.get(slot, 0)
        if slot in self._moved and slot in self._called and self._drew_up(slot, duty, at):
            self._arrive(slot, self._called[slot], targets[at], now_s)
            return
        index = next(
            (i for i in range(self.next_target(slot), len(targets)) if self._calls(slot, duty, i)), None
        )
        if index is None:
            return
        self._at[slot] = index
        self._trains.begin_leg(slot, now_s)
        target = targets[index]
        if target.station_id is None:
            return
        self._called[slot] = self._record(slot, duty, index)
        self._arrive(slot, self._called[slot], target, now_s)
        self._come_to(duty, index)

    def _come_to(self, duty: Duty, index: int) -> None:
        """A train is, or has been, at a target; at the last one with a station it has arrived."""
        calls = [i for i, target in enumerate(duty.mission.targets) if target.station_id is not None]
        if index == calls[-1] and duty.train.number not in self.arrived:
            self.arrived.append(duty.train.number)

    def _arrive(self, slot: int, record: StopRecord, target: Target, now_s: float) -> None:
        self._moved.discard(slot)
        record.arrival_s, record.departure_s = now_s, None
        record.error_m = float(self._trains.truths[slot].position_m) - target.mark_m
        self._open_stop[slot] = record if target.departure_s is not None else None
        self.stands(slot, self._at[slot], now_s)

    def _drew_up(self, slot: int, duty: Duty, at: int) -> bool:
        """Whether a train that called well short of its mark has come nearer to it."""
        before_m = self._called[slot].error_m
        if before_m is None or before_m >= -CALLS_SHORT_M:
            return False
        now_m = float(self._trains.truths[slot].position_m) - duty.mission.targets[at].mark_m
        return abs(now_m) < abs(before_m) and self._calls(slot, duty, at)

    def _alongside(self, slot: int, duty: Duty, target: Target) -> bool:
        """Whether the whole train stands along the platform of a target, or on its track where that has none."""
        if target.station_id is None:
            return False
        tracks = self._trains.setup.line.stations[target.station_id].tracks
        track = next(track for track in tracks if track.name == target.track)
        piece = self._trains.setup.line.pieces[track.piece_id]
        ends_m = [
            duty.mission.path.to_path_m(track.piece_id, kilometrage_m)
            for kilometrage_m in track.platform_m or (piece.from_m, piece.to_m)
        ]
        front_m = float(self._trains.truths[slot].position_m)
        return min(ends_m) <= front_m - float(self._trains.bodies[slot].length_m) and front_m <= max(ends_m)

    def _calls(self, slot: int, duty: Duty, index: int) -> bool:
        """Whether the front truly is where a train calls at a target, on the way of its own path."""
        there = self._near(slot, duty, index) or self._alongside(slot, duty, duty.mission.targets[index])
        return there and self._on_its_way(slot, duty)

    def _near(self, slot: int, duty: Duty, index: int) -> bool:
        """Whether the front is at the mark of a target, or beyond it on its track."""
        mission, truth = duty.mission, self._trains.truths[slot]
        target = mission.targets[index]
        span = mission.spans[mission.span_index(target.section_id)]
        furthest_m = target.mark_m + CALLS_BEYOND_M
        if span.kind is not SectionKind.BETWEEN:  # a halt's section reaches to the next station
            furthest_m = max(furthest_m, span.end_m)
        front_m = float(truth.position_m)
        return target.mark_m - CALLS_SHORT_M <= front_m <= furthest_m

    def _on_its_way(self, slot: int, duty: Duty) -> bool:
        """Whether no points have sent the train elsewhere."""
        planned = duty.mission.path.piece_ids
        return self._trains.true_path(slot).piece_ids[: len(planned)] == planned

    def _record(self, slot: int, duty: Duty, index: int) -> StopRecord:
        """The stop at a target, as planned; a train begins at its first without arriving."""
        target = duty.mission.targets[index]
        record = StopRecord(
            self._trains.stock_ids[slot],
            duty.train.number,
            duty.train.revenue,
            target.place_id,
            target.track,
            target.arrival_s if index > 0 else None,
            target.departure_s,
            kind=target.kind,
        )
        self.stops.append(record)
        return record

    def close_energy(self, slot: int, step: int) -> None:
        """Book what the present train used, to its end."""
        self._energy.close(slot, step)

    def stable(self, slot: int, step: int) -> None:
        """The stock's last train is over, and it stays on the line."""
        duty = self._trains.duties[slot]
        if duty is not None:
            self._energy.stable(slot, duty, step)

    def close(self, step: int) -> None:
        """The run is over: trains still on their way used energy too."""
        for slot in self._trains.active():
            self._energy.close(slot, step)
