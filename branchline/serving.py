"""`branchline serve`: a line that runs, with seats in the browser."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from branchline.extras import needing_extra
from branchline.options import Seed
from network.errors import COMMAND_LINE, InputError

if TYPE_CHECKING:
    from console.access import AccessRules
    from console.live import LiveDesk
    from scenario.scenario import Scenario
    from study.record.read_back import RunRead

PORT: Final = 8580


def serve(
    name: Annotated[
        str | None,
        typer.Argument(
            help="A scenario or a drill: shipped, or a file (.toml); or the directory of a finished run, to look"
            " at again. Left out: the page has all that are shipped, and the runs in `runs`, to choose from."
        ),
    ] = None,
    beside: Annotated[
        Path | None,
        typer.Option("--beside", help="Directory of another finished run, to look at both side by side."),
    ] = None,
    seed: Seed = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65_535, help="0: any that is free.")] = PORT,
    listen: Annotated[
        str | None,
        typer.Option(
            "--listen", help="Address on which other machines may connect, each seat by its token (--tokens)."
        ),
    ] = None,
    tokens: Annotated[
        Path | None,
        typer.Option("--tokens", help="New file, readable by its owner alone, for the tokens of the seats."),
    ] = None,
    open_page: Annotated[bool, typer.Option("--open", help="Open the instructor's page.")] = False,
) -> None:
    """Run a line in real time for training, with seats in the browser to break and work it; or open a run."""
    with needing_extra("console", "serve"):
        import uvicorn

        from console.access import LOOPBACK, on_loopback, with_tokens, write_tokens
        from console.library import LibraryRequest, opened, taken_from_library
        from console.live import LiveDesk
        from console.protocol import MESSAGE_BYTES_MAX
        from console.server import DeskServer, listening_on
        from study.record.read_back import RunRead

    _check_together(name, seed, listen, tokens)
    first = None if name is None else opened(name, seed)
    other = None if beside is None else opened(str(beside))
    if other is not None and not (isinstance(first, RunRead) and isinstance(other, RunRead)):
        raise InputError(
            COMMAND_LINE, "--beside", str(beside), "the directory of a finished run, beside that of another"
        )
    with listening_on(listen or LOOPBACK, port) as bound:
        host, at = bound.getsockname()[:2]
        rules = on_loopback(at) if tokens is None else with_tokens()
        if tokens is not None:
            write_tokens(rules, tokens)
        server = DeskServer(rules)
        web = uvicorn.Server(
            uvicorn.Config(
                server.app, log_level="warning", ws="websockets-sansio", ws_max_size=MESSAGE_BYTES_MAX
            )
        )
        desks: list[LiveDesk] = []

        def changed() -> None:
            server.changed()
            web.should_exit = web.should_exit or any(desk.error is not None for desk in desks)

        def begin(what: Scenario | RunRead) -> LiveDesk:
            desk = LiveDesk(what, changed)
            desk.start()
            desks.append(desk)
            return desk

        def open_from_library(asked: LibraryRequest) -> LiveDesk:
            what = taken_from_library(asked)
            while desks:
                desks.pop().stop()
            return begin(what)

        if first is None:
            server.opens = open_from_library
        else:
            server.desk = begin(first)
        server.beside = None if other is None else begin(other)
        page = "beside.html" if other is not None else ""
        _tell(f"http://{host}:{at}/{page}", rules, tokens)
        if open_page:
            seat = "?seat=instructor" if first is not None and not page else ""
            webbrowser.open(f"http://{host}:{at}/{page}{seat}")
        try:
            web.run(sockets=[bound])
        finally:
            _stop(desks)


def _check_together(name: str | None, seed: int | None, listen: str | None, tokens: Path | None) -> None:
    if (listen is None) is not (tokens is None):
        raise InputError(COMMAND_LINE, "--tokens", tokens, "a new file with --listen, and only then")
    if seed is not None and (name is None or Path(name).is_dir()):
        raise InputError(COMMAND_LINE, "--seed", seed, "the name of a scenario or a drill with it")


def _stop(desks: list[LiveDesk]) -> None:
    """End all runs; raises what has broken one off."""
    for desk in desks:
        desk.stop()
    for desk in desks:
        if desk.error is not None:
            raise desk.error


def _tell(address: str, rules: AccessRules, tokens: Path | None) -> None:
    sys.stdout.write(f"{address}\n")
    if rules.tokens is not None:
        sys.stdout.write(f"  the token of each seat is in {tokens}: {address}?seat=SEAT#TOKEN\n")
    sys.stdout.flush()
