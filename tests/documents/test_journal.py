from documents.journal import document
from simulation.events import EVENTS


def row(word: str) -> str:
    return next(line for line in document().splitlines() if line.startswith(f"| `{word}` |"))


def test_every_event_has_its_row() -> None:
    rows = [line for line in document().splitlines() if line.startswith("| `")]
    assert [line.split("`")[1] for line in rows] == list(EVENTS)


def test_a_row_has_author_keys_types_units_and_meaning() -> None:
    assert "| unit |" in row("arrived")
    assert "`error_m`: number or null in m" in row("arrived")
    assert "beyond the mark" in row("arrived")
    assert '`position`: one of "normal", "reverse"' in row("points_locked")
    assert "`sections`: list of texts" in row("granted")
    assert "`other`: text, optional" in row("refused")
    assert "`by_crew`: yes or no, optional" in row("proven")
    assert "| unit, block manager, point terminal, level crossing |" in row("took_effect")
    assert "`arrives_s`: list of numbers in s" in row("sent")
