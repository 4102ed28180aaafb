from __future__ import annotations

from pathlib import Path

from vehicle.compiled import sources_digest
from vehicle.records import PLANT, TRAIN
from vehicle.rows import PlantRow, TrainRow


def test_the_types_name_every_field_of_the_records() -> None:
    for protocol, record in ((TrainRow, TRAIN), (PlantRow, PLANT)):
        assert tuple(protocol.__annotations__) == record.names
        for name, annotation in protocol.__annotations__.items():
            kind = record[name]
            scalar = "int" if kind.base.kind == "i" else "float"
            assert annotation == (f"list[{scalar}]" if kind.shape else scalar), name


def test_the_cache_moves_when_compiled_code_changes_and_only_then(tmp_path: Path) -> None:
    package = tmp_path / "vehicle"
    package.mkdir()
    (package / "law.py").write_text("@compiled\ndef f(): ...\n")
    (package / "plain.py").write_text("A = 1\n")
    first = sources_digest(tmp_path)
    (package / "plain.py").write_text("A = 2\n")
    assert sources_digest(tmp_path) == first
    (package / "law.py").write_text("@compiled\ndef f(): return 1\n")
    assert sources_digest(tmp_path) != first
