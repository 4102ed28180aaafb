"""What a run came to: which rules it broke, and whether it reached its end. Runs, drills and reports all ask here."""

from __future__ import annotations

from network.clock import clock
from simulation.events import Unsafe
from simulation.judge.checkers import Checker
from simulation.judge.rail import LowAdhesion
from simulation.result import Ending, RunResult, Waiting
from simulation.setup import STEPS_PER_S
from study.wording import outcome as words
from study.wording.phrase import NOTHING, Phrase, joined_phrases
from study.wording.reasons import reason


def broken_rules(result: RunResult) -> list[tuple[float, str]]:
    """`rules_said` in English."""
    return [(at_s, sentence.en) for at_s, sentence in rules_said(result)]


def rules_said(result: RunResult) -> list[tuple[float, Phrase]]:
    """When and what: collisions, what the world calls unsafe, rules that checkers found broken, arrival apart.

    What followed from less adhesion than the design counts on is not among them; a collision always is.
    """
    outside = {(v.t_s, v.text) for v in result.outside_design}
    collided = words.checker_name(Checker.SUMO_COLLISION.value).ja
    broken = [(result.end_step / STEPS_PER_S, Phrase(text, collided)) for text in result.collisions]
    unsafe = [
        (entry.t_s, words.DANGER.fill(unit=entry.event.unit_id, how=words.unsafe_text(entry.event)))
        for entry in result.journal.entries
        if isinstance(entry.event, Unsafe)
    ]
    broken += [(at_s, sentence) for at_s, sentence in unsafe if (at_s, sentence.en) not in outside]
    broken += [
        (v.t_s, words.rule_text(v)) for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES
    ]
    return broken


def outside_design(result: RunResult) -> tuple[str, ...]:
    """`outside_said` in English."""
    return tuple(sentence.en for sentence in outside_said(result))


def outside_said(result: RunResult) -> tuple[Phrase, ...]:
    """Who ran on less adhesion than the design counts on, and what followed from it: reported, but no rule broken."""
    by_unit: dict[str, list[LowAdhesion]] = {}
    for stretch in result.slippery:
        by_unit.setdefault(stretch.unit_id, []).append(stretch)
    sentences: list[Phrase] = []
    for unit_id, stretches in sorted(by_unit.items()):
        last_s = stretches[-1].to_s
        until = words.THE_END if last_s is None else Phrase(clock(int(last_s)))
        count = len(stretches)
        sentences.append(
            words.SLIPPERY.fill(
                unit=unit_id,
                times=words.ONCE if count == 1 else words.TIMES.fill(count=count),
                since=clock(int(stretches[0].from_s)),
                until=until,
                least=min(s.least for s in stretches),
            )
        )
    followed = (
        words.OUTSIDE.fill(at=clock(int(v.t_s)), what=words.rule_text(v)) for v in result.outside_design
    )
    return (*sentences, *followed)


def unfinished(result: RunResult) -> tuple[str, ...]:
    """`missing_said` in English."""
    return tuple(sentence.en for sentence in missing_said(result))


def missing_said(result: RunResult) -> tuple[Phrase, ...]:
    """What is missing for a run that reached its end: trains, stocks, the end itself; empty where nothing is."""
    if result.ended_because.of_part:
        return ()  # how late they are by then is in the figures
    planned = (*result.trains_planned, *result.empty_planned)
    came = (*result.trains_arrived, *result.empty_arrived, *result.cut)
    missing = [number for number in planned if number not in came]
    said = words.ONE_MISSING if len(missing) == 1 else words.MISSING
    sentences = [said.fill(count=len(missing), trains=", ".join(missing))] if missing else []
    sentences += [words.NOT_HOME.fill(unit=stock_id) for stock_id in result.unfinished]
    if result.ended_because is not Ending.FINISHED:
        sentences.append(words.CUT_SHORT.fill(why=words.ending_text(result.ended_because.value)))
    return tuple(sentences)


def waiting_said(waiting: Waiting) -> Phrase:
    """Who stands where and waits for what, in a sentence."""
    form = words.STANDS if waiting.stands else words.ON_ITS_WAY
    head, colon, why = waiting.waits_for.partition(": ")
    what = joined_phrases((Phrase(head), reason(why) if colon else NOTHING), ": ", "：")
    return form.fill(train=waiting.number, unit=waiting.stock_id, place=waiting.place, what=what)
