"""Substitute working (代用閉そく方式) as tables: who says what to whom, and what must have been done before.

Pure data, of which the program's players (`simulation.substitute`), the pilot's rule (`judge.pilot`), drills and
docs/substitute-working.md are made. When nothing keeps trains apart any more, people do: one person, the pilot
(指導者), belongs to a section, and a train goes into it with the pilot alone.

Sources: rules for the operation of railways (鉄道運転規則, Ordinance 15 of 1987, Ministry of Transport), articles 130
to 146; the account of the procedure for an unstaffed signal station before the transport committee of the House of
Councillors, 30 May 1991; the JNR rules for train operation (運転取扱基準規程, 1972), chapter 3, on when two stations
agree on the change. What the rules leave to each railway is assumed: who cranks points, that drivers cut units out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, StrEnum
from types import MappingProxyType
from typing import Final

from simulation.people import Pause


class Regime(StrEnum):
    """Which substitute working is in force."""

    TELEPHONE = "pilot_by_telephone"  # 指導通信式: a block operator at each end, who agree by telephone
    SHUTTLE = "pilot_shuttle"  # 指導式: the train comes back to where it started, the pilot always aboard
    DISPATCHER = (
        "pilot_by_dispatcher"  # 指導指令式: the dispatcher is the operator, by occupancy display and radio
    )


class ActingRole(StrEnum):
    """Who acts, or is spoken to."""

    DISPATCHER = "dispatcher"
    OPERATORS = "both operators"
    SENDING = "operator where the train stands"
    RECEIVING = "operator at the other end"
    PILOT = "pilot"
    DRIVER = "driver"


class Post(StrEnum):
    """Who a person at the desk can be: a role at a place, of which the program plays all that nobody has taken."""

    DISPATCHER = "dispatcher"
    OPERATOR = "operator"  # at one end of a section
    PILOT = "pilot"  # of one section
    DRIVER = "driver"  # of one unit


POST_OF: Final[Mapping[ActingRole, Post]] = MappingProxyType(
    {
        ActingRole.DISPATCHER: Post.DISPATCHER,
        ActingRole.OPERATORS: Post.OPERATOR,
        ActingRole.SENDING: Post.OPERATOR,
        ActingRole.RECEIVING: Post.OPERATOR,
        ActingRole.PILOT: Post.PILOT,
        ActingRole.DRIVER: Post.DRIVER,
    }
)


class Part(Enum):
    """When a step is due."""

    BEGIN = "once, to begin"
    TRAIN = "for each train"
    END = "once, to end"


class WorkingStep(StrEnum):
    """The steps; a drill names those that are left out."""

    ORDER = "order"
    MAN = "man"
    CLEAR = "clear"
    PILOT = "pilot"
    ASK = "ask"
    AGREE = "agree"
    POINTS = "points"
    TICKET = "ticket"
    BOARD = "board"
    CUT_OUT = "cut_out"
    GO = "go"
    ARRIVED = "arrived"
    ALIGHT = "alight"
    STOP = "stop"
    EMPTY = "empty"
    RELEASE = "release"


@dataclass(frozen=True, slots=True)
class ProcedureRow:
    """A step: who does it, what is said to whom, which steps it needs; `waits`: for what of the world it waits.

    What is said to the other end by telephone is read back (復唱), which its time includes. `falls_with`: it cannot be
    done by itself where that step was left out.
    """

    step: WorkingStep
    part: Part
    who: ActingRole
    to: ActingRole
    says: str
    needs: tuple[WorkingStep, ...]
    pause: Pause
    waits: str = ""
    falls_with: WorkingStep | None = None


_ORDER: Final = ProcedureRow(
    WorkingStep.ORDER, Part.BEGIN, ActingRole.DISPATCHER, ActingRole.OPERATORS,
    "the block manager is out of order: substitute working in {block}", (), Pause.NOTICE,
    "the block manager is off",
)  # fmt: skip
_MAN: Final = ProcedureRow(
    WorkingStep.MAN, Part.BEGIN, ActingRole.OPERATORS, ActingRole.DISPATCHER,
    "I am at my post for {block}", (WorkingStep.ORDER,), Pause.REACH,
    "staff are on their way to stations without any",
)  # fmt: skip
_CLEAR: Final = ProcedureRow(
    WorkingStep.CLEAR, Part.BEGIN, ActingRole.OPERATORS, ActingRole.OPERATORS,
    "{block} is clear, and no train may still run into it", (WorkingStep.MAN,), Pause.TELEPHONE,
    "no train is in the section, none has authority to run into it",
)  # fmt: skip
_PILOT: Final = ProcedureRow(
    WorkingStep.PILOT, Part.BEGIN, ActingRole.OPERATORS, ActingRole.PILOT,
    "you are the pilot of {block}, you alone", (WorkingStep.CLEAR,), Pause.TELEPHONE,
)  # fmt: skip
_ASK: Final = ProcedureRow(
    WorkingStep.ASK, Part.TRAIN, ActingRole.SENDING, ActingRole.RECEIVING,
    "may train {train} come through {block}?", (WorkingStep.PILOT,), Pause.TELEPHONE,
    "the train is next by the plan, stands at its track, and the last one has been reported arrived",
)  # fmt: skip
_AGREE: Final = ProcedureRow(
    WorkingStep.AGREE, Part.TRAIN, ActingRole.RECEIVING, ActingRole.SENDING,
    "train {train} may come through {block}; I let none in", (WorkingStep.ASK,), Pause.TELEPHONE,
    "its arrival track and points are free, of authority too, and by the plan no train comes there before",
    WorkingStep.ASK,
)  # fmt: skip
_POINTS: Final = ProcedureRow(
    WorkingStep.POINTS, Part.TRAIN, ActingRole.OPERATORS, ActingRole.OPERATORS,
    "points lie and are locked by hand for train {train}", (WorkingStep.AGREE,), Pause.CRANK,
    "no train is on the points",
)  # fmt: skip
_TICKET: Final = ProcedureRow(
    WorkingStep.TICKET, Part.TRAIN, ActingRole.PILOT, ActingRole.DRIVER,
    "your ticket through {block}, for train {train} alone: I come with a later one", (WorkingStep.POINTS,), Pause.BOARD,
    "the pilot is where the train stands, and the next train by the plan leaves from there too", WorkingStep.PILOT,
)  # fmt: skip
_BOARD: Final = ProcedureRow(
    WorkingStep.BOARD, Part.TRAIN, ActingRole.PILOT, ActingRole.DRIVER,
    "I ride with train {train} through {block}", (WorkingStep.POINTS,), Pause.BOARD,
    "the pilot is where the train stands, by road where no train has brought him", WorkingStep.PILOT,
)  # fmt: skip
_CUT_OUT: Final = ProcedureRow(
    WorkingStep.CUT_OUT, Part.TRAIN, ActingRole.DRIVER, ActingRole.PILOT,
    "the unit of train {train} is cut out", (WorkingStep.BOARD,), Pause.BOARD,
)  # fmt: skip
_GO: Final = ProcedureRow(
    WorkingStep.GO, Part.TRAIN, ActingRole.SENDING, ActingRole.DRIVER,
    "train {train} may go", (WorkingStep.CUT_OUT,), Pause.ENTRY, "its time to leave has come",
)  # fmt: skip
_ARRIVED: Final = ProcedureRow(
    WorkingStep.ARRIVED, Part.TRAIN, ActingRole.RECEIVING, ActingRole.SENDING,
    "train {train} has arrived whole, {block} is clear", (WorkingStep.GO,), Pause.TELEPHONE,
    "the train stands at its track with its tail lamp in",
)  # fmt: skip
_ALIGHT: Final = ProcedureRow(
    WorkingStep.ALIGHT, Part.TRAIN, ActingRole.PILOT, ActingRole.RECEIVING,
    "I have left train {train} and am with you", (WorkingStep.ARRIVED,), Pause.BOARD, "", WorkingStep.BOARD,
)  # fmt: skip
_STOP: Final = ProcedureRow(
    WorkingStep.STOP, Part.END, ActingRole.DISPATCHER, ActingRole.OPERATORS,
    "the block manager is back: substitute working in {block} ends", (WorkingStep.ORDER,), Pause.TELEPHONE,
    "the block manager is on",
)  # fmt: skip
_EMPTY: Final = ProcedureRow(
    WorkingStep.EMPTY, Part.END, ActingRole.OPERATORS, ActingRole.OPERATORS,
    "{block} is clear, and nobody is under way by the pilot's leave", (WorkingStep.STOP,), Pause.TELEPHONE,
    "no train is in the section",
)  # fmt: skip
_RELEASE: Final = ProcedureRow(
    WorkingStep.RELEASE, Part.END, ActingRole.PILOT, ActingRole.OPERATORS,
    "I am no longer the pilot of {block}; units may be cut in", (WorkingStep.EMPTY,), Pause.TELEPHONE,
)  # fmt: skip


def _by(row: ProcedureRow, who: ActingRole, to: ActingRole, *needs: WorkingStep) -> ProcedureRow:
    """The same step done by others; `needs`: if it needs others."""
    return replace(row, who=who, to=to, needs=needs or row.needs)


_BEGIN: Final = (_ORDER, _MAN, _CLEAR, _PILOT)
_END: Final = (_STOP, _EMPTY, _RELEASE)
_ALL, _HQ, _TRAIN, _STATION = (
    ActingRole.OPERATORS,
    ActingRole.DISPATCHER,
    ActingRole.DRIVER,
    ActingRole.SENDING,
)
PROCEDURES: Final[Mapping[Regime, tuple[ProcedureRow, ...]]] = MappingProxyType(
    {
        Regime.TELEPHONE: (
            *_BEGIN,
            *(_ASK, _AGREE, _POINTS, _TICKET, _BOARD, _CUT_OUT, _GO, _ARRIVED, _ALIGHT),
            *_END,
        ),
        Regime.SHUTTLE: (
            *_BEGIN,
            _by(_POINTS, _ALL, _ALL, WorkingStep.PILOT),
            *(_BOARD, _CUT_OUT),
            _by(_GO, ActingRole.PILOT, _TRAIN),
            _by(_ARRIVED, ActingRole.PILOT, _STATION),
            _ALIGHT,
            *_END,
        ),
        Regime.DISPATCHER: (
            *(_ORDER, _MAN),
            _by(_CLEAR, _HQ, _HQ),
            _by(_PILOT, _HQ, ActingRole.PILOT),
            _by(_ASK, _TRAIN, _HQ),
            _by(_AGREE, _HQ, _TRAIN),
            *(_POINTS, _BOARD, _CUT_OUT),
            _by(_GO, _HQ, _TRAIN),
            _by(_ARRIVED, _TRAIN, _HQ),
            _by(_ALIGHT, ActingRole.PILOT, _HQ),
            *(_STOP, _by(_EMPTY, _HQ, _HQ), _RELEASE),
        ),
    }
)
# A movement within a station, or between it and its portal: no section between stations, so no pilot.
WITHIN_STATION: Final = (
    *(_ORDER, _MAN),
    _by(_POINTS, _STATION, _STATION, WorkingStep.MAN),
    _by(_CUT_OUT, _TRAIN, _STATION, WorkingStep.POINTS),
    _GO,
    _by(_ARRIVED, _STATION, _STATION),
    *(_STOP, _by(_EMPTY, _STATION, _STATION), _by(_RELEASE, _STATION, _ALL)),
)


def rows_of_train(rows: Sequence[ProcedureRow], *, ticket: bool) -> tuple[ProcedureRow, ...]:
    """The rows as they are for a train with which the pilot rides, or for one that goes by his ticket (指導券)."""
    other = {WorkingStep.BOARD, WorkingStep.ALIGHT} if ticket else {WorkingStep.TICKET}
    return tuple(_by_ticket(row) if ticket else row for row in rows if row.step not in other)


def _by_ticket(row: ProcedureRow) -> ProcedureRow:
    needs = (WorkingStep.TICKET if step is WorkingStep.BOARD else step for step in row.needs)
    return replace(row, needs=tuple(needs))


def before_entry(regime: Regime, *, ticket: bool = False) -> tuple[WorkingStep, ...]:
    """What must have been done before a train comes into the section, with the pilot or by his ticket."""
    rows = rows_of_train(PROCEDURES[regime], ticket=ticket)
    go = next(i for i, row in enumerate(rows) if row.step is WorkingStep.GO)
    return tuple(row.step for row in rows[: go + 1])
