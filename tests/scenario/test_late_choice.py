"""What `[late]` names must be there: one message each, with file, key and what was expected."""

from pathlib import Path

import pytest

from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from tests.scenario.own import own_scenario

FIXED = 'seconds = { distribution = "fixed", mean_s = 60.0 }\nsource = "made for tests"\n'


def loaded(folder: Path, text: str) -> Scenario:
    return own_scenario(folder, text, "karasuyama_weekday")


def failures(text: str, of: str = FIXED) -> str:
    return f"[late.failures.it]\n{text}\n{of}"


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (f'[late.entry.a]\nportals = ["OGN.1"]\n{FIXED}', "late.entry.a.portals[0]", "a portal"),
        (f"[late.dwell.a]\nstations = {{ ABC = 2.0 }}\n{FIXED}", "late.dwell.a.stations.ABC", "a station id"),
        (f"[late.dwell.a]\nshare = 1.5\n{FIXED}", "late.dwell.a.share", "0 to 1"),
        ('[late.doors.a]\nshare = 0.1\nsource = "t"', "late.doors.a.seconds", "missing"),
        ("[late.doors.a]\n" + FIXED.partition("source")[0] + "share = 0.1", "late.doors.a.source", "missing"),
        (
            f"[late.dead_zones.a]\nper_day = 1.0\nlength_low_m = 9.0\nlength_high_m = 3.0\n{FIXED}",
            "late.dead_zones.a.length_high_m",
            "at least length_low_m = 9",
        ),
        (failures('kind = "stuck"\nmtbf_h = 0.0'), "late.failures.it.mtbf_h", "hours between failures"),
        (failures('kind = "stuck"\nmtbf_h = nan'), "late.failures.it.mtbf_h", "number"),
        (f"[late.dwell.a]\nshare = -0.1\n{FIXED}", "late.dwell.a.share", "0 to 1"),
        (f"[late.dwell.a]\nshares = 0.1\n{FIXED}", "late.dwell.a.shares", "no such key"),
        (
            '[late.entry.a]\nseconds = { distribution = "fixed", mean_s = -1.0 }\nsource = "t"',
            "late.entry.a.seconds.mean_s",
            "s (",
        ),
        (f"[late.entry.a]\n{FIXED}".replace("made for tests", ""), "late.entry.a.source", "at least 1"),
        (failures('kind = "stucc"\nmtbf_h = 9.0'), "late.failures.it.kind", "stuck"),
        (failures('kind = "cut"\nmtbf_h = 9.0'), "late.failures.it.kind", "not at a link"),
        (
            failures('kind = "false_claims"\nsection = "X"\nmtbf_h = 9.0'),
            "late.failures.it.section",
            "a section",
        ),
        (
            failures('kind = "charger_dead"\nmtbf_h = 9.0'),
            "late.failures.it.kind",
            "a kind with a target",
        ),
        (
            failures('kind = "stuck"\ntargets = ["OGN.99"]\nmtbf_h = 9.0'),
            "late.failures.it.targets[0]",
            "OGN.11",
        ),
        (failures('kind = "stuck"\nmtbf_h = 9.0\nmtbf_km = 9.0'), "late.failures.it", "one of mtbf_h"),
        (failures('kind = "stuck"'), "late.failures.it", "one of mtbf_h"),
        (failures('kind = "stuck"\nmtbf_km = 9.0'), "late.failures.it.mtbf_km", "only units"),
        (
            failures('kind = "doors"\nmtbf_operations = 9.0'),
            "late.failures.it.mtbf_operations",
            "only points",
        ),
        (failures('kind = "restart"\nmtbf_h = 9.0'), "late.failures.it.seconds", "over at once"),
        (failures('kind = "stuck"\nmtbf_h = 9.0', 'source = "t"'), "late.failures.it.seconds", "repaired"),
        (failures('kind = "motors"\nmtbf_km = 9.0'), "late.failures.it.cut_out", "for motors"),
        (
            failures('kind = "motors"\nmtbf_km = 9.0\ncut_out = 1\nmtfb = 2'),
            "late.failures.it.mtfb",
            "for motors",
        ),
    ],
)
def test_one_message_each(tmp_path: Path, text: str, key: str, expected: str) -> None:
    with pytest.raises(InputError) as refused:
        loaded(tmp_path, text)
    assert refused.value.key == key
    assert expected in refused.value.expected
    assert refused.value.file.endswith("own.toml")


def test_good_tables_are_taken_and_a_patch_changes_them(tmp_path: Path) -> None:
    text = f'[late.doors.a]\nshare = 0.1\n{FIXED}[patch.late]\ntimes = {{ "doors.a.share" = 2.0 }}\n'
    assert loaded(tmp_path, text).setup.late.doors["a"].share == pytest.approx(0.2)


def test_shipped_late_days_have_their_sources() -> None:
    for name, tables in (("karasuyama_late", 3), ("karasuyama_bad_days", 9)):
        late = load_scenario(name).setup.late
        every = [*late.entry.values(), *late.dwell.values(), *late.doors.values()]
        every += [*late.dead_zones.values(), *late.failures.values()]
        assert len(every) == tables
        assert all("assumed" in table.source or "DOI" in table.source for table in every)
