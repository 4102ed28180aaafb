"""Nets by netconvert: faithful, the same every time, and the shipped ones up to date."""

import gzip
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from numpy.typing import NDArray

from network.code_store import CodeStore
from network.errors import InputError
from network.files.line_file import load_line, parse_line
from network.files.shipped import shipped_line, shipped_names
from network.model import Alignment, Line
from sumo_cfg import build
from sumo_cfg.truth_map import read_net
from sumo_cfg.writer import PlainXml, movements, write_plain

pytest.importorskip("sumo", reason="netconvert comes with the extra `net`")
Array = NDArray[np.float64]
LINE_FILES = [shipped_line(name) for name in shipped_names("lines")]


def content(path: Path) -> bytes:
    return gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()


def shape_of(text: str) -> Array:
    # SUMO leaves out an elevation of zero.
    return np.array([[*map(float, point.split(",")), 0.0][:3] for point in text.split()])


@pytest.fixture(scope="module")
def plain(line: Line, positions: Callable[..., Array]) -> PlainXml:
    return write_plain(line, positions)


@pytest.fixture(scope="module")
def net(plain: PlainXml) -> bytes:
    return build.convert(plain, "hand")


def test_net_keeps_lengths_shapes_and_connections(line: Line, plain: PlainXml, net: bytes) -> None:
    root = ET.fromstring(net)
    wanted = {e.attrib["id"]: shape_of(e.attrib["shape"]) for e in ET.fromstring(plain.edges)}
    lanes = {e.attrib["id"]: e.find("lane") for e in root.iterfind("edge")}
    assert set(lanes) == set(wanted)
    for edge_id, lane in lanes.items():
        assert lane is not None
        piece = line.pieces[edge_id[:-1]]
        assert float(lane.attrib["length"]) == pytest.approx(piece.to_m - piece.from_m, abs=1e-6)
        # Neither cut at the junctions nor shifted nor thinned out.
        assert shape_of(lane.attrib["shape"]) == pytest.approx(wanted[edge_id], abs=1e-6)
    assert {(c.attrib["from"], c.attrib["to"]) for c in root.iterfind("connection")} == set(movements(line))
    assert all(
        e.get("bidi") == e.attrib["id"][:-1] + "+-"["+" in e.attrib["id"]] for e in root.iterfind("edge")
    )


def test_net_says_nothing_of_date_or_place_and_repeats(plain: PlainXml, net: bytes) -> None:
    assert build.convert(plain, "hand") == net
    assert net.count(b"<!--") == 1
    assert plain.digest.encode() in net
    assert b"generated" not in net
    assert b".nod.xml" not in net


def test_a_refused_line_is_one_clear_error(plain: PlainXml) -> None:
    broken = PlainXml(plain.nodes, plain.edges.replace(b'from="w"', b'from="nowhere"'), plain.connections)
    with pytest.raises(InputError, match=r"^line hand: net is .*nowhere.*netconvert accepts$"):
        build.convert(broken, "hand")


def test_a_complaint_names_no_file_that_is_gone(plain: PlainXml) -> None:
    for broken in (
        PlainXml(b"<nodes><node", plain.edges, plain.connections),
        PlainXml(plain.nodes, b"<edges><edge", plain.connections),
        PlainXml(plain.nodes, plain.edges, b"<connections><connection"),
    ):
        with pytest.raises(InputError, match="netconvert accepts") as refused:
            build.convert(broken, "hand")
        assert ".xml" not in str(refused.value)
        assert re.search("the (nodes|edges|connections)", str(refused.value))


def test_a_changed_line_is_built_once_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed_line: Line
) -> None:
    path = build.net_for(changed_line, tmp_path / "nets")
    assert list((tmp_path / "nets").iterdir()) == [path]
    assert build.net_digest(path) == write_plain(changed_line).digest
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    assert build.net_for(changed_line, tmp_path / "nets") == path
    with pytest.raises(InputError, match=r"pip install 'branchline\[net\]'"):
        build.net_for(changed_line, tmp_path / "empty")
    assert not (tmp_path / "empty").exists()


def test_a_damaged_net_in_the_cache_is_built_again(tmp_path: Path, changed_line: Line) -> None:
    path = build.net_for(changed_line, tmp_path)
    whole = path.read_bytes()
    path.write_bytes(b"<net/>")
    assert build.net_for(changed_line, tmp_path).read_bytes() == whole


def test_a_net_is_made_once_and_given_to_no_other_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: Line, with_gradient: Callable[[Line, float], Line]
) -> None:
    monkeypatch.setattr(build, "convert", made := Mock(wraps=build.convert))
    monkeypatch.setattr(build, "NETS", CodeStore(tmp_path / "kept"))
    lines = [with_gradient(line, permille) for permille in (7.0, 8.0)]
    assert {changed.id for changed in lines} == {line.id}
    for folder in ("one", "two"):
        for changed in lines:
            net = build.net_for(changed, tmp_path / folder)
            assert build.net_digest(net) == write_plain(changed).digest
    assert [call.args[0] for call in made.mock_calls] == [write_plain(changed) for changed in lines]


@pytest.fixture
def changed_line(line: Line, with_gradient: Callable[[Line, float], Line]) -> Line:
    return with_gradient(line, 12.0)


@pytest.mark.parametrize("file", LINE_FILES, ids=lambda file: file.stem)
def test_shipped_net_is_the_one_the_line_file_gives(file: Path, tmp_path: Path) -> None:
    line = load_line(file)
    shipped = build.shipped_net(line.id)
    assert content(shipped) == build.build_net(line), "run: python -m sumo_cfg.build"
    assert build.net_for(line, tmp_path) == shipped
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("file", LINE_FILES, ids=lambda file: file.stem)
def test_shipped_net_follows_the_line(file: Path, elevation: Callable[[Alignment, float], float]) -> None:
    line = load_line(file)
    net = build.shipped_net(line.id)
    edges = read_net(net).edges
    assert len(edges) == 2 * len(line.pieces)
    for edge in ET.fromstring(content(net)).iterfind("edge"):
        piece = line.pieces[edges[edge.attrib["id"]].piece_id]
        lane = edge.find("lane")
        assert lane is not None
        assert edges[edge.attrib["id"]].section_id == piece.section_id
        assert float(lane.attrib["length"]) == pytest.approx(piece.to_m - piece.from_m, abs=1e-6)
        shape = shape_of(lane.attrib["shape"])
        shape = shape if edge.attrib["id"].endswith("+") else shape[::-1]
        alignment = line.alignments[piece.alignment_id]
        # Distance along the polyline, scaled to the piece as SUMO does, against the gradient table.
        run_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(shape[:, :2], axis=0).T))))
        at_m = piece.from_m + run_m * piece.length_m / run_m[-1]
        wanted = [elevation(alignment, float(m)) for m in at_m]
        steepest = max((abs(g.permille) for g in alignment.gradients), default=0.0) / 1000.0
        # In a curve a track with an offset is shorter than its kilometrage: places along it are not exact.
        assert shape[:, 2] == pytest.approx(
            wanted,
            abs=2e-3 + steepest * (abs(piece.length_m - run_m[-1]) + 0.02 * min(1.0, piece.length_m / 100.0)),
        )


@pytest.mark.parametrize("fixed", [True, False])
def test_a_line_as_steep_as_a_file_may_say(
    fixed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """netconvert smooths what is steeper than a tenth, unless it is told not to; then no edge has its way back."""
    text = shipped_line("rtri_test_line").read_text("utf-8")
    steep = text.replace("permille = 0.0", "permille = 150.0").replace(
        "curves = []",
        "curves = [{ from_km = 0.55, to_km = 0.85, radius_m = 400, transition_m = 40, cant_mm = 60 }]",
    )
    if not fixed:
        kept = [word for word in build.NETCONVERT_OPTIONS if word != "--geometry.max-grade.fix"]
        kept.remove("false")
        monkeypatch.setattr(build, "NETCONVERT_OPTIONS", tuple(kept))
    net = tmp_path / "steep.net.xml"
    net.write_bytes(build.convert(write_plain(parse_line(steep, "steep.toml")), "steep"))
    if fixed:
        assert all(edge.bidi_edge_id for edge in read_net(net).edges.values())
    else:
        with pytest.raises(InputError, match="a bidi edge"):
            read_net(net)
