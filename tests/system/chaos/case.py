"""A case: a ground with faults and acts, and the files that it is written as."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from scenario.scenario import Scenario, load_scenario
from tests.system.chaos.ground import Ground
from tests.system.chaos.toml_text import Table, toml_of


@dataclass(frozen=True, slots=True)
class Case:
    """`head`: what differs from the ground's own; where staff do not react, the acts are all that people do."""

    name: str
    ground: Ground
    head: Table = field(default_factory=dict[str, object])
    faults: tuple[Table, ...] = ()
    acts: tuple[Table, ...] = ()

    @property
    def staffed(self) -> bool:
        """Whether staff react."""
        return bool(self.head.get("people", {}).get("react"))

    def without_staff(self, acts: tuple[Table, ...]) -> Case:
        """The same case with these acts, and nobody who reacts."""
        people = {**self.head.get("people", {}), "react": False}
        return replace(self, head={**self.head, "people": people}, acts=acts)

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
