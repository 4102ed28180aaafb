"""docs/faults.md is what the table of faults writes."""

from pathlib import Path

from documents.faults import document
from simulation.faults.table import KINDS

ROOT = Path(__file__).resolve().parents[2]


def test_the_document_is_what_the_code_writes() -> None:
    assert (ROOT / "docs/faults.md").read_text(encoding="utf-8") == document(), "run `make docs`"


def test_every_fault_has_its_row() -> None:
    rows = [line.split("|")[1].strip() for line in document().splitlines() if line.startswith("| `")]
    assert rows == [f"`{kind.kind}`" for kind in KINDS]
