"""What came of a session for those who worked it: how soon faults were acted on and over, what was lost, what wrong.

Times of a fault, of the scenario's own script too: *shown*, when the first alarm after it stood on the dispatcher's
page; *acted*, when somebody at a seat did the first thing after that, refused or not; *recovered*, when it was over,
the register whole again and no train late any more (`study.measures.recovery`). What never came is None, and a run
that goes on is judged as it stands.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

import msgspec

from console.protocol import DeedShown, RuleShown, SeatMessage
from console.session import Session
from console.shown import deeds_shown, rules_shown
from simulation.events import StepNoted, word_of
from simulation.faults.script import Act, ActKind, ItemCourse, ScriptedFault
from simulation.result import Ending
from simulation.setup import STEPS_PER_S, step_not_before
from study.drilling.replay_file import clock_of
from study.measures.day_figures import figures_of_stops
from study.measures.recovery import late_stretches
from study.wording.events import event_text
from study.wording.phrase import names_of
from study.wording.script import item_text
from wayside.acts import SECOND_PERSON
from wayside.said import Refused

IRREGULAR: Final = frozenset(
    {
        ActKind.BAR_UNIT,
        ActKind.CONFIRM_OUTSIDE,
        ActKind.CONFIRM_HOLDING,
        ActKind.ENTER_SECTION,
        ActKind.REENTER_BY_HAND,
        ActKind.HAUL_AWAY,
        ActKind.FREE_ROAD,
        ActKind.REPAIR_POINTS,
        ActKind.TAKE_BACK,
        ActKind.DRIVE,
    }
)


class RefusedAct(msgspec.Struct, frozen=True):
    """An act that somebody at a seat wanted and that could not be: nobody, or nothing, had it."""

    time_s: float
    seat: str
    why: str


class StepScore(msgspec.Struct, frozen=True):
    """A step of substitute working that was not simply done, by a person or as the program plays: `what` is the
    journal's word for it.
    """

    time_s: float
    who: str
    what: str
    text: str
    text_ja: str


class FaultScore(msgspec.Struct, frozen=True, kw_only=True):
    """A fault, and how long after its beginning it was shown, acted on and recovered from, s."""

    began_s: float
    text: str
    text_ja: str
    shown_s: float | None
    acted_s: float | None
    recovered_s: float | None


class DeskScore(msgspec.Struct, frozen=True, kw_only=True):
    """The protocol of a session. `refused_words`: entries that the block manager refused, but for those that wait for a
    second person to say the same; `irregular`: acts outside the running by the timetable, by kind.
    `lost_train_minutes` of a run that goes on: what has not come and should have counts as if it came now.
    """

    run: str
    seed: int
    time_s: float
    ended: str
    digest: str
    trains_planned: int
    trains_arrived: int
    lost_train_minutes: float
    faults: tuple[FaultScore, ...]
    deeds: tuple[DeedShown, ...]
    refused_acts: tuple[RefusedAct, ...]
    refused_words: tuple[RefusedAct, ...]
    irregular: dict[str, int]
    steps: tuple[StepScore, ...]
    rules: tuple[RuleShown, ...]
    messages: tuple[SeatMessage, ...]


def score_of(
    session: Session, refused: tuple[RefusedAct, ...], messages: tuple[SeatMessage, ...]
) -> DeskScore:
    """The protocol until now."""
    ended, setup = session.ended, session.scenario.setup
    acts = [d.item for d in session.deeds if isinstance(d.item, Act) and d.step <= session.step]
    figures = figures_of_stops(session.simulation.stops, setup.timetable, _until_s(session))
    return DeskScore(
        run=session.scenario.id,
        seed=setup.seed,
        time_s=session.now_s,
        ended="" if ended is None else ended.value,
        digest="" if ended is None else session.result.digest,
        trains_planned=sum(train.revenue for train in setup.timetable.trains.values()),
        trains_arrived=sum(setup.timetable.trains[number].revenue for number in session.simulation.arrived),
        lost_train_minutes=round(figures.lost_train_minutes, 2),
        faults=tuple(
            _fault(session, course, refused)
            for course in session.simulation.injector.courses
            if isinstance(course.item, ScriptedFault)
        ),
        deeds=deeds_shown(session),
        refused_acts=refused,
        refused_words=_refused_words(session, {act.person for act in acts}),
        irregular=dict(Counter(act.kind.value for act in acts if act.kind in IRREGULAR)),
        steps=_steps(session),
        rules=rules_shown(session),
        messages=messages,
    )


def score_json(score: DeskScore) -> str:
    """As a file has it."""
    return msgspec.json.format(msgspec.json.encode(score), indent=1).decode() + "\n"


def _refused_words(session: Session, persons: set[str]) -> tuple[RefusedAct, ...]:
    entries = session.journal.entries
    return tuple(
        RefusedAct(e.t_s, e.event.why.partition(":")[0], e.event.why)
        for e in entries
        if isinstance(e.event, Refused)
        and e.event.why.partition(":")[0] in persons
        and not e.event.why.endswith(SECOND_PERSON)
    )


def _steps(session: Session) -> tuple[StepScore, ...]:
    names = names_of(session.scenario.setup.line)
    told = [
        (e, event_text(e.event, names)) for e in session.journal.entries if isinstance(e.event, StepNoted)
    ]
    return tuple(StepScore(e.t_s, e.who, word_of(type(e.event)), w.en, w.in_("ja")) for e, w in told)


def _fault(session: Session, course: ItemCourse, refused: tuple[RefusedAct, ...]) -> FaultScore:
    began_s = course.begun_s
    line = session.line
    alarms = (e.shown.time_s for e in line.events if e.shown.alarm and not e.truth)
    lost = (off_s for off_s, _ in line.outages)  # the picture: the manager was switched off, or began again
    shown_s = min((t for t in (*alarms, *lost) if t >= began_s), default=None)
    since_s = began_s if shown_s is None else shown_s
    done = [d.step / STEPS_PER_S for d in session.deeds if isinstance(d.item, Act)] + [
        r.time_s for r in refused
    ]
    acted_s = min((t for t in done if since_s <= t <= session.now_s), default=None)
    words, begun = item_text(course.item), clock_of(step_not_before(began_s))
    recovered_s = _recovered(session, course)
    return FaultScore(
        began_s=began_s,
        text=f"{begun} {words.en}",
        text_ja=f"{begun} {words.in_('ja')}",
        shown_s=None if shown_s is None else round(shown_s - began_s, 1),
        acted_s=None if acted_s is None else round(acted_s - began_s, 1),
        recovered_s=None if recovered_s is None else round(recovered_s - began_s, 1),
    )


def _recovered(session: Session, course: ItemCourse) -> float | None:
    """When it was over, the register whole and no train late any more; None: it is not so yet."""
    line, ended, end_s = session.line, session.ended, _until_s(session)
    whole = line.defined and line.manager_on
    if course.over_s is None or not whole or ended not in (None, Ending.FINISHED):
        return None
    late = late_stretches(session.simulation.stops, session.scenario.setup.timetable, end_s)
    since = [one for one in late if one.to_s > course.begun_s]
    if any(not one.over or one.to_s > end_s for one in since):
        return None
    outages_s = [on_s for _, on_s in line.outages if on_s is not None and on_s > course.begun_s]
    return max([course.over_s, *outages_s, *(one.to_s for one in since)])


def _until_s(session: Session) -> float:
    """When what has not come counts as come: at present, or after the end when the run ends whatever happens."""
    return session.now_s if session.ended is None else session.scenario.setup.latest_end_s
