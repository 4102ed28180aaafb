"""`branchline verify`: every state that the running code can come to on a small line, a certificate of them, and
what is held against them: runs, intruders, a search for what breaks bounds.
"""

from __future__ import annotations

import resource
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, NoReturn

import typer

from branchline.ending import end_with
from branchline.options import Json, written_last
from branchline.progress import going_on, print_aside

if TYPE_CHECKING:
    from verify.crossing.explore import CrossingSpace
    from verify.explore import ExploredSpace
    from verify.explored_line import ExploredLine
    from verify.search import Level

verify = typer.Typer(
    no_args_is_help=True, help="Prove the state machines safe on a small line, and check such proofs."
)
_TRAINS: Final = 2
_MEGABYTE: Final = 1 << 20


@verify.command()
def explore(
    config: Annotated[
        str,
        typer.Argument(
            help="How often each may happen: LOSS/DELAY/POWER/WORD, if you like with /POINTS, /SENSOR and /SET_BACK;"
            " 'any' for a delay that is not counted."
        ),
    ] = "1/1/0/0",
    restore: Annotated[
        list[str] | None,
        typer.Option(
            "--restore", help="Switch a former defect of the machines on again, by name; 'list' shows them."
        ),
    ] = None,
    collisions: Annotated[
        bool, typer.Option("--collisions", help="Count nothing as wrong but two trains in one section.")
    ] = False,
    states: Annotated[int, typer.Option("--states", min=1, help="Stop after about so many states.")] = (
        200_000_000
    ),
    out: Annotated[Path | None, written_last("--out", "Where the certificate is written.")] = None,
    chart: Annotated[
        Path | None,
        written_last("--chart", "File for the way to a wrong state, as a sequence chart (Mermaid)."),
    ] = None,
    drill: Annotated[
        Path | None,
        typer.Option(
            "--drill", help="Folder to be made: the way to a wrong state as a drill on a line, which is run."
        ),
    ] = None,
    trains: Annotated[
        int, typer.Option("--trains", min=1, max=3, help="How many trains there are.")
    ] = _TRAINS,
    crossing: Annotated[
        str | None,
        typer.Option(
            "--crossing",
            help="Explore one train and one level crossing instead, with 'barriers' or a 'warning' alone; CONFIG is"
            " then LOSS/POWER/CARRIERS/STORE/EQUIPMENT/POSITION.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Explore every state of a line of a few trains, or of a level crossing: can all finish?"""
    from network.errors import InputError

    if crossing is not None:
        if restore or collisions or out or chart or drill or trains != _TRAINS:
            raise InputError("--crossing", "", crossing, "with it no other option than --states and --json")
        _explore_crossing(crossing, config, states, as_json=as_json)
    from network.files.json_input import write_aside
    from study.record.directory import check_out
    from verify.certificate import write
    from verify.evidence.story_drill import FILES, WHAT
    from verify.explore import certificate_of, explored
    from verify.restored import RESTORED, restored

    names = restore or []
    if names == ["list"]:
        end_with({"restore": sorted(RESTORED)}, sorted(RESTORED), good=True, as_json=as_json)
    _known(names, sorted(RESTORED))
    if out is not None and (names or collisions):
        raise InputError("--out", "", str(out), "no certificate with --restore or --collisions")
    if drill is not None:
        check_out(drill, FILES.__contains__, WHAT, "--drill")
    began_s = time.process_time()
    line = _line(config)._replace(trains=trains)
    with restored(*names):
        try:
            found = explored(line, states, _watch, collisions_alone=collisions)
        except OverflowError as error:
            raise InputError("CONFIG", "", config, f"numbers with which a state has room: {error}") from error
        took_s = max(time.process_time() - began_s, 1e-3)
        figures, lines = _found(found, took_s, collisions=collisions)
        if drill is not None and found.told:
            more, told = _told_on_line(found, drill)
            figures |= more
            lines += told
    if chart is not None and found.chart:
        write_aside(chart, f"```mermaid\n{found.chart}```\n")
        lines.append(f"chart: {chart}")
    if out is not None and found.holds:
        digest = write(out, certificate_of(found))
        figures |= {"certificate": str(out), "digest": digest}
        lines.append(f"certificate: {out}, {out.stat().st_size / _MEGABYTE:.1f} MB, digest {digest}")
    end_with(figures, lines, good=found.holds, as_json=as_json)


def _told_on_line(found: ExploredSpace, out: Path) -> tuple[dict[str, object], list[str]]:
    """The story as a drill, and what the line breaks in it with the machines as they are now."""
    from verify.evidence.story_drill import UntoldError, told_on_line

    try:
        told = told_on_line(found, out)
    except UntoldError as error:
        return {"drill": None, "untold": str(error)}, [f"no drill tells it: {error}"]
    lines = [f"drill: {told.drill}; on the line it breaks:", *(f"  {text}" for text in told.broken)]
    return {"drill": str(told.drill), "drill_breaks": list(told.broken)}, lines


def _explore_crossing(kind: str, config: str, states: int, *, as_json: bool) -> NoReturn:
    """The same of one train and one level crossing."""
    from network.errors import InputError
    from verify.crossing.explore import explore_crossing
    from verify.crossing.explored_crossing import CrossingBudgets, ExploredCrossing

    if kind not in ("barriers", "warning"):
        raise InputError("--crossing", "", kind, "barriers or warning")
    budgets = CrossingBudgets(*_numbers(config, len(CrossingBudgets._fields), uncounted=""))
    began_s = time.process_time()
    found = explore_crossing(ExploredCrossing(kind == "barriers", budgets), states, _watch)
    figures, lines = _found(found, max(time.process_time() - began_s, 1e-3))
    end_with(figures, lines, good=found.holds, as_json=as_json)


def _found(
    found: ExploredSpace | CrossingSpace, took_s: float, *, collisions: bool = False
) -> tuple[dict[str, object], list[str]]:
    """What an exploration comes to: figures, and lines for people."""
    space = found.space
    count = len(space.states)
    figures: dict[str, object] = {
        "distinct": count,
        "generated": space.generated,
        "levels": len(space.levels),
        "complete": space.complete,
        "broken": found.broken,
        "dead": found.dead,
        "story": list(found.story),
        "cpu_s": round(took_s, 1),
        "distinct_per_s": round(count / took_s),
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }
    lines = [
        f"{count} distinct states, {space.generated} generated, {len(space.levels)} levels;"
        f" {took_s:.1f} s of one processor, {count / took_s:.0f} distinct a second, {figures['memory_mb']} MB",
        *_verdict(found.broken, found.dead, complete=space.complete, collisions=collisions),
        *(f"  {index}. {line}" for index, line in enumerate(found.story, start=1)),
    ]
    return figures, lines


@verify.command()
def recount(
    file: Annotated[Path, typer.Argument(help="A certificate, as 'verify explore --out' writes it.")],
    processes: Annotated[int, typer.Option("--processes", min=1, help="Side by side.")] = 2,
    as_json: Json = False,
) -> None:
    """Check a certificate without the search: every state and every successor of it, computed anew."""
    from network.errors import InputError
    from verify.certificate import read
    from verify.recount import recount as recounted

    if not file.is_file():
        raise InputError(str(file), "", None, "a certificate")
    certificate = read(file)
    found = recounted(certificate, lambda count: print_aside(f"{count} states"), processes=processes)
    budgets = "/".join(map(str, certificate.budgets))
    figures = {
        "trains": certificate.trains,
        "budgets": budgets,
        "refused": found.refused,
        "states": found.states,
        "successors": found.successors,
        "finished": found.finished,
        "rank_max": found.rank_max,
    }
    lines = [
        f"refused: {found.refused}"
        if found.refused
        else f"it holds for {certificate.trains} trains and {budgets}: {found.states} states, {found.successors}"
        f" successors all among them, none unsafe; all trains can finish from each in at most {found.rank_max} steps"
    ]
    end_with(figures, lines, good=not found.refused, as_json=as_json)


@verify.command()
def promela(
    out: Annotated[Path, written_last("--out", "Where the model is written.")] = Path("line.pml"),
    as_json: Json = False,
) -> None:
    """Write the line without troubles as a model in Promela, for SPIN: spin -a; cc -DNOREDUCE -DSAFETY; pan -E."""
    from network.files.json_input import write_aside
    from verify.explored_line import ExploredLine
    from verify.promela import model, walked

    composition, states = walked(ExploredLine())
    write_aside(out, model(composition))
    figures = {"model": str(out), "states": len(states)}
    end_with(
        figures, [f"{out}: a model of {len(states)} states, by our own count"], good=True, as_json=as_json
    )


@verify.command()
def inside(
    names: Annotated[list[str], typer.Argument(help="Scenarios, drills, or folders of drills (rtri).")],
    seeds: Annotated[
        int,
        typer.Option(
            "--seeds", min=1, help="How many seeds of each scenario, from its own on: so many late days."
        ),
    ] = 1,
    restore: Annotated[
        list[str] | None,
        typer.Option("--restore", help="Switch a former defect on in the runs, as in explore."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Run scenarios and compare each state of two units and a section with those of the explored line."""
    from verify.evidence.inside import InsideFigures
    from verify.evidence.inside_runs import LINES as EXPLORED
    from verify.evidence.inside_runs import (
        broken_in,
        by_lack,
        explored_views,
        first_without,
        is_by_authority,
        load,
        runs_named,
        view_words,
        watched_run,
    )
    from verify.restored import RESTORED, restored

    _known(restore or [], sorted(RESTORED))
    views, figures, broken = explored_views(EXPLORED, print_aside), InsideFigures(), list[str]()
    for name in runs_named(names):
        first = load(name)
        if not is_by_authority(first):
            print_aside(f"{name}: people work the line, so that it is left out")
            continue
        for seed in range(first.setup.seed, first.setup.seed + seeds):
            day = load(name, seed) if seeds > 1 else first
            going_on(f"{name}, seed {seed}")
            with restored(*(restore or [])):
                broken += broken_in(day, watched_run(day, views, figures))
        print_aside(f"{name}: {figures.states} states, {sum(figures.outside.values())} outside")
    lacks, unknown = by_lack(figures), first_without(figures)
    share = figures.beyond / max(1, figures.events)
    lines = [
        f"{figures.events} events, {figures.states} states of pairs and a section, {len(figures.distinct)} distinct,"
        f" of {len(views)} that explored states have",
        f"outside: {sum(figures.outside.values())} states, at {figures.beyond} events ({100.0 * share:.2f} %)",
        *(f"  {count}: {lack}" for lack, count in lacks.most_common()),
        *(f"a run broke a rule: {text}" for text in broken),
    ]
    if unknown is not None:
        view, at = unknown
        lines.append(
            f"the first without a known lack: {at.run}, after line {at.line} of the journal, {at.who} having acted:"
            f" {at.unit}, {at.other or 'nobody'} and {at.section}: {view_words(view)}"
        )
    told = {
        "events": figures.events,
        "states": figures.states,
        "distinct": len(figures.distinct),
        "views": len(views),
        "outside": sum(figures.outside.values()),
        "events_outside": figures.beyond,
        "lacks": dict(lacks),
        "broken": broken,
        "first": None if unknown is None else unknown[1]._asdict(),
    }
    end_with(told, lines, good=unknown is None and not broken, as_json=as_json)


@verify.command()
def bounds(
    runs: Annotated[int, typer.Option("--runs", min=1, help="How many runs to try.")] = 200,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of all random draws.")] = 1,
    without: Annotated[
        bool,
        typer.Option(
            "--forgives", help="Switch a former defect on: receivers overlook what slides and gaps may hide."
        ),
    ] = False,
    anywhere: Annotated[
        bool, typer.Option("--anywhere", help="On the long lines too, not only the test line.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Search for a run in which the truth leaves the stated bounds: places, sizes and joint faults of sensors."""
    from papers.position_fusion import FORGIVING, JOINT
    from verify.evidence.bounds import in_words, search

    found = search(
        seed,
        runs,
        FORGIVING if without else JOINT,
        anywhere=anywhere,
        watch=lambda count, best: (
            print_aside(f"{count} runs, nearest {best.near:+.3f}") if count % 100 == 0 else None
        ),
    )
    nearest = found.nearest
    assert nearest is not None
    words = in_words(seed, nearest)
    lines = [
        f"{found.runs} searched runs, {len(found.broken)} with the truth outside its bounds",
        f"the nearest: run {nearest.candidate.number} of seed {seed}, "
        + (
            f"{nearest.out_m:.1f} m outside"
            if nearest.broken
            else f"an error of {100.0 * (1.0 + nearest.near):.0f} % of its bound"
        ),
        *(f"  {word}" for word in words),
    ]
    told = {
        "runs": found.runs,
        "broken": len(found.broken),
        "nearest": {
            "number": nearest.candidate.number,
            "out_m": nearest.out_m,
            "near": nearest.near,
            "what": words,
        },
    }
    end_with(told, lines, good=not found.broken, as_json=as_json)


@verify.command()
def intruders(
    scenario: Annotated[str, typer.Argument(help="A scenario, or a drill in which nobody starts again.")] = (
        "rtri_test_line"
    ),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the intruder's telegrams.")] = 1,
    as_json: Json = False,
) -> None:
    """Send an intruder's telegrams, without and with keys, among those of a run: no effect, and each counted."""
    from verify.evidence.inside_runs import load
    from verify.evidence.intruders import ATTACKS, intruded

    found = intruded(load(scenario), seed, tuple(ATTACKS))
    lines = [
        f"{one.attack.value}: {one.sent} telegrams, "
        + (f"the run is another: {one.differs}" if one.differs else "no effect")
        + f"; dropped: {', '.join(f'{count} {why}' for why, count in one.dropped.most_common()) or 'none'}"
        for one in found
    ]
    told = {
        one.attack.value: {"sent": one.sent, "dropped": dict(one.dropped), "differs": one.differs}
        for one in found
    }
    end_with(told, lines, good=all(one.held for one in found), as_json=as_json)


def _verdict(broken: str, dead: int, *, complete: bool, collisions: bool) -> list[str]:
    if broken:
        return [f"broken: {broken}; the shortest way to it:"]
    safe = "without two trains in one section (no other rule was looked at)" if collisions else "safe"
    if dead:
        return [f"{safe}, but from {dead} states not all trains can finish; the shortest way to one:"]
    if complete:
        return [f"all of them are {safe}, and from each all trains can still finish"]
    return [f"{safe} as far as was looked; not all states were"]


def _watch(level: Level) -> None:
    from verify.search import TOLD_EVERY

    if level.depth % TOLD_EVERY == 0:
        print_aside(f"level {level.depth}: {level.distinct} states, {level.generated} generated")


def _known(names: list[str], known: list[str]) -> None:
    from network.errors import InputError

    for name in names:
        if name not in known:
            raise InputError("--restore", "", name, f"one of {', '.join(known)}")


def _line(config: str) -> ExploredLine:
    from network.errors import InputError
    from verify.explored_line import BOOTS, Budgets, ExploredLine

    budgets = Budgets(*_numbers(config, len(Budgets._fields)))
    if budgets.power >= BOOTS:
        raise InputError("CONFIG", "power", config.split("/")[2], f"at most {BOOTS - 1} power cuts")
    return ExploredLine(budgets=budgets)


def _numbers(config: str, most: int, uncounted: str = "any") -> list[int]:
    """The numbers of a CONFIG; `uncounted`: the word for what may happen as often as it may, where that is explored."""
    from network.errors import InputError
    from verify.explored_line import ANY

    numbers = [str(ANY) if part == uncounted else part for part in config.split("/")]
    if not 1 <= len(numbers) <= most or not all(n.isdecimal() for n in numbers):
        raise InputError("CONFIG", "", config, f"up to {most} numbers, as in 1/1/0/0")
    return [int(number) for number in numbers]
