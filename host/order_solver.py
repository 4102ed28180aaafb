"""The solver of the manager's question of order: a process of its own, so that no device loads what it needs.

Asked and answered in lines of JSON; the answer follows from the question alone, as the solver counts its work. So one
that was killed is started again and asked the same. Where it ends again, as where the extra `plan` is not installed,
nothing is known from then on; where it hangs, or answers what is no answer, the run cannot go on: no order may depend
on how long somebody waited.
"""

from __future__ import annotations

import atexit
import os
import select
import subprocess
import sys
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from typing import Final

import msgspec

from host.parties import PartyError
from host.patience import Patience
from wayside.order_question import OrderAnswer, OrderQuestion, without_solver

MODULE = "plan.dispatching.asked"
STARTS = 2  # of a process for one question
HANGS_S = 60.0  # assumed: two hundred times what a question takes
LOOKS_S = 1.0
_PIECE_BYTES: Final = 512  # POSIX: a pipe that can be written to takes as many at once


class SolverProcess:
    """Started with the first question; a process that was forked from one that has asked starts its own."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = -1
        self._lost = False

    def __call__(self, question: OrderQuestion) -> OrderAnswer:
        """The answer of the process, or that there is none. PartyError where it hangs or answers nonsense."""
        if find_spec("ortools") is None:
            return without_solver(question)
        if self._owner != os.getpid():
            self._owner, self._process, self._lost = os.getpid(), None, False
            atexit.register(self.close)
        for _ in range(0 if self._lost else STARTS):
            if self._process is None:
                self._process = started()
            if line := _asked(self._process, msgspec.json.encode(question) + b"\n"):
                return _answer(line)
            self.close()
        self._lost = True
        return OrderAnswer(lacking="the solver has ended without an answer")

    def close(self) -> None:
        """End the process, be it stopped; it has nothing to keep."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        process.wait()


def started() -> subprocess.Popen[bytes]:
    """A new process."""
    return subprocess.Popen(
        [sys.executable, "-m", MODULE],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def _asked(process: subprocess.Popen[bytes], data: bytes) -> bytes:
    """A line there and one back; empty: the process has ended. PartyError if it hangs."""
    if process.stdin is None or process.stdout is None:
        return b""
    to, back = process.stdin.fileno(), process.stdout.fileno()
    patience, line = Patience(HANGS_S, gap_s_max=2.0 * LOOKS_S), b""
    while not line.endswith(b"\n"):
        readable, writable, _ = select.select([back], [to] if data else [], [], LOOKS_S)
        try:
            if writable:
                data = data[os.write(to, data[:_PIECE_BYTES]) :]
            piece = os.read(back, 1 << 16) if readable else b""
        except OSError:
            return b""
        if readable and not piece:
            return b""
        line += piece
        if not readable and not writable and patience.is_over():
            raise PartyError(f"the solver of the order of trains hangs for {HANGS_S:g} s")
    return line


def _answer(line: bytes) -> OrderAnswer:
    try:
        return msgspec.json.decode(line, type=OrderAnswer)
    except msgspec.MsgspecError as error:
        raise PartyError(f"the solver of the order of trains answers what is no answer: {error}") from error


@cache
def order_solver() -> SolverProcess:
    """The solver of this process."""
    return SolverProcess()
