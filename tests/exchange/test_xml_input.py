"""XML of others: within limits, without entities, and one message for each damage."""

import gzip
from pathlib import Path

import pytest

from exchange import xml_input
from exchange.xml_input import local_name, namespace_of, number, read_xml
from network.errors import InputError

BOMB = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]>
<osm>&c;</osm>
"""
OUTER = """<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY e SYSTEM "file:///etc/hostname">]><osm>&e;</osm>"""


def written(tmp_path: Path, content: str | bytes, name: str = "a.xml") -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refused(path: Path) -> str:
    with pytest.raises(InputError) as refusal:
        read_xml(path)
    text = str(refusal.value)
    assert text.startswith(str(path))
    assert "\n" not in text
    return text


@pytest.mark.parametrize("content", [BOMB, OUTER], ids=["entities that grow", "an outer file"])
def test_a_document_type_is_refused(tmp_path: Path, content: str) -> None:
    assert "document type" in refused(written(tmp_path, content))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "empty"),
        ("\n  \n", "empty"),
        ("<a><b></a>", "line 1"),
        ("<a>\n<b>", "line 2"),
        ("no xml at all", "valid XML"),
        (b"\x00\x01\x02\x03", "valid XML"),
        (b'<?xml version="1.0" encoding="no-such"?><a/>', "encoding"),
        (b"<a>\xff\xfe\xfd</a>", "valid XML"),
        (gzip.compress(b"<a>" + b"<b/>" * 100 + b"</a>", mtime=0)[:-8], "cut off"),
        (b"\x1f\x8bnot gzip at all, for all its mark", "gzip"),
    ],
)
def test_a_damaged_file_gets_one_line(tmp_path: Path, content: str | bytes, said: str) -> None:
    assert said in refused(written(tmp_path, content))


def test_what_is_no_file_is_said(tmp_path: Path) -> None:
    assert "readable file" in refused(tmp_path / "missing.xml")
    assert "readable file" in refused(tmp_path)


def test_depth_count_and_size_have_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    deep = xml_input.DEPTH_MAX
    assert read_xml(written(tmp_path, "<a>" * deep + "</a>" * deep)).tag == "a"
    assert "in one another" in refused(written(tmp_path, "<a>" * (deep + 1) + "</a>" * (deep + 1)))
    monkeypatch.setattr(xml_input, "ELEMENTS_MAX", 10)
    assert len(read_xml(written(tmp_path, "<a>" + "<b/>" * 9 + "</a>"))) == 9
    assert "elements" in refused(written(tmp_path, "<a>" + "<b/>" * 10 + "</a>"))
    monkeypatch.setattr(xml_input, "XML_BYTES_MAX", 1 << 20)
    much = b"<a>" + b" " * (1 << 20) + b"</a>"
    assert "at most 1 MiB" in refused(written(tmp_path, much))
    assert "at most 1 MiB" in refused(written(tmp_path, gzip.compress(much), "a.xml.gz"))


def test_a_gzipped_file_and_another_encoding_are_read(tmp_path: Path) -> None:
    text = '<?xml version="1.0" encoding="ISO-8859-1"?><a xmlns="urn:x" n="Bahnhöfe"/>'
    root = read_xml(written(tmp_path, gzip.compress(text.encode("latin-1")), "a.gz"))
    assert (local_name(root), namespace_of(root), root.get("n")) == ("a", "urn:x", "Bahnhöfe")


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "1e999", "twelve"])
def test_a_number_is_finite(tmp_path: Path, text: str) -> None:
    root = read_xml(written(tmp_path, f'<a id="i" n="{text}" m=""/>'))
    with pytest.raises(InputError, match="a i: n"):
        number("f", root, "n")
    assert number("f", root, "m") is None
