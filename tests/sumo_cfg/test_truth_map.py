"""The checkers' map: read from a net written out by hand here, so that nothing of the writer is trusted."""

import gzip
from pathlib import Path

import pytest

from network.errors import InputError
from sumo_cfg.truth_map import NetMap, read_net

LENGTHS_M = {"a": ("platform", 200.0), "b": ("points", 30.0), "c": ("points", 20.0), "d": ("line", 1000.0)}


def net_text() -> str:
    edges = "".join(
        f'<edge id="{piece}{sign}" bidi="{piece}{other}"><lane id="{piece}{sign}_0" length="{length_m}"/>'
        f'<param key="piece" value="{piece}"/><param key="section" value="{section}"/></edge>'
        for piece, (section, length_m) in LENGTHS_M.items()
        for sign, other in ("+-", "-+")
    )
    ways = [("a+", "b+"), ("b+", "c+"), ("c+", "d+"), ("d-", "c-"), ("c-", "b-"), ("b-", "a-"), ("a+", "a-")]
    connections = "".join(f'<connection from="{a}" to="{b}"/>' for a, b in ways)
    return f"<net>{edges}{connections}</net>"


@pytest.fixture
def net_map(tmp_path: Path) -> NetMap:
    path = tmp_path / "x.net.xml"
    path.write_text(net_text())
    return read_net(path)


def test_edges_know_section_piece_length_and_neighbours(net_map: NetMap) -> None:
    assert set(net_map.edges) == {"a+", "a-", "b+", "b-", "c+", "c-", "d+", "d-"}
    edge = net_map.edges["b-"]
    assert (edge.piece_id, edge.section_id, edge.length_m) == ("b", "points", 30.0)
    assert (edge.bidi_edge_id, edge.next_edge_ids) == ("b+", ("a-",))
    assert net_map.edges["a+"].next_edge_ids == ("b+",)


def test_a_compressed_net_reads_the_same(net_map: NetMap, tmp_path: Path) -> None:
    path = tmp_path / "x.net.xml.gz"
    path.write_bytes(gzip.compress(net_text().encode()))
    assert read_net(path) == net_map


@pytest.mark.parametrize(
    ("path", "front_m", "length_m", "sections"),
    [
        (("a+",), 150.0, 40.0, ("platform",)),
        (("a+", "b+"), 10.0, 10.0, ("points",)),
        (("a+", "b+"), 10.0, 10.001, ("points", "platform")),
        (("a+", "b+", "c+", "d+"), 5.0, 55.0, ("line", "points")),
        (("a+", "b+", "c+", "d+"), 5.0, 56.0, ("line", "points", "platform")),
        # A train that enters the net: its rear is outside.
        (("d-",), 5.0, 40.0, ("line",)),
        # After a reversal over the points: it lies on the way back, not on the way it came.
        (("a+", "b+", "b-", "a-"), 15.0, 20.0, ("platform", "points")),
    ],
)
def test_sections_under_a_train(
    net_map: NetMap, path: tuple[str, ...], front_m: float, length_m: float, sections: tuple[str, ...]
) -> None:
    assert net_map.sections_under(path, front_m, length_m) == sections


def test_a_train_without_an_edge_is_an_error(net_map: NetMap) -> None:
    with pytest.raises(ValueError, match="stands on an edge"):
        net_map.sections_under((), 0.0, 40.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("not xml", "a SUMO net"),
        ("<net/>", "with edges"),
        ('<net><edge id="x"><lane id="x_0" length="1"/></edge></net>', "edge x.*piece and section"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "other.net.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_net(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.net\.xml"):
        read_net(tmp_path / "none.net.xml")
