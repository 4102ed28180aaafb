"""A story of the exploration told on a running line: a drill, in which each trouble comes where the story has it.

What the story has of bodies and timers comes of itself on the line; its troubles are made faults and acts: a telegram
that it loses, or that is heard only after something else has happened, finds its link cut until then, or is late by so
much; a party without power has none until it has it again; points are not detected, a tachometer shows nothing; crews
set routes back, and persons say what they say. When each begins and ends is found by running the day
with those before it, up to where the story has come by then. Whether the line then breaks a rule is for its judge to
say: where the story is of a former defect, that must be restored while this is called.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import product, takewhile
from pathlib import Path
from shutil import copytree
from typing import Final, NamedTuple

from network.clock import clock
from onboard.notes import MissionBegun, Moving
from radio.envelope import ON_THE_AIR_S
from radio.noted import Sent, TookEffect
from scenario.scenario import Scenario, load_scenario
from simulation.events import Entered, JournalEntry, Left
from simulation.faults.devices import PowerCut
from simulation.faults.links import Cut, Delay, FaultyLink
from simulation.faults.points import NoDetection, Stuck
from simulation.faults.script import Act, ActKind, Script, ScriptedFault, Trigger
from simulation.faults.tachometer import NoOutput
from simulation.setup import STEP_S
from study.drilling.replay_file import replay_of
from study.record.directory import replacing_folder
from study.runner.outcome import broken_rules, unfinished
from study.runner.run import CarrierKind
from verify.composition import HEARS, Composition, Following
from verify.evidence.watched import result_of
from verify.explore import ExploredSpace
from verify.explored_line import POINTS_OF, PORTAL, TERMINALS, UNITS, UnwishedFor
from verify.train import PEERS
from verify.train_events import HOLD_S
from wayside.config import MANAGER_ID

LINE: Final = files("verify.evidence") / "explored"
DAY, TIMES, DRILL = "day.toml", "times.toml", "story.toml"
FILES: Final = frozenset({"explored.toml", DAY, TIMES, DRILL})
WHAT: Final = "a story"
# how long after the first train the second is due; the first that tells the story
APART_S: Final = (60, 20, 300, 380)
FIRST_S: Final = 36_000
STAYS_S: Final = 600.0  # how long a cut or a dead party lasts that the story does not end
AFTER_S: Final = 120  # from a train's arrival until it leaves
POWER_FAILS, POWER_BACK = "power fails", "power is back"
NOT_DETECTED, TOO_LONG = "position or lock are detected no more", "a throw takes too long"
DETECTED, LIE = "position and lock are detected again", "points come to lie and are locked"
LOST, SETS_BACK, RUNS_ON = "PositionLost", "SetBack", "Looked"
SENDS_S: Final = 0.2  # about the time at which a telegram is sent
UNSEEN_S: Final = (
    60.0  # how long a tachometer shows nothing: a train that stands may move by then, which tells its unit
)
ACCEPTS: Final = "a person accepts the picture"
OFF: Final = "off the line"
WORD: Final = re.compile(r"(.+?) (bar|unbar|says? that|takes back what was said of) (u\d)(?: is (.+))?")
# each once a train, whatever its unit hears meanwhile
BODILY: Final = {"enters": Entered, "passes the boundary": Left}
NOTED: Final = {
    **dict.fromkeys(("Begin", "SwitchedOn", "ChangeEnds"), MissionBegun),
    "WheelsTurning": Moving,
}
RUNS_S: Final = 8.0  # about how long a train takes for a third of a section, from a stand
UNTROUBLED: Final = """
[[expect]]
text = "no rule is broken on a day without troubles"
property = "no_invariant_broken"
"""
NOW: Final = Trigger(at_s=0.0)
LEAST_S: Final = 1.0  # as long as a party is without power at least
UNUSED: Final = TERMINALS[1]  # the line has one set of points, for all routes in the place of both
POINTS: Final = POINTS_OF[TERMINALS[0]]
_TRACKS: Final = {"u1": "A", "u2": "B"}
_DOES: Final = {
    "bar": ActKind.BAR_UNIT,
    "unbar": ActKind.UNBAR_UNIT,
    "takes back what was said of": ActKind.TAKE_BACK,
}


class UntoldError(Exception):
    """The story cannot be told on the line; the text says from where on."""


class ToldOnLine(NamedTuple):
    """`drill`: the file; what the line then broke, or lacks, in words; empty: nothing."""

    drill: Path
    broken: tuple[str, ...]


@dataclass(slots=True)
class _Trouble:
    """What must be made to happen: after this many events of the story, until after that many (None: to its end)."""

    begins: int
    ends: int | None
    what: Cut | PowerCut | NoDetection | Stuck | NoOutput | Act
    sent: tuple[str, str, str] | None = None  # of a telegram: from whom, to whom, what
    waits_s: float = STEP_S  # from then until it is so
    lasts_s: float = STAYS_S  # where it has no end
    arrives: bool = False  # a telegram that is late, and not lost
    from_s: float | None = None
    to_s: float | None = None


def told_on_line(found: ExploredSpace, out: Path) -> ToldOnLine:
    """Tell the story of what was found as a drill, in a folder that is made, with its line, and run that. Raises
    UntoldError.
    """
    reasons: list[str] = []
    for arrives, apart_s, late in product((False, True), APART_S, (True, False)):
        try:
            with replacing_folder(out, FILES.__contains__, WHAT) as folder:
                broken = _told_in(folder, found, apart_s, late=late, arrives=arrives)
            return ToldOnLine(out / DRILL, broken)
        except UntoldError as error:
            reasons.append(str(error))
    raise UntoldError("; ".join(dict.fromkeys(reasons)))


def _told_in(
    folder: Path, found: ExploredSpace, apart_s: int, *, late: bool, arrives: bool
) -> tuple[str, ...]:
    """The files of a drill, and what the line breaks in it. Raises UntoldError where that is nothing."""
    copytree(str(LINE), folder)
    first = next((event.who for event in found.told if event.what == "enters"), UNITS[0])
    (folder / TIMES).write_text(_times(first, apart_s), "utf-8")
    scenario = load_scenario(str(folder / DAY))
    script = _script(found, scenario, late=late, arrives=arrives)
    text = replay_of(scenario, script, "story", "A story of the exploration")
    if not (script.faults or script.acts):
        text = text.replace("expect = []\n", UNTROUBLED)
    (folder / DRILL).write_text(text.replace(f'"{scenario.file}"', f'"{DAY}"'), "utf-8")
    broken = broken_by(folder / DRILL)
    if not broken:
        raise UntoldError("the line breaks no rule")
    return broken


def broken_by(drill: Path) -> tuple[str, ...]:
    """Run a drill: which rules it breaks, and what is missing at its end."""
    result = result_of(load_scenario(str(drill)), CarrierKind.SUMO)
    return (*(text for _, text in broken_rules(result)), *unfinished(result))


def _times(first: str, apart_s: int) -> str:
    """The timetable: the other train is due so much after the first."""
    order = sorted(UNITS[:2], key=lambda unit: unit != first)
    text = (
        '[timetable]\nid = "times"\nname = "Two trains come in, turn and leave"\nline = "explored"\n'
        'dwell_min_s = 20\nsources = ["docs/every-state.md"]\nassumed = ["times: a story has none"]\n'
    )
    for place, unit in enumerate(order):
        arrival, departure = (clock(FIRST_S + place * apart_s + wait_s) for wait_s in (0, AFTER_S))
        track, number = _TRACKS[unit], unit.removeprefix("u")
        text += f"""
[[trains]]
number = "{number}1"
direction = "down"
calls = [{{ station = "S", track = "{track}", arrival = "{arrival}" }}]
begins = "portal:{PORTAL}"
ends = "becomes:{number}2"

[[trains]]
number = "{number}2"
direction = "up"
calls = [{{ station = "S", track = "{track}", departure = "{departure}" }}]
begins = "from:{number}1"
ends = "portal:{PORTAL}"

[[diagrams]]
stock = "{unit}"
trains = ["{number}1", "{number}2"]
"""
    return text


# when each trouble begins and ends -----------------------------------------------------------------------------------


def _script(space: ExploredSpace, scenario: Scenario, *, late: bool, arrives: bool) -> Script:
    """Every trouble of the story at its time on this day. Raises UntoldError. `arrives`: what is heard later than it
    might be is late, where it otherwise is lost and its repetition heard.

    What is still on the air at its end stays unheard where a rule is broken then; where the end is a dead state it does
    not help, heard or not.
    """
    composition, told = Composition(space.parties), space.told
    on_the_air = list(_on_the_air(composition, told))
    for trouble in on_the_air:
        if trouble.ends is None and space.dead and arrives:
            trouble.ends, trouble.arrives = len(told), True  # heard once all else has come
        trouble.arrives = trouble.arrives and arrives
    on_the_air = [trouble for trouble in on_the_air if trouble.ends is not None or not space.dead]
    troubles = [*_troubles(told, late=late), *on_the_air]
    bounds = [(trouble.begins, False, trouble) for trouble in troubles]
    bounds += [(trouble.ends, True, trouble) for trouble in troubles if trouble.ends is not None]
    for events, over, trouble in sorted(bounds, key=lambda bound: bound[:2]):
        setup = replace(scenario.setup, script=_so_far(troubles))
        entries = result_of(replace(scenario, setup=setup), CarrierKind.PLAIN).journal.entries
        came = _CourseOfStory(composition, told, troubles, entries)
        if over:
            assert trouble.from_s is not None
            trouble.to_s = max(came.by(events) + STEP_S, trouble.from_s + LEAST_S)
        elif trouble.sent is None:
            trouble.from_s = came.by(events) + trouble.waits_s
            if arrives and isinstance(trouble.what, Act):
                trouble.from_s = max(trouble.from_s, came.next_after(events) - LEAST_S)
        else:
            trouble.from_s = came.sent(events, trouble.sent) - STEP_S
    return _so_far(troubles)


def _so_far(troubles: Sequence[_Trouble]) -> Script:
    faults: list[ScriptedFault] = []
    acts: list[Act] = []
    for trouble in sorted((t for t in troubles if t.from_s is not None), key=lambda t: t.from_s or 0.0):
        from_s = round(trouble.from_s or 0.0, 1)
        trigger = Trigger(at_s=from_s)
        if isinstance(trouble.what, Act):
            acts.append(replace(trouble.what, trigger=trigger))
            continue
        lasts_s = trouble.lasts_s if trouble.to_s is None else round(trouble.to_s - from_s, 1)
        if trouble.arrives and trouble.to_s is not None and isinstance(trouble.what, Cut):
            late = Delay(target=trouble.what.target, seconds=lasts_s)
            faults.append(ScriptedFault(late, trigger, SENDS_S))
            # What is sent after it is not to overtake it.
            trigger, lasts_s = Trigger(at_s=round(from_s + SENDS_S, 1)), round(lasts_s - SENDS_S, 1)
        if lasts_s > 0.0:
            faults.append(ScriptedFault(trouble.what, trigger, lasts_s))
    return Script(tuple(faults), tuple(acts))


class _CourseOfStory:
    """A run held against the story: when each event came of those that a journal has, in the order of each party."""

    def __init__(
        self,
        composition: Composition,
        told: Sequence[Following],
        troubles: Sequence[_Trouble],
        entries: Sequence[JournalEntry],
    ) -> None:
        self._composition, self._told, self._entries = composition, told, entries
        self._made: Final = {trouble.begins: trouble for trouble in troubles if trouble.sent is None}

    def by(self, events: int) -> float:
        """When the last of so many events of the story had come, s. Raises UntoldError where one never did."""
        return max((at_s for _, _, at_s in self._times(events)), default=0.0)

    def next_after(self, events: int) -> float:
        """When the first came that the story has behind so many, of those that came, s; 0: none did."""
        came = list[float]()
        with suppress(UntoldError):
            came += (at_s for number, _, at_s in self._times(len(self._told)) if number > events)
        return min(came, default=0.0)

    def sent(self, events: int, telegram: tuple[str, str, str]) -> float:
        """When the last of these events had its party send a telegram, s. Raises UntoldError."""
        source, receiver, kind = telegram
        from_s = max((at_s for _, who, at_s in self._times(events) if who == source), default=0.0)
        for entry in self._entries:
            event = entry.event
            if (
                entry.t_s >= from_s
                and isinstance(event, Sent)
                and (event.source, event.receiver, event.kind) == telegram
            ):
                return entry.t_s
        raise UntoldError(f"{source} sends no {kind} to {receiver} after {events} events")

    def _times(self, events: int) -> Iterator[tuple[int, str, float]]:
        at: dict[str, int] = {}
        for number, found in enumerate(self._told[:events]):
            who = _party(found.who)
            seen = self._seen(number, found)
            if seen is None:
                continue
            bodily = found.what in BODILY
            from_k = 0 if bodily else at.get(who, 0)
            k = next((k for k in range(from_k, len(self._entries)) if seen(self._entries[k])), None)
            if k is None:
                raise UntoldError(f"event {number + 1} never comes: {found.who} {found.what}")
            if not bodily:
                at[who] = k + 1
            yield number, who, self._entries[k].t_s

    def _seen(self, number: int, found: Following) -> Callable[[JournalEntry], bool] | None:
        """Whether an entry of the journal is this event; None: it has nothing of it, or not of this party."""
        who = _party(found.who)
        if UNUSED in (who, found.other) or (found.what == HEARS and who in self._off(number)):
            return None
        if found.what == HEARS:
            kind = type(self._composition.parties.telegrams.things[found.telegram].message).__name__
            return lambda entry: (
                isinstance(entry.event, TookEffect)
                and (entry.event.source, entry.event.receiver, entry.event.kind) == (found.other, who, kind)
            )
        if (made := self._made.get(number)) is not None and made.from_s is not None:
            from_s = made.from_s
            return lambda entry: entry.t_s >= from_s
        if (note := NOTED.get(found.what)) is not None:
            return lambda entry: entry.who == who and isinstance(entry.event, note)
        if (kinds := BODILY.get(found.what)) is not None:
            return lambda entry: isinstance(entry.event, kinds) and entry.event.unit_id == who
        return None

    def _off(self, number: int) -> set[str]:
        """Which parties have no power by then, in the story."""
        off = set[str]()
        for found in self._told[:number]:
            if found.what == POWER_FAILS:
                off.add(_party(found.who))
            elif found.what == POWER_BACK:
                off.discard(_party(found.who))
        return off


# what the troubles are -----------------------------------------------------------------------------------------------


def _troubles(told: Sequence[Following], *, late: bool) -> Iterator[_Trouble]:
    """Parties without power, and what persons say, of which people wait until it is taken.

    `late`: power is back when the party next does something, not as soon as the story has it back.
    """
    restarted = False
    for number, found in enumerate(told):
        who = _party(found.who)
        if found.telegram >= 0 or (who == UNUSED and found.trouble is not UnwishedFor.POINTS):
            continue
        own = [k for k in range(number + 1, len(told)) if _party(told[k].who) == who]
        if found.what == POWER_FAILS:
            back = next((k for k in own if told[k].what == POWER_BACK), None)
            if late and back is not None:
                back = next((k for k in own if k > back), None)
            yield _Trouble(number, back, PowerCut(target=who))
            restarted |= who == MANAGER_ID
        elif found.what == NOT_DETECTED:
            seen = next((k for k in own if told[k].what == DETECTED), None)
            ran = sum(1 for _ in takewhile(lambda event: event.what == RUNS_ON, reversed(told[:number])))
            yield _Trouble(number, seen, NoDetection(target=POINTS), waits_s=STEP_S + ran * RUNS_S)
        elif found.what == TOO_LONG:
            yield _Trouble(number, next((k for k in own if told[k].what == LIE), None), Stuck(target=POINTS))
        elif found.what == LOST:
            yield _Trouble(number, None, NoOutput(target=who), lasts_s=UNSEEN_S)
        elif found.what == SETS_BACK:
            yield _Trouble(number, None, Act(ActKind.GIVE_BACK, who, NOW, hold_s=HOLD_S))
        elif who == MANAGER_ID:
            acts = _acts(found.what)
            restarted |= any(act.kind is ActKind.BAR_UNIT for act in acts)
            wait_s = ON_THE_AIR_S + 1.0 if restarted else STEP_S
            for act in acts:
                yield _Trouble(number, None, act, waits_s=wait_s)


def _is_made(found: Following) -> bool:
    """Whether it comes when it is made to, and takes no time then."""
    return found.what in (POWER_FAILS, POWER_BACK, NOT_DETECTED, SETS_BACK) or bool(_acts(found.what))


def _acts(what: str) -> tuple[Act, ...]:
    """What persons do at the manager, by the name that the model has for it."""
    if what == ACCEPTS:
        return (Act(ActKind.REENTER_ASSISTED, "", NOW),)
    match = WORD.fullmatch(what)
    if match is None:
        return ()
    persons, does, unit, stands = match.groups()
    kind = _DOES.get(does)
    sections = () if stands in (None, OFF) else tuple(stands.removeprefix("in ").split())
    if kind is None:
        kind = ActKind.CONFIRM_HOLDING if sections else ActKind.CONFIRM_OUTSIDE
    place = PORTAL if kind is ActKind.CONFIRM_OUTSIDE else ""
    return tuple(Act(kind, unit, NOW, person, sections, place=place) for person in persons.split(" and "))


def _on_the_air(composition: Composition, told: Sequence[Following]) -> Iterator[_Trouble]:
    """Links that are cut for telegrams which the story loses, or leaves on the air while something else happens."""
    state = composition.start()
    under_way: dict[tuple[int, int], deque[tuple[int, str]]] = {}
    for number, found in enumerate(told):
        for unit, (before, after) in enumerate(zip(state.cells, found.state.cells, strict=True)):
            for way, (queue, now) in enumerate(zip(before.air, after.air, strict=True)):
                flights = under_way.setdefault((unit, way), deque())
                taken = found.telegram >= 0 and (unit, way) == _way(found)
                if taken and (trouble := _held_up(flights.popleft(), (unit, way), number, told)) is not None:
                    yield trouble
                for _ in range(len(queue) - taken - len(now)):
                    flights.popleft()  # gone with the power of its receiver
                for telegram in now[len(now) - max(len(now) - len(queue) + taken, 0) :]:
                    message = composition.parties.telegrams.things[telegram].message
                    flights.append((number, type(message).__name__))
        state = found.state
    for key, flights in under_way.items():
        for flight in flights:
            if (trouble := _held_up(flight, key, None, told)) is not None:
                yield trouble


def _held_up(
    flight: tuple[int, str], key: tuple[int, int], ended: int | None, told: Sequence[Following]
) -> _Trouble | None:
    """The cut of a link for one telegram: sent by an event, heard or lost at another, or never."""
    (sent, kind), (unit, way) = flight, key
    ends = UNITS[unit], PEERS[way // 2]
    source, receiver = reversed(ends) if way % 2 else ends
    if UNUSED in ends:
        return None
    until = ended
    # lost; its link is back for the next that is heard on it
    if ended is not None and told[ended].what != HEARS:
        heard = (k for k in range(ended, len(told)) if told[k].what == HEARS and _way(told[k]) == key)
        until = next(heard, None)
    elif ended is not None:
        between = [k for k in range(sent + 1, ended) if told[k].telegram < 0 and not _is_made(told[k])]
        if not between:
            return None
        until = between[-1] + 1
    arrives = ended is not None and told[ended].what == HEARS
    cut = Cut(target=FaultyLink(source, receiver))
    return _Trouble(sent + 1, until, cut, sent=(source, receiver, kind), arrives=arrives)


def _way(found: Following) -> tuple[int, int]:
    """The unit and the queue of a telegram that is heard or lost."""
    sender, hearer = (found.other, found.who) if found.what == HEARS else (found.who, found.other)
    down = sender in PEERS
    unit, peer = (hearer, sender) if down else (sender, hearer)
    return UNITS.index(unit), 2 * PEERS.index(peer) + down


def _party(who: str) -> str:
    return MANAGER_ID if who == "manager" else who
