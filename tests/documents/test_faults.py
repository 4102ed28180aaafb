"""What docs/faults.md has of each fault; that it is what is written, `make check` compares."""

from documents.faults import document
from simulation.faults.table import KINDS


def test_every_fault_has_its_row() -> None:
    rows = [line.split("|")[1].strip() for line in document().splitlines() if line.startswith("| `")]
    assert rows == [f"`{kind.kind}`" for kind in KINDS]
