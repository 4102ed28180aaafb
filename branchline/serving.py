"""`branchline serve`: a line that runs, with seats in the browser."""

from __future__ import annotations

import socket
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

PORT: Final = 8580


def serve(
    name: Annotated[str, typer.Argument(help="A scenario or a drill: shipped, or a file (.toml).")],
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
    """Run a line in real time for training: an instructor makes faults, a dispatcher and staff work the line."""
    with needing_extra("console", "serve"):
        import uvicorn

        from console.access import LOOPBACK, on_loopback, with_tokens, write_tokens
        from console.live import LiveDesk
        from console.protocol import MESSAGE_BYTES_MAX
        from console.server import DeskServer

    from scenario.scenario import load_scenario
    from study.drilling.drill import find_drill, shipped_drills

    if (listen is None) is not (tokens is None):
        raise InputError(COMMAND_LINE, "--tokens", tokens, "a new file with --listen, and only then")
    scenario = load_scenario(find_drill(name) if name in shipped_drills() else name, seed)
    with bound_socket(listen or LOOPBACK, port) as bound:
        host, at = bound.getsockname()[:2]
        rules = on_loopback(at) if tokens is None else with_tokens()
        if tokens is not None:
            write_tokens(rules, tokens)
        server = DeskServer(rules)
        live = LiveDesk(scenario, server.changed)
        live.start()
        server.desk = live
        _tell(f"http://{host}:{at}/", rules, tokens)
        if open_page:
            webbrowser.open(f"http://{host}:{at}/?seat=instructor")
        config = uvicorn.Config(
            server.app, log_level="warning", ws="websockets-sansio", ws_max_size=MESSAGE_BYTES_MAX
        )
        try:
            uvicorn.Server(config).run(sockets=[bound])
        finally:
            live.stop()


def bound_socket(host: str, port: int) -> socket.socket:
    """A socket on an address. InputError where that cannot be had."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((host, port))
    except OSError as error:
        bound.close()
        expected = f"an address and port of this machine that are free: {error.strerror}"
        raise InputError(COMMAND_LINE, "--port", f"{host}:{port}", expected) from error
    return bound


def _tell(address: str, rules: AccessRules, tokens: Path | None) -> None:
    sys.stdout.write(f"{address}\n")
    if rules.tokens is not None:
        sys.stdout.write(f"  the token of each seat is in {tokens}: {address}?seat=SEAT#TOKEN\n")
    sys.stdout.flush()
