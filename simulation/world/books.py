"""What is written down about each train as the run goes: its stops by the truth, its energy, where its trace begins."""

from __future__ import annotations

from onboard.unit import Phase
from simulation.result import EnergyRecord, StopRecord, TraceSpan, Waiting
from simulation.world.roster import Duty
from simulation.world.trains import EnergyMark, Trains


class Books:
    """The records of one run."""

    def __init__(self, trains: Trains) -> None:
        self.stops: list[StopRecord] = []
        self.energy: list[EnergyRecord] = []
        self.spans: list[TraceSpan] = []
        self.arrived: list[str] = []  # numbers of trains at their last call
        self._trains = trains
        self._open_stop: dict[int, StopRecord | None] = {}
        self._reached: set[tuple[str, int]] = set()  # train number and target

    def begin_train(self, slot: int, duty: Duty, step: int) -> None:
        """A stock has taken up a train: its trace begins, and its stop at the first station."""
        path = duty.mission.path
        starts_m = tuple(step.start_m for step in path.steps)
        entries_m = tuple(step.entry_m for step in path.steps)
        direction = int(duty.mission.direction)
        span = TraceSpan(slot, step, duty.train.number, direction, starts_m, path.piece_ids, entries_m)
        self.spans.append(span)
        first = duty.mission.targets[0]
        if first.station_id is not None:
            self._open_stop[slot] = self._record(slot, duty, 0)

    def look_for_departure(self, slot: int, now_s: float) -> None:
        """A train that moves has left the stop that was open."""
        stop = self._open_stop.get(slot)
        if stop is not None and self._trains.plants[slot].speed_mps > 0.0:
            stop.departure_s = now_s
            self._open_stop[slot] = None

    def look_for_arrival(self, slot: int, now_s: float) -> None:
        """A unit that stands at a target it had not reached before has arrived there, however it came to know."""
        unit, duty = self._trains.on_board[slot], self._trains.duties[slot]
        if duty is None or unit.at == 0 or self._trains.plants[slot].speed_mps > 0.0:
            return
        stands = unit.phase in (Phase.STANDING, Phase.FINISHED) or unit.stands_at == unit.at
        if not stands or (duty.train.number, unit.at) in self._reached:
            return
        self._reached.add((duty.train.number, unit.at))
        self._trains.begin_leg(slot, now_s)
        target = duty.mission.targets[unit.at]
        if target.station_id is None:
            return
        record = self._record(slot, duty, unit.at)
        record.arrival_s = now_s
        record.error_m = float(self._trains.truths[slot].position_m) - target.mark_m
        self._open_stop[slot] = record if target.departure_s is not None else None
        if target is [t for t in duty.mission.targets if t.station_id is not None][-1]:
            self.arrived.append(duty.train.number)

    def _record(self, slot: int, duty: Duty, index: int) -> StopRecord:
        """The stop at a target, as planned; a train begins at its first without arriving."""
        target = duty.mission.targets[index]
        record = StopRecord(
            self._trains.stock_ids[slot],
            duty.train.number,
            duty.train.revenue,
            target.station_id or target.section_id,
            target.track,
            target.arrival_s if index > 0 else None,
            target.departure_s,
        )
        self.stops.append(record)
        return record

    def close_energy(self, slot: int) -> None:
        """Book what the present train used."""
        duty, mark = self._trains.duties[slot], self._trains.energy_marks[slot]
        if duty is None:
            return
        plant = self._trains.plants[slot]
        now = EnergyMark(
            float(plant.energy_traction_j),
            float(plant.energy_regenerated_j),
            float(plant.energy_auxiliary_j),
            float(plant.travelled_m),
        )
        self.energy.append(
            EnergyRecord(
                self._trains.stock_ids[slot],
                duty.train.number,
                duty.train.revenue,
                now.travelled_m - mark.travelled_m,
                now.traction_j - mark.traction_j,
                now.regenerated_j - mark.regenerated_j,
                now.auxiliary_j - mark.auxiliary_j,
            )
        )
        self._trains.energy_marks[slot] = now

    def close(self) -> None:
        """The run is over: trains still on their way used energy too."""
        for slot in self._trains.active():
            if self._trains.on_board[slot].phase is not Phase.FINISHED:
                self.close_energy(slot)

    def waiting(self) -> list[Waiting]:
        """Trains that have not finished, where they stand and what they wait for."""
        trains, line = self._trains, self._trains.setup.line
        waiting: list[Waiting] = []
        for slot, stock_id in enumerate(trains.stock_ids):
            unit, duty = trains.on_board[slot], trains.duties[slot]
            if not trains.truths[slot].active or duty is None or unit.mission is None:
                continue
            if unit.phase in (Phase.FINISHED, Phase.GONE):
                continue
            piece_id, at_m = trains.true_path(slot).locate(float(trains.truths[slot].position_m))
            place = f"section {line.pieces[piece_id].section_id} at km {at_m / 1000.0:.3f}"
            waiting.append(Waiting(stock_id, duty.train.number, place, unit.waits_for()))
        return waiting
