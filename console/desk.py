"""The desk without its clock, thread and sockets: a session, how fast it runs, and what each seat asks of it.

Invariant: what is asked and may not be is refused with a reason, and nothing has changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from console.pacing import Pacer
from console.protocol import (
    ArmScript,
    AskProtocol,
    ChangeFault,
    DeskAnswer,
    DoAct,
    EndFault,
    Fail,
    GoBack,
    NextEvent,
    OneStep,
    Request,
    RunTo,
    SaveDrill,
    SayToSeat,
    SeatMessage,
    SetPace,
    Welcome,
)
from console.score import RefusedAct, score_json, score_of
from console.seats import OF_OWN_UNIT, RIGHTS, Seat, may_be
from console.session import AT_DESK, Session
from console.shown import DeskMoment, moment_of, welcome_of
from network.errors import InputError
from network.files.names import IDENTIFIER_HELP, is_identifier
from network.files.toml_input import one_of
from simulation.faults.script import BY_ROLE, ActKind
from simulation.setup import STEPS_PER_S, step_not_before

STEPS_AT_ONCE: Final = 600  # gone on without looking who asks for something


class DeskTurn(NamedTuple):
    """Whether the run has gone on, and how long until more is due, s; None: nothing is by itself."""

    moved: bool
    wait_s: float | None


class Desk:
    """One run and those who work it. `branch` counts the times that it went back."""

    def __init__(self, session: Session) -> None:
        self._session: Final = session
        self._pacer = Pacer(step=session.step)
        self._branch = 0
        self._messages: list[SeatMessage] = []
        self._refused: list[RefusedAct] = []
        self.cabs: frozenset[str] = frozenset()  # units whose drivers look on

    def welcome(self, seat: Seat) -> Welcome:
        """What a seat is told once."""
        return welcome_of(self._session, seat)

    @property
    def moment(self) -> DeskMoment:
        """The present."""
        running = self._pacer.factor > 0.0 or self._pacer.goal is not None
        return moment_of(
            self._session,
            self._session.line,
            self._pacer.factor,
            self._branch,
            running=running,
            messages=tuple(self._messages),
            units=self.cabs,
        )

    # time -------------------------------------------------------------------------------------------------------------

    def turn(self, now_s: float) -> DeskTurn:
        """Go on as far as the run should be by now, or a part of that."""
        session, before = self._session, self._session.step
        due = self._pacer.due(now_s)
        if session.ended is None and due > before:
            session.run_to(min(due, before + STEPS_AT_ONCE))
        if session.ended is not None:
            self._stand(now_s)
        else:
            self._pacer = self._pacer.at(session.step, now_s)
        return DeskTurn(session.step != before, self._pacer.wait_s(session.step, now_s))

    # what is asked ----------------------------------------------------------------------------------------------------

    def ask(self, seat: Seat, request: Request, now_s: float, unit: str = "") -> DeskAnswer:
        """Do what a seat asks for, a driver's that of this unit, or say why not."""
        try:
            return self._done(seat, request, now_s, unit)
        except InputError as error:
            if isinstance(request, DoAct):
                self._refused.append(RefusedAct(self._session.now_s, seat.value, str(error)))
            return DeskAnswer(number=request.number, good=False, why=str(error))

    def _done(self, seat: Seat, request: Request, now_s: float, unit: str) -> DeskAnswer:
        text, deed = "", None
        match request:
            case DoAct(act=table):
                deed = self._session.act(_act_of(seat, table, unit))
            # Both tell what has failed, which a seat may not know while it works.
            case SaveDrill() | AskProtocol() if not RIGHTS[seat].leads and self._session.ended is None:
                raise InputError(AT_DESK, "seat", seat.value, f"{Seat.INSTRUCTOR.value}, or the run's end")
            case SaveDrill(id=own_id, title=title):
                if not is_identifier(own_id):
                    raise InputError(AT_DESK, "id", own_id, IDENTIFIER_HELP)
                if not self._session.has_script:
                    raise InputError(AT_DESK, "", None, "something that was done: nothing makes no drill")
                text = self._session.drill_text(own_id, title or own_id)
            case AskProtocol():
                text = score_json(score_of(self._session, tuple(self._refused), tuple(self._messages)))
            case _ if not RIGHTS[seat].leads:
                raise InputError(AT_DESK, "seat", seat.value, f"{Seat.INSTRUCTOR.value}, who leads the run")
            case Fail() | EndFault() | ChangeFault() | ArmScript():
                deed = self._break(request)
            case SayToSeat(text=said, seat=to):
                to_seat = "" if to is None else to.value
                self._messages.append(SeatMessage(time_s=self._session.now_s, text=said, seat=to_seat))
            case GoBack(time_s=time_s):
                self._session.go_back(step_not_before(time_s))
                self._branch += 1
                back_s = self._session.now_s
                self._messages = [said for said in self._messages if said.time_s <= back_s]
                self._refused = [act for act in self._refused if act.time_s <= back_s]
                self._stand(now_s)
            case _:
                self._move(request, now_s)
        return DeskAnswer(number=request.number, good=True, text=text, deed=deed)

    def _break(self, request: Fail | EndFault | ChangeFault | ArmScript) -> int | None:
        session = self._session
        match request:
            case Fail(fault=table):
                return session.fail(table)
            case EndFault(deed=deed):
                session.end_fault(deed)
                return deed
            case ChangeFault(deed=deed, keys=keys):
                return session.change_fault(deed, keys)
            case ArmScript(faults=faults, acts=acts):
                return next(iter(session.arm(faults, acts)), None)

    def _move(self, request: SetPace | OneStep | NextEvent | RunTo, now_s: float) -> None:
        session = self._session
        match request:
            case SetPace(factor=factor):
                self._pacer = Pacer(factor, session.step, now_s)
            case OneStep():
                session.run_to(session.step + 1)
                self._stand(now_s)
            case NextEvent():
                session.next_event()
                self._stand(now_s)
            case RunTo(time_s=time_s):
                if time_s * STEPS_PER_S < session.step:
                    raise InputError(AT_DESK, "time_s", time_s, "a time to come")
                self._pacer = Pacer(0.0, session.step, now_s, step_not_before(time_s))

    def _stand(self, now_s: float) -> None:
        self._pacer = Pacer(0.0, self._session.step, now_s)


def _act_of(seat: Seat, table: Mapping[str, Any], unit: str) -> dict[str, Any]:
    """An act as that of whoever has the seat. InputError for one that is another's."""
    rights, target = RIGHTS[seat], table.get("target")
    kind = next((act for act in ActKind if act.value == table.get("kind")), None)
    if kind is not None and kind not in rights.acts:
        own = one_of(sorted(act.value for act in rights.acts))
        raise InputError(AT_DESK, "act.kind", kind.value, f"what the seat {seat.value} may do: {own}")
    if seat is Seat.DRIVER and kind in OF_OWN_UNIT and target != unit:
        raise InputError(AT_DESK, "act.target", target, f"{unit}, whose cab this is")
    if kind in BY_ROLE and not may_be(seat, str(target), unit):
        roles = one_of(post.value for post in rights.posts)
        raise InputError(
            AT_DESK, "act.target", target, f"a role that the seat {seat.value} may have: {roles}"
        )
    person = table.get("person", rights.person)
    if person != rights.person and not rights.leads:
        raise InputError(AT_DESK, "act.person", person, f"{rights.person}, whose seat this is")
    return dict(table) | {"person": person}
