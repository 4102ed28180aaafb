"""A scenario of one's own, by what it has besides another."""

from pathlib import Path

from scenario.scenario import Scenario, load_scenario


def own_scenario(folder: Path, text: str, base: str) -> Scenario:
    """What `base` is, with this text."""
    file = folder / "own.toml"
    file.write_text(f'extends = "{base}"\nid = "own"\nname = "own"\n{text}', "utf-8")
    return load_scenario(str(file))
