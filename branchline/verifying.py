"""`branchline verify`: every state that the running code can come to on a small line, and a certificate of them."""

from __future__ import annotations

import resource
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline.ending import end_with
from branchline.options import Json
from branchline.progress import print_aside

if TYPE_CHECKING:
    from verify.explored_line import ExploredLine
    from verify.search import Level

verify = typer.Typer(no_args_is_help=True, help="What is proven of the machines that run, and its recount.")
_TOLD_EVERY: Final = 10  # levels
_MEGABYTE: Final = 1 << 20


@verify.command()
def explore(
    config: Annotated[
        str,
        typer.Argument(
            help="How often each may happen: LOSS/DELAY/POWER/WORD, if you like with /POINTS and /SENSOR;"
            " 'any' for a delay that is not counted."
        ),
    ] = "1/1/0/0",
    restore: Annotated[
        list[str] | None,
        typer.Option("--restore", help="A behaviour that the machines had once, by name; 'list' shows them."),
    ] = None,
    collisions: Annotated[
        bool, typer.Option("--collisions", help="Only two trains in one section count as wrong.")
    ] = False,
    states: Annotated[
        int, typer.Option("--states", min=1, help="Look at no more states than about so many.")
    ] = (200_000_000),
    out: Annotated[Path | None, typer.Option("--out", help="Where the certificate is written.")] = None,
    chart: Annotated[
        Path | None, typer.Option("--chart", help="Where the story is drawn, as a sequence chart in Mermaid.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Explore a line of two trains, a manager and two terminals whole: is it safe, and can all always still finish?"""
    from verify.certificate import write
    from verify.explore import certificate_of, explored
    from verify.restored import RESTORED, restored

    names = restore or []
    if names == ["list"]:
        end_with({"restore": sorted(RESTORED)}, sorted(RESTORED), good=True, as_json=as_json)
    _known(names, sorted(RESTORED))
    began_s = time.process_time()
    with restored(*names):
        found = explored(_line(config), states, _watch, collisions_alone=collisions)
    took_s = max(time.process_time() - began_s, 1e-3)
    count, space = len(found.space.states), found.space
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
        *_verdict(found.broken, found.dead, complete=space.complete),
        *(f"  {index}. {line}" for index, line in enumerate(found.story, start=1)),
    ]
    if chart is not None and found.chart:
        chart.write_text(f"```mermaid\n{found.chart}```\n", "utf-8")
        lines.append(f"chart: {chart}")
    if out is not None and found.holds and not names:
        digest = write(out, certificate_of(found))
        figures |= {"certificate": str(out), "digest": digest}
        lines.append(f"certificate: {out}, {out.stat().st_size / _MEGABYTE:.1f} MB, digest {digest}")
    good = not found.broken and not found.dead and space.complete
    end_with(figures, lines, good=good, as_json=as_json)


@verify.command()
def recount(
    file: Annotated[Path, typer.Argument(help="A certificate, as 'verify explore --out' writes it.")],
    processes: Annotated[int, typer.Option("--processes", min=1, help="Side by side.")] = 2,
    as_json: Json = False,
) -> None:
    """Recount a certificate by itself: every step made anew, every successor of every state, every rank."""
    from network.errors import InputError
    from verify.certificate import read
    from verify.recount import recount as recounted

    if not file.is_file():
        raise InputError(str(file), "", None, "a certificate")
    found = recounted(read(file), lambda count: print_aside(f"{count} states"), processes=processes)
    figures = {
        "refused": found.refused,
        "states": found.states,
        "successors": found.successors,
        "finished": found.finished,
        "rank_max": found.rank_max,
    }
    lines = [
        f"refused: {found.refused}"
        if found.refused
        else f"it holds: {found.states} states, {found.successors} successors all among them, none unsafe;"
        f" all trains can finish from each in at most {found.rank_max} steps"
    ]
    end_with(figures, lines, good=not found.refused, as_json=as_json)


@verify.command()
def promela(
    out: Annotated[Path, typer.Option("--out", help="Where the model is written.")] = Path("line.pml"),
    as_json: Json = False,
) -> None:
    """Write the line without troubles as a model in Promela, for SPIN: spin -a; cc -DNOREDUCE -DSAFETY; pan -E."""
    from verify.explored_line import ExploredLine
    from verify.promela import model, walked

    composition, states = walked(ExploredLine())
    out.write_text(model(composition), "utf-8")
    figures = {"model": str(out), "states": len(states)}
    end_with(
        figures, [f"{out}: a model of {len(states)} states, by our own count"], good=True, as_json=as_json
    )


def _verdict(broken: str, dead: int, *, complete: bool) -> list[str]:
    if broken:
        return [f"broken: {broken}; the shortest way to it:"]
    if dead:
        return [f"safe, but from {dead} states not all trains can finish; the shortest way to one:"]
    if complete:
        return ["all of them are safe, and from each all trains can still finish"]
    return ["safe as far as was looked; not all states were"]


def _watch(level: Level) -> None:
    if level.depth % _TOLD_EVERY == 0:
        print_aside(f"level {level.depth}: {level.distinct} states, {level.generated} generated")


def _known(names: list[str], known: list[str]) -> None:
    from network.errors import InputError

    for name in names:
        if name not in known:
            raise InputError("--restore", "", name, f"one of {', '.join(known)}")


def _line(config: str) -> ExploredLine:
    from network.errors import InputError
    from verify.explored_line import ANY, Budgets, ExploredLine

    numbers = [str(ANY) if part == "any" else part for part in config.split("/")]
    if not 1 <= len(numbers) <= len(Budgets._fields) or not all(n.isdecimal() for n in numbers):
        raise InputError("CONFIG", "", config, f"up to {len(Budgets._fields)} numbers, as in 1/1/0/0")
    return ExploredLine(budgets=Budgets(*map(int, numbers)))
