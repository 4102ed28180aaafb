"""Substitute working (代用閉そく方式) as tables: who says what to whom, and what must have been done before.

Pure data, of which the program's players (`simulation.substitute`), the pilot's rule (`judge.pilot`), drills and
docs/substitute-working.md are made. When nothing keeps trains apart any more, people do: one person, the pilot (指導者),
belongs to a section, and a train goes into it with the pilot or with the pilot's ticket alone.

Sources: rules for the operation of railways (鉄道運転規則, Ordinance 15 of 1987 of the Ministry of Transport), articles 130
to 146; the account of the procedure for an unstaffed signal station before the transport committee of the House of
Councillors, 30 May 1991; the JNR rules for train operation (運転取扱基準規程, 1972), chapter 3, on when two stations agree on the
change of working. What the rules leave to each railway is assumed: who cranks points, that the driver cuts the unit out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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


class Role(StrEnum):
    """Who acts, or is spoken to."""

    DISPATCHER = "dispatcher"
    OPERATORS = "both operators"
    SENDING = "operator where the train stands"
    RECEIVING = "operator at the other end"
    PILOT = "pilot"
    DRIVER = "driver"


class Part(Enum):
    """When a step is due."""

    BEGIN = "once, to begin"
    TRAIN = "for each train"
    END = "once, to end"


class Step(StrEnum):
    """The steps; a drill names those that are left out."""

    ORDER = "order"
    MAN = "man"
    CLEAR = "clear"
    PILOT = "pilot"
    ASK = "ask"
    AGREE = "agree"
    POINTS = "points"
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

    step: Step
    part: Part
    who: Role
    to: Role
    says: str
    needs: tuple[Step, ...]
    pause: Pause
    waits: str = ""
    falls_with: Step | None = None


_ORDER: Final = ProcedureRow(
    Step.ORDER, Part.BEGIN, Role.DISPATCHER, Role.OPERATORS,
    "the block manager is out of order: substitute working in {block}", (), Pause.NOTICE,
    "the block manager is off",
)  # fmt: skip
_MAN: Final = ProcedureRow(
    Step.MAN, Part.BEGIN, Role.OPERATORS, Role.DISPATCHER,
    "I am at my post for {block}", (Step.ORDER,), Pause.REACH,
    "staff are on their way to stations without any",
)  # fmt: skip
_CLEAR: Final = ProcedureRow(
    Step.CLEAR, Part.BEGIN, Role.OPERATORS, Role.OPERATORS,
    "{block} is clear, and no train may still run into it", (Step.MAN,), Pause.TELEPHONE,
    "no train is in the section, none has authority to run into it",
)  # fmt: skip
_PILOT: Final = ProcedureRow(
    Step.PILOT, Part.BEGIN, Role.OPERATORS, Role.PILOT,
    "you are the pilot of {block}, you alone", (Step.CLEAR,), Pause.TELEPHONE,
)  # fmt: skip
_ASK: Final = ProcedureRow(
    Step.ASK, Part.TRAIN, Role.SENDING, Role.RECEIVING,
    "may train {train} come through {block}?", (Step.PILOT,), Pause.TELEPHONE,
    "the train is next by the plan, stands at its track, and the last one has been reported arrived",
)  # fmt: skip
_AGREE: Final = ProcedureRow(
    Step.AGREE, Part.TRAIN, Role.RECEIVING, Role.SENDING,
    "train {train} may come through {block}; I let none in", (Step.ASK,), Pause.TELEPHONE,
    "its arrival track and the points before it are free", Step.ASK,
)  # fmt: skip
_POINTS: Final = ProcedureRow(
    Step.POINTS, Part.TRAIN, Role.OPERATORS, Role.OPERATORS,
    "points lie and are locked by hand for train {train}", (Step.AGREE,), Pause.CRANK,
    "no train is on the points",
)  # fmt: skip
_BOARD: Final = ProcedureRow(
    Step.BOARD, Part.TRAIN, Role.PILOT, Role.DRIVER,
    "I ride with train {train} through {block}", (Step.POINTS,), Pause.BOARD,
    "the pilot is where the train stands", Step.PILOT,
)  # fmt: skip
_CUT_OUT: Final = ProcedureRow(
    Step.CUT_OUT, Part.TRAIN, Role.DRIVER, Role.PILOT,
    "the unit of train {train} is cut out", (Step.BOARD,), Pause.BOARD,
)  # fmt: skip
_GO: Final = ProcedureRow(
    Step.GO, Part.TRAIN, Role.SENDING, Role.DRIVER,
    "train {train} may go", (Step.CUT_OUT,), Pause.ENTRY, "its time to leave has come",
)  # fmt: skip
_ARRIVED: Final = ProcedureRow(
    Step.ARRIVED, Part.TRAIN, Role.RECEIVING, Role.SENDING,
    "train {train} has arrived whole, {block} is clear", (Step.GO,), Pause.TELEPHONE,
    "the train stands at its track with its tail lamp in",
)  # fmt: skip
_ALIGHT: Final = ProcedureRow(
    Step.ALIGHT, Part.TRAIN, Role.PILOT, Role.RECEIVING,
    "I have left train {train} and am with you", (Step.ARRIVED,), Pause.BOARD, "", Step.BOARD,
)  # fmt: skip
_STOP: Final = ProcedureRow(
    Step.STOP, Part.END, Role.DISPATCHER, Role.OPERATORS,
    "the block manager is back: substitute working in {block} ends", (Step.ORDER,), Pause.TELEPHONE,
    "the block manager is on",
)  # fmt: skip
_EMPTY: Final = ProcedureRow(
    Step.EMPTY, Part.END, Role.OPERATORS, Role.OPERATORS,
    "{block} is clear, and nobody is under way by the pilot's leave", (Step.STOP,), Pause.TELEPHONE,
    "no train is in the section",
)  # fmt: skip
_RELEASE: Final = ProcedureRow(
    Step.RELEASE, Part.END, Role.PILOT, Role.OPERATORS,
    "I am no longer the pilot of {block}; units may be cut in", (Step.EMPTY,), Pause.TELEPHONE,
)  # fmt: skip


def _by(row: ProcedureRow, who: Role, to: Role, needs: tuple[Step, ...] | None = None) -> ProcedureRow:
    return ProcedureRow(
        row.step, row.part, who, to, row.says, row.needs if needs is None else needs,
        row.pause, row.waits, row.falls_with,
    )  # fmt: skip


PROCEDURES: Final[Mapping[Regime, tuple[ProcedureRow, ...]]] = MappingProxyType(
    {
        Regime.TELEPHONE: (
            _ORDER, _MAN, _CLEAR, _PILOT,
            _ASK, _AGREE, _POINTS, _BOARD, _CUT_OUT, _GO, _ARRIVED, _ALIGHT,
            _STOP, _EMPTY, _RELEASE,
        ),
        Regime.SHUTTLE: (
            _ORDER, _MAN, _CLEAR, _PILOT,
            _by(_POINTS, Role.OPERATORS, Role.OPERATORS, (Step.PILOT,)),
            _BOARD, _CUT_OUT, _by(_GO, Role.PILOT, Role.DRIVER),
            _by(_ARRIVED, Role.PILOT, Role.SENDING), _ALIGHT,
            _STOP, _EMPTY, _RELEASE,
        ),
        Regime.DISPATCHER: (
            _ORDER, _MAN, _by(_CLEAR, Role.DISPATCHER, Role.DISPATCHER), _by(_PILOT, Role.DISPATCHER, Role.PILOT),
            _by(_ASK, Role.DRIVER, Role.DISPATCHER), _by(_AGREE, Role.DISPATCHER, Role.DRIVER),
            _POINTS, _BOARD, _CUT_OUT, _by(_GO, Role.DISPATCHER, Role.DRIVER),
            _by(_ARRIVED, Role.DRIVER, Role.DISPATCHER), _by(_ALIGHT, Role.PILOT, Role.DISPATCHER),
            _STOP, _by(_EMPTY, Role.DISPATCHER, Role.DISPATCHER), _RELEASE,
        ),
    }
)  # fmt: skip
# A movement within a station, or between it and its portal: no section between stations, so no pilot.
WITHIN_STATION: Final = (
    _ORDER, _MAN,
    _by(_POINTS, Role.SENDING, Role.SENDING, (Step.MAN,)), _by(_CUT_OUT, Role.DRIVER, Role.SENDING, (Step.POINTS,)),
    _GO, _by(_ARRIVED, Role.SENDING, Role.SENDING),
    _STOP, _by(_EMPTY, Role.SENDING, Role.SENDING), _by(_RELEASE, Role.SENDING, Role.OPERATORS),
)  # fmt: skip


def before_entry(regime: Regime) -> tuple[Step, ...]:
    """What must have been done before a train comes into the section."""
    rows = PROCEDURES[regime]
    go = next(i for i, row in enumerate(rows) if row.step is Step.GO)
    return tuple(row.step for row in rows[: go + 1])
