"""Scripts of scenario files: what cannot be carried out or judged is refused with one message."""

import sys
from pathlib import Path

import pytest

from branchline import cli
from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from simulation.faults.links import ANY, Cut, FaultyLink, Reorder
from simulation.faults.script import DEFAULTS, ActKind, Property
from study.outcome import Outcome

HEAD = 'extends = "rtri_test_line"\nid = "tried"\n'


def scenario_of(tmp_path: Path, script: str) -> Scenario:
    file = tmp_path / "tried.toml"
    file.write_text(HEAD + script)
    return load_scenario(str(file))


def fault(kind: str, target: str, *keys: str, start: str = "10:00") -> str:
    return "\n".join(("[[fault]]", f'kind = "{kind}"', f'target = "{target}"', *keys, f'start = "{start}"\n'))


def act(kind: str, *keys: str) -> str:
    return "\n".join(("[[act]]", f'kind = "{kind}"', *keys, 'start = "10:00"\n'))


def expect(*keys: str) -> str:
    return "\n".join(("[[expect]]", 'text = "t"', *keys)) + "\n"


REFUSED = {
    "unknown fault": (fault("explodes", "K1"), "fault[0].kind"),
    "claims an unknown section": (fault("false_claims", "K1", 'section = "X"'), "fault[0].section"),
    "unknown device": (fault("power_off", "K9"), "fault[0].target"),
    "unknown points": (fault("stuck", "P1"), "fault[0].target"),
    "unknown tag": (fault("miss", "9"), "fault[0].target"),
    "a unit is no tag": (fault("miss", "K1"), "fault[0].target"),
    "no link": (fault("cut", "K1"), "fault[0].target"),
    "link to nobody": (fault("cut", "K1 <-> K9"), "fault[0].target"),
    "a link of three": (fault("cut", "K1 <-> B-W <-> K2"), "fault[0].target"),
    "two arrows": (fault("cut", "K1 -> B-W <-> K1"), "fault[0].target"),
    "an end missing": (fault("cut", " -> B-W"), "fault[0].target"),
    "a duration of what is over at once": (fault("restart", "K1", "duration_s = 5.0"), "fault[0].duration_s"),
    "held back for ever": (fault("reorder", "* <-> *", "p = 0.5", "seconds = 1e6"), "fault[0].seconds"),
    "half an id": (fault("wrong_id", "602", "id = 1.5"), "fault[0].id"),
    "safety in a stretch of time": (
        expect('property = "everyone_arrives"', 'after = "K1 restarts"'),
        "expect[0].after",
    ),
    "not slow": (
        expect('property = "speed_at_most"', 'unit = "K1"', "kmh = 1.0", "absent = true"),
        "expect[0].absent",
    ),
    "parameter missing": (fault("loss", "* <-> *"), "fault[0].p"),
    "parameter too large": (fault("loss", "* <-> *", "p = 1.5"), "fault[0].p"),
    "foreign parameter": (fault("cut", "* <-> *", "p = 0.5"), "fault[0].p"),
    "words that name nothing": (fault("restart", "K1", start="train T1 sings"), "fault[0].start"),
    "a train that does not run": (
        fault("restart", "K1", start="train T9 departs A"),
        "fault[0].start: train",
    ),
    "unknown act": (act("prays"), "act[0].kind"),
    "act on nobody": (act("give_back", 'target = "K9"'), "act[0].target"),
    "no position": (act("repair_points", 'target = "P7"', 'position = "up"'), "act[0].position"),
    "unknown section": (act("enter_section", 'sections = ["99"]'), "act[0].sections[0]"),
    "a place that is no section": (act("confirm_outside", 'target = "K1"', 'place = "99"'), "act[0].place"),
    "a place where none is said": (act("take_back", 'target = "K1"', 'place = "PE"'), "act[0].place"),
    "a place that is no word": (act("confirm_outside", 'target = "K1"', "place = 7"), "act[0].place"),
    "taken back of nobody": (act("take_back", 'target = "K9"'), "act[0].target"),
    "no sections": (act("confirm_holding", 'target = "K1"'), "act[0].sections"),
    "neither event nor property": (expect(), "expect[0]"),
    "event and property": (expect('event = "K1 restarts"', 'property = "x"'), "expect[0]"),
    "a word no journal has": (expect('event = { who = "K1", what = "dances" }'), "expect[0].event.what"),
    "a party that does not exist": (
        expect('event = { who = "K9", what = "restarted" }'),
        "expect[0].event.who",
    ),
    "a section in a list that does not exist": (
        expect('event = { what = "freed", sections = ["5", "99"] }'),
        "expect[0].event.sections",
    ),
    "a duration from no beginning": (expect('event = "K1 restarts"', "within_s = 5.0"), "expect[0].within_s"),
    "long after the run": (expect('event = "K1 restarts"', 'by = "59:00"'), "expect[0].by"),
    "unknown property": (expect('property = "beautiful"'), "expect[0].property"),
    "speed of nobody": (expect('property = "speed_at_most"', "kmh = 15.0"), "expect[0].unit"),
    "no speed": (expect('property = "speed_at_most"', 'unit = "K1"'), "expect[0].kmh"),
    "a time before the run": (
        expect('event = "K1 restarts"', "absent = true", 'by = "03:00"'),
        "expect[0].by",
    ),
    "a section of a speed": (
        expect('property = "speed_at_most"', 'unit = "K1"', "kmh = 15.0", 'section = "5"'),
        "expect[0].section",
    ),
    "a speed of an event": (expect('event = "K1 restarts"', "absent = true", "kmh = 15.0"), "expect[0].kmh"),
    "a position given back": (act("give_back", 'target = "K1"', 'position = "normal"'), "act[0].position"),
    "a rule that persons who are wrong do not break": (
        expect('property = "no_invariant_broken"', "absent = true", 'rules = ["tokens-grow"]'),
        "expect[0].rules[0]",
    ),
    "rules that nobody breaks": (
        expect('property = "no_invariant_broken"', 'rules = ["inside-holding"]'),
        "expect[0].rules",
    ),
    "a section nobody can enter": (
        expect('property = "never_enters"', 'unit = "K1"', 'section = "99"'),
        "expect[0].section",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_carried_out_or_judged_is_refused_with_its_key(tmp_path: Path, name: str) -> None:
    script, key = REFUSED[name]
    with pytest.raises(InputError) as error:
        scenario_of(tmp_path, script)
    assert error.value.key == key
    assert error.value.file.endswith("tried.toml")
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    "name", ["unknown fault", "unknown device", "a word no journal has", "a place that is no section"]
)
def test_the_command_ends_with_2_and_one_line(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "tried.toml"
    file.write_text(HEAD + REFUSED[name][0])
    monkeypatch.setattr(sys, "argv", ["branchline", "drill", str(file)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == Outcome.BAD_INPUT.code
    assert capsys.readouterr().err.splitlines()[-1].startswith("error: ")


def test_a_script_is_read_as_it_is_meant(tmp_path: Path) -> None:
    script = scenario_of(
        tmp_path,
        '[[fault]]\nkind = "cut"\ntarget = "* <-> block-manager"\nstart = "train T1 departs A"\nafter_s = 2.0\n'
        "duration_s = 60.0\n"
        '[[fault]]\nkind = "reorder"\ntarget = "K1 -> B-W"\np = 0.5\nseconds = 2.0\nstart = "10:00:30.5"\n'
        '[[act]]\nkind = "give_back"\ntarget = "K1"\nhold_s = 90.0\n'
        'start = { who = "K1", what = "route_held", route = "3>8" }\n'
        '[[act]]\nkind = "confirm_outside"\ntarget = "K1"\nperson = "staff"\nplace = "PE"\nstart = "10:05"\n'
        '[[act]]\nkind = "take_back"\ntarget = "K1"\nstart = { what = "contradiction" }\n'
        '[[expect]]\ntext = "slow"\nproperty = "speed_at_most"\nunit = "K1"\nkmh = 15.0\nafter = "K1 restarts"\n'
        "within_s = 30.0\n"
        '[[expect]]\ntext = "no grant"\nevent = { who = "block-manager", what = "granted" }\nabsent = true\n',
    ).setup.script
    cut, reorder = script.faults
    assert cut.fault == Cut(target=FaultyLink(ANY, "block-manager", both_ways=True))
    assert (cut.trigger.after_s, cut.duration_s) == (2.0, 60.0)
    assert cut.trigger.on is not None and cut.trigger.on.train == "T1"
    assert reorder.trigger.at_s == 36_030.5
    assert reorder.fault == Reorder(target=FaultyLink("K1", "B-W"), p=0.5, seconds=2.0)
    back, outside, taken_back = script.acts
    assert (back.kind, back.hold_s) == (ActKind.GIVE_BACK, 90.0)
    assert (outside.kind, outside.target, outside.place) == (ActKind.CONFIRM_OUTSIDE, "K1", "PE")
    assert (taken_back.kind, taken_back.target, taken_back.place) == (ActKind.TAKE_BACK, "K1", "")
    slow, grant, *others = script.expectations
    assert tuple(others) == DEFAULTS
    assert slow.holds is Property.SPEED_AT_MOST and slow.after is not None and slow.within_s == 30.0
    assert grant.absent and grant.event is not None and grant.event.who == "block-manager"


def test_what_every_drill_expects_need_not_be_written_and_can_be_said_otherwise(tmp_path: Path) -> None:
    assert scenario_of(tmp_path, "").setup.script.expectations == DEFAULTS
    otherwise = '[[expect]]\ntext = "it is left behind"\nproperty = "everyone_arrives"\nabsent = true\n'
    behind, safe = scenario_of(tmp_path, otherwise).setup.script.expectations
    assert (behind.text, behind.absent, behind.holds) == (
        "it is left behind",
        True,
        Property.EVERYONE_ARRIVES,
    )
    assert safe == DEFAULTS[1]


def test_what_disturbs_nothing_and_expects_nothing_of_its_own_is_no_drill(tmp_path: Path) -> None:
    from study.drilling.drill import run_drill
    from study.runner.run import PartyLink

    file = tmp_path / "tried.toml"
    file.write_text(HEAD)
    with pytest.raises(InputError, match="at least one"):
        run_drill(str(file), PartyLink.SIMULATED)
