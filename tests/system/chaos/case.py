"""A case: a ground with faults, acts and the manner of its staff, and the files that it is written as."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from study.scenario.scenario import Scenario, load_scenario
from tests.system.chaos.draw import Draw
from tests.system.chaos.ground import Ground
from tests.system.chaos.toml_text import Table, toml_of


@dataclass(frozen=True, slots=True)
class Manner:
    """How long staff wait before they act, s."""

    seed: int
    power_s: float
    points_s: float
    picture_s: float
    silent_s: float

    @classmethod
    def drawn(cls, seed: int, draw: Draw) -> Manner:
        """Quick people and slow ones."""
        return cls(
            seed,
            power_s=draw.by_size(60.0, 240.0),
            points_s=draw.by_size(20.0, 120.0),
            picture_s=draw.by_size(15.0, 200.0),
            silent_s=draw.by_size(60.0, 300.0),
        )


@dataclass(frozen=True, slots=True)
class Case:
    """`head`: what differs from the ground's own; without staff the acts are all that people do."""

    name: str
    ground: Ground
    head: Table = field(default_factory=dict[str, object])
    faults: tuple[Table, ...] = ()
    acts: tuple[Table, ...] = ()
    staff: Manner | None = None

    @property
    def text(self) -> str:
        """The scenario file: a drill, where anything fails."""
        head = {**self.ground.head, **self.head, "id": self.name, "name": self.name}
        scripts = {"fault": list(self.faults), "act": list(self.acts)}
        return toml_of(head | {word: rows for word, rows in scripts.items() if rows})

    def write(self, folder: Path, says: str = "") -> Path:
        """Write it with all that it needs; returns the file of the scenario."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.ground.files.items():
            (folder / name).write_text(text, "utf-8")
        path = folder / f"{self.name}.toml"
        comment = "".join(f"# {line}\n" for line in says.splitlines())
        path.write_text(comment + self.text, "utf-8")
        return path

    def load(self, folder: Path) -> Scenario:
        """As the program itself reads it."""
        return load_scenario(str(self.write(folder)))
