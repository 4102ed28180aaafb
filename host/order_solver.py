"""The solver of the manager's question of order: a process of its own, so that no device loads what it needs.

Asked and answered in lines of JSON; the answer follows from the question alone, as the solver counts its work. Where
the extra `plan` is not installed the process ends at once, and nothing is known from then on.
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
from contextlib import suppress
from functools import cache
from typing import Final

import msgspec

from wayside.order_question import OrderAnswer, OrderQuestion, without_solver

MODULE: Final = "plan.dispatching.asked"


class SolverProcess:
    """Started with the first question; a process that was forked from one that has asked starts its own."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = -1

    def __call__(self, question: OrderQuestion) -> OrderAnswer:
        """The answer of the process, or that there is none."""
        if self._owner != os.getpid():
            self._start()
        process = self._process
        if process is None or process.stdin is None or process.stdout is None:
            return without_solver(question)
        try:
            process.stdin.write(msgspec.json.encode(question) + b"\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except OSError:
            line = b""
        if not line:
            self.close()
            return without_solver(question)
        return msgspec.json.decode(line, type=OrderAnswer)

    def _start(self) -> None:
        self._owner = os.getpid()
        self._process = subprocess.Popen(
            [sys.executable, "-m", MODULE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        atexit.register(self.close)

    def close(self) -> None:
        """End the process: it ends with its input."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        process.wait()


@cache
def order_solver() -> SolverProcess:
    """The solver of this process."""
    return SolverProcess()
