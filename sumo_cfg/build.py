"""Nets for SUMO: the shipped ones, and those of changed lines, built by netconvert (extra `net`) and kept.

A net carries the digest of the plain XML it was made from, so that a net is never used
with another line. `python -m sumo_cfg.build` makes all shipped nets anew.
"""

from __future__ import annotations

import gzip
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Final

from network.code_store import CodeStore, kept_folder
from network.errors import InputError
from network.model import Line
from sumo_cfg.road_net import RoadAt, with_roads
from sumo_cfg.writer import PlainXml, write_plain

NETCONVERT_OPTIONS: Final = (
    # No internal lanes: a train leaves one edge and is on the next, lengths add up exactly.
    *("--no-internal-links", "true"),
    # Junctions without extent: they would cut the legs of points short and shift the shapes.
    *("--junctions.minimal-shape", "true"),
    *("--offset.disable-normalization", "true"),
    *("--precision", "6"),
    # Heights are the line file's: smoothed, an edge and its way back would no longer have one shape.
    *("--geometry.max-grade.fix", "false"),
    *("--xml-validation", "never"),
)
GZIP_ABOVE_BYTES: Final = 1_000_000

# What netconvert reads and writes in a folder that is gone when its complaint is read, and what that is called then.
_FILES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "n.nod.xml": "the nodes",
        "e.edg.xml": "the edges",
        "c.con.xml": "the connections",
        "o.net.xml": "the net",
    }
)

_DIGEST_COMMENT: Final = re.compile(rb"<!-- branchline plain XML blake2b ([0-9a-f]{32}) -->")
_COMMENT: Final = re.compile(rb"<!--.*?-->\s*", re.DOTALL)
_HEAD_BYTES: Final = 512
NETS: Final = CodeStore(kept_folder() / "nets")


def build_net(line: Line) -> bytes:
    """The net of a line as XML, the same bytes for the same line on any day and machine.

    Raises InputError when netconvert is not installed or refuses the line.
    """
    return convert(write_plain(line), line.id)


def convert(plain: PlainXml, line_id: str, scratch: Path | None = None) -> bytes:
    """Run netconvert on plain XML; `line_id` is for messages. Raises InputError as `build_net` does.

    It works in `scratch`; default: the folder for temporary files.
    """
    program = _netconvert(line_id)
    if scratch is not None:
        scratch.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="branchline-net-", dir=scratch) as name:
        folder = Path(name)
        nodes, edges, connections, net = _FILES
        (folder / nodes).write_bytes(plain.nodes)
        (folder / edges).write_bytes(plain.edges)
        (folder / connections).write_bytes(plain.connections)
        inputs = ("-n", nodes, "-e", edges, "-x", connections, "-o", net)
        run = subprocess.run(
            [str(program), *inputs, *NETCONVERT_OPTIONS],
            cwd=folder,
            env={**os.environ, "SUMO_HOME": str(program.parent.parent)},
            capture_output=True,
            text=True,
            check=False,
        )
        output = folder / net
        if run.returncode != 0 or not output.exists():
            complaint = _without_files(" ".join(run.stderr.split())) or f"exit code {run.returncode}"
            raise InputError(f"line {line_id}", "net", complaint, "a line that netconvert accepts")
        return _tidy(output.read_bytes(), plain.digest)


def net_for(line: Line, cache_dir: Path, roads: Sequence[RoadAt] = ()) -> Path:
    """A net that belongs to this very line: the shipped one, one built before, or a new one in `cache_dir`.

    With `roads` over its crossings it is never a shipped one; its track is the same.
    Raises InputError when the line differs from the shipped one and netconvert is not installed.
    """
    plain = with_roads(_plain_of(line), line, roads) if roads else _plain_of(line)
    shipped = shipped_net(line.id)
    if shipped is not None and net_digest(shipped) == plain.digest:
        return shipped
    cached = cache_dir / f"{line.id}-{plain.digest}.net.xml"
    if not (cached.exists() and net_digest(cached) == plain.digest):
        _write_aside(cached, _net_of(plain, line.id, cache_dir))
    return cached


@lru_cache(maxsize=16)
def _plain_of(line: Line) -> PlainXml:
    return write_plain(line)


def _net_of(plain: PlainXml, line_id: str, scratch: Path) -> bytes:
    """As `convert`, once for all runs on this machine, where there is netconvert."""
    program = _netconvert(line_id).stat()
    made_of = (plain.digest, Path(__file__).read_bytes(), program.st_size, program.st_mtime_ns)
    return NETS.made(line_id, made_of, lambda: convert(plain, line_id, scratch))


def net_digest(path: Path) -> str | None:
    """Digest of the plain XML a net was made from, hexadecimal; None for a net that is not ours."""
    with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
        found = _DIGEST_COMMENT.search(file.read(_HEAD_BYTES))
    return found[1].decode("ascii") if found else None


def write_net(folder: Path, line: Line) -> Path:
    """Build the net of a line into `folder`, compressed if large; returns its path."""
    content = build_net(line)
    plain_path, packed_path = folder / f"{line.id}.net.xml", folder / f"{line.id}.net.xml.gz"
    large = len(content) > GZIP_ABOVE_BYTES
    path, stale = (packed_path, plain_path) if large else (plain_path, packed_path)
    _write_aside(path, gzip.compress(content, mtime=0) if large else content)
    stale.unlink(missing_ok=True)
    return path


def shipped_net(line_id: str) -> Path | None:
    """The net shipped for a line; None where there is none."""
    folder = Path(str(resources.files("sumo_cfg"))) / "nets"
    for path in (folder / f"{line_id}.net.xml", folder / f"{line_id}.net.xml.gz"):
        if path.is_file():
            return path
    return None


def _netconvert(line_id: str) -> Path:
    spec = find_spec("sumo")
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        for name in ("netconvert", "netconvert.exe"):
            program = Path(folder) / "bin" / name
            if program.is_file():
                return program
    expected = "a line as shipped, or netconvert to build its net: pip install 'branchline[net]'"
    raise InputError(f"line {line_id}", "net", "not built yet", expected)


def _without_files(complaint: str) -> str:
    for name, called in _FILES.items():
        complaint = re.sub(rf"'?[^\s']*{re.escape(name)}'?", called, complaint)
    return complaint


def _tidy(net: bytes, digest: str) -> bytes:
    """The net with the digest in place of netconvert's comments, which hold the date and temporary names."""
    head, body = _COMMENT.sub(b"", net).split(b"?>", maxsplit=1)
    comment = f"<!-- branchline plain XML blake2b {digest} -->".encode("ascii")
    return head + b"?>\n" + comment + b"\n" + body.lstrip()


def _write_aside(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=path.name, delete=False) as file:
        file.write(content)
    # Temporary files are private; a net is for everyone who may read the folder.
    Path(file.name).chmod(0o644)
    Path(file.name).replace(path)


def main() -> None:
    """Make the nets of all shipped lines anew."""
    from network.files.line_file import load_line
    from network.files.shipped import shipped_line, shipped_names

    nets = Path(str(resources.files("sumo_cfg"))) / "nets"
    for name in shipped_names("lines"):
        path = write_net(nets, load_line(shipped_line(name)))
        sys.stdout.write(f"{path.name} {path.stat().st_size} bytes\n")


if __name__ == "__main__":
    main()
