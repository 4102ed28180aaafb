"""A certificate: every state of an explored line, in order, each with its rank to finishing, in a file to be recounted.

The file names the steps that were made, in their order, so that who makes them again has the same numbers; the parts of
states (ground, cells) by these numbers; the states by their parts, sorted; and digests of the local states and of the
sources of the steps. `verify.recount` checks it and shares nothing with the search.
"""

from __future__ import annotations

from hashlib import blake2b
from pathlib import Path
from typing import Any, Final

import msgspec

from network.errors import InputError
from network.files.json_input import write_bytes_aside
from verify.explored_line import Budgets, ExploredLine

FORMAT: Final = 1
_DIGEST_BYTES: Final = 32
_ROOT: Final = Path(__file__).resolve().parent.parent
# packages whose sources decide the steps
STEPS: Final = ("onboard/authority", "onboard/duty", "radio", "wayside")
MODEL: Final = (
    "explored_line.py",
    "happening.py",
    "manager.py",
    "on_air.py",
    "parties.py",
    "terminal.py",
    "thirds.py",
    "tokens.py",
    "train.py",
    "train_events.py",
)


class Certificate(msgspec.Struct, frozen=True):
    """What is in the file. `states`: 8 bytes each, big-endian, sorted: ground, and the cell of each train, by index
    into the tables; `ranks`: 2 bytes each. `made`: steps by their kind and numbers.
    """

    format: int
    trains: int
    budgets: tuple[int, ...]
    sources: str
    locals: str
    bits: tuple[int, ...]  # of each part of a state
    made: tuple[tuple[Any, ...], ...]
    # manager and terminals, what is left of the budgets
    grounds: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    cells: tuple[tuple[tuple[int, tuple[tuple[int, ...], ...], int], ...], ...]
    states: bytes
    ranks: bytes

    @property
    def line(self) -> ExploredLine:
        """The line that it is about."""
        return ExploredLine(self.trains, Budgets(*self.budgets))


def sources_digest() -> str:
    """Of the sources of the steps, and of the parties around them."""
    code = blake2b(digest_size=16)
    files = [file for package in STEPS for file in sorted((_ROOT / package).glob("*.py"))]
    for file in (*files, *(_ROOT / "verify" / name for name in MODEL)):
        code.update(file.relative_to(_ROOT).as_posix().encode() + b"\0" + file.read_bytes())
    return code.hexdigest()


def write(file: Path, certificate: Certificate) -> str:
    """Write it, aside first; returns the digest of the whole file's contents."""
    body = msgspec.msgpack.encode(certificate)
    digest = blake2b(body, digest_size=_DIGEST_BYTES).digest()
    write_bytes_aside(file, digest + body)
    return digest.hex()


def read(file: Path) -> Certificate:
    """Read it. Raises InputError where the file is damaged or is none."""
    data = file.read_bytes()
    digest, body = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
    if blake2b(body, digest_size=_DIGEST_BYTES).digest() != digest:
        raise InputError(str(file), "", f"{len(data)} bytes", "a certificate, whole as it was written")
    try:
        return msgspec.msgpack.decode(body, type=Certificate)
    except msgspec.MsgspecError as error:
        raise InputError(str(file), "", f"{len(data)} bytes", f"a certificate ({error})") from None
