"""A finished run at the desk: the same pages, from what its directory has; time goes both ways, and nobody acts.

Invariant: what is shown at a time follows from the journal up to it and from the trajectories, however one came there.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Final

import msgspec
import numpy as np

from console import protocol
from console.desk import DeskTurn
from console.line_seen import LineSeen
from console.pacing import Pacer
from console.seats import Seat
from console.shown import DeskMoment, drawn_line
from network.errors import InputError
from simulation.events import Entered, Left
from simulation.journal import read_journal
from simulation.judge.checkers import Checker
from simulation.setup import STEPS_PER_S
from study.record.directory import JOURNAL_FILE
from study.record.read_back import RunRead
from study.record.setup_back import setup_of

SHOWN_FOR_S: Final = 2.0  # a train whose last sample is older stands there
LOOKED_AT = "a run that has ended: it is looked at, and nothing is done"


class _Trajectory:
    """Where one unit was, by its samples: there are none of where it stands."""

    def __init__(self, read: RunRead, unit: str) -> None:
        frame = read.tables.trajectory.filter(read.tables.trajectory["unit"] == unit).sort("t_s")
        self._times = frame["t_s"].to_numpy()
        self._rows = frame.select("kilometrage_m", "speed_mps", "piece", "train").rows()

    def at(self, time_s: float) -> tuple[float, float, str, str] | None:
        """Kilometrage, m, speed, m/s, piece and train, as last sampled, or as it stood first; None: it never ran."""
        if not self._rows:
            return None
        k = int(np.searchsorted(self._times, time_s, side="right")) - 1
        at_m, speed_mps, piece, train = self._rows[max(k, 0)]
        runs = k >= 0 and time_s - self._times[k] <= SHOWN_FOR_S
        return at_m, speed_mps if runs else 0.0, piece, train


class Replay:
    """One run that is looked at; a `Desk` to whoever asks."""

    def __init__(self, read: RunRead) -> None:
        self._read, self._setup = read, setup_of(read)
        self._entries = read_journal(read.directory / JOURNAL_FILE)
        self._times = [entry.t_s for entry in self._entries]
        self.cabs: frozenset[str] = frozenset()
        self._branch = 0
        self._fed = 0
        self._line = LineSeen(self._setup)
        self._there: set[str] = set()  # units that are truly on the line
        first_s, last_s = (self._times[0], self._times[-1]) if self._times else (0.0, 0.0)
        self._first, self._last = int(first_s * STEPS_PER_S), int(last_s * STEPS_PER_S) + 1
        self._step = self._first
        self._pacer = Pacer(step=self._step)
        units = (diagram.stock_id for diagram in read.timetable.diagrams)
        self._ways = {unit: _Trajectory(read, unit) for unit in units}
        self._feed()

    def welcome(self, seat: Seat) -> protocol.Welcome:
        """What a seat is told once: the line, and from when to when there is something to see."""
        units = tuple(self._ways)
        drawn = drawn_line(self._setup, seat, self._read.directory.name, self._read.name, units)
        begin_s, end_s = self._first / STEPS_PER_S, self._last / STEPS_PER_S
        return msgspec.structs.replace(drawn, leads=True, replay=True, begin_s=begin_s, end_s=end_s)

    @property
    def moment(self) -> DeskMoment:
        """What there was at the time that is looked at."""
        line, now_s = self._line, self._step / STEPS_PER_S
        ended = str(self._read.summary["ended_because"]) if self._step >= self._last else ""
        known = protocol.State(
            time_s=now_s,
            factor=self._pacer.factor,
            running=self._pacer.factor > 0.0,
            ended=ended,
            digest=str(self._read.summary["digest"]),
            branch=self._branch,
            defined=line.defined,
            manager_on=line.manager_on,
            sections=line.sections,
            trains=tuple(self._true(train, now_s) for train in line.trains(now_s)),
            crossings=line.crossings.truth(),
            bids=line.bids(now_s),
            rules=self._rules(now_s),
        )
        return DeskMoment(
            known, known, (line.events, len(line.events)), (line.graph, len(line.graph)), sees_all=True
        )

    def turn(self, now_s: float) -> DeskTurn:
        """Go on as far as should be seen by now."""
        before = self._step
        due = min(self._pacer.due(now_s), self._last)
        if due > before:
            self._to(due)
        self._pacer = (
            Pacer(0.0, self._step, now_s) if self._step >= self._last else self._pacer.at(self._step, now_s)
        )
        return DeskTurn(self._step != before, self._pacer.wait_s(self._step, now_s))

    def ask(
        self, _seat: Seat, request: protocol.Request, now_s: float, _unit: str = ""
    ) -> protocol.DeskAnswer:
        """Look at another time, or faster; all else is refused."""
        number = request.number
        match request:
            case protocol.SetPace(factor=factor):
                self._pacer = Pacer(factor, self._step, now_s)
                return protocol.DeskAnswer(number=number, good=True)
            case protocol.OneStep():
                to = self._step + 1
            case protocol.NextEvent():
                following = bisect_right(self._times, self._step / STEPS_PER_S)
                to = (
                    self._last
                    if following == len(self._times)
                    else int(self._times[following] * STEPS_PER_S) + 1
                )
            case protocol.RunTo(time_s=time_s) | protocol.GoBack(time_s=time_s):
                to = round(time_s * STEPS_PER_S)
            case protocol.AskProtocol():
                return protocol.DeskAnswer(
                    number=number, good=True, text=msgspec.json.encode(dict(self._read.summary)).decode()
                )
            case _:
                return protocol.DeskAnswer(
                    number=number, good=False, why=str(InputError("desk", "", None, LOOKED_AT))
                )
        self._to(max(self._first, min(to, self._last)))
        self._pacer = Pacer(0.0, self._step, now_s)
        return protocol.DeskAnswer(number=number, good=True, text=str(self._step / STEPS_PER_S))

    def _to(self, step: int) -> None:
        if step < self._step:
            self._line, self._fed = LineSeen(self._setup), 0
            self._there.clear()
            self._branch += 1
        self._step = step
        self._feed()

    def _feed(self) -> None:
        upto = bisect_right(self._times, self._step / STEPS_PER_S)
        for entry in self._entries[self._fed : upto]:
            self._line.see(entry)
            match entry.event:
                case Entered(unit_id=unit):
                    self._there.add(unit)
                case Left(unit_id=unit):
                    self._there.discard(unit)
                case _:
                    pass
        self._fed = max(self._fed, upto)

    def _true(self, train: protocol.TrainShown, now_s: float) -> protocol.TrainShown:
        at = self._ways[train.unit].at(now_s) if train.unit in self._there else None
        if at is None:
            return train
        at_m, speed_mps, piece, number = at
        section = self._read.line.pieces[piece].section_id
        number = number if speed_mps else train.train or number  # a unit that is off tells of no train
        return msgspec.structs.replace(train, train=number, at_m=at_m, speed_mps=speed_mps, section=section)

    def _rules(self, now_s: float) -> tuple[protocol.RuleShown, ...]:
        texts: dict[str, list[str]] = {}
        for broken in self._read.shown.violations:
            if broken.t_s <= now_s:
                texts.setdefault(broken.checker, []).append(broken.text)
        if self._step >= self._last:  # judged at the end alone, and told by the summary
            arrives = Checker.EVERYONE_ARRIVES.value
            told = (str(text).partition(f" {arrives}: ") for text in self._read.summary.get("violations", ()))
            texts[arrives] = [text for _, found, text in told if found]
        return tuple(
            protocol.RuleShown(rule=rule.value, broken=len(own), first=next(iter(own), ""))
            for rule in Checker
            for own in (texts.get(rule.value, []),)
        )
