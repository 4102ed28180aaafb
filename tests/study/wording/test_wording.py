"""Whatever a report says of typed facts it says in Japanese too: a new event, fault, reason or figure without fails."""

import ast
import re
import tomllib
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any, Union, get_args, get_origin

import msgspec
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.making.sample_day import timetable_toml
from network.model import Direction, Position, TagPurpose
from onboard.driving.tasc import StopVerdict
from onboard.duty.unable import NoCharge
from onboard.localisation.fix import OUTCOMES
from onboard.localisation.table import READER_NAMES
from onboard.notes import UnableToLeave, VehicleUnfit
from plan.arranging.arrange import _assumed
from plan.arranging.problem import Arranged, PrintedMove
from radio import messages
from radio.envelope import DropReason
from radio.noted import Noted
from scenario.scenario import load_scenario
from simulation import events
from simulation.faults.script import ActKind, Expectation, Property, ScriptedFault, matcher_of
from simulation.faults.table import FAULTS
from simulation.judge.checkers import Checker
from simulation.late.settings import Late
from simulation.result import Ending
from study.capacity.occupation import OccupationPart
from study.compare.comparison import FATES
from study.compare.measures import TABLES, columns_in
from study.compare.meets import MeetFate
from study.drilling.drill import find_drill
from study.measures.wait_text import text_of
from study.record.driving import EARLY, DrivenHop
from study.record.figure import figures_of
from study.record.tables import ROWS
from study.record.wait import Cause, Wait
from study.wording import script
from study.wording.assumptions import assumption
from study.wording.catalogue import phrases_of
from study.wording.compared import compared_name
from study.wording.events import EVENT_WORDINGS, event_text, wording_of
from study.wording.forms import phrase_by_form
from study.wording.phrase import Phrase, names_of
from study.wording.reasons import reason
from vehicle.train_file import load_train, shipped_train
from wayside.reentry import PictureClash
from wayside.register import ReentryStage, UnitStanding

ENGLISH = re.compile(r"[A-Za-z]*[a-z]{3,}[A-Za-z]*")
CODES = {"kgf", "ppm", "rms", "GNSS", "LiDAR", "kWh"}  # and what stands for names: one capital, one figure
ROOT = Path(__file__).parents[3]
# Of the words that parties give as reasons those that never come to a person: they stand in no event that is told.
UNTOLD_OF = {"dispatch.py", "order.py"}  # how trains are ordered stands in the journal alone
UNTOLD = {"the train does not stand at a known place", "the train may have entered the route"}


def english_in(text: str) -> list[str]:
    """Words in a text that only English has."""
    return [word for word in ENGLISH.findall(text) if word not in CODES]


def example(kind: Any, name: str) -> Any:  # noqa: ANN401 - of the field's type
    """A value of a field's type, with nothing in it but names."""
    if name in ("why", "was", "stage"):
        return "HELD"
    if name == "kind":
        return "RouteRequest"
    if name in ("act", "after", "reader"):
        return {"act": ActKind.POWER_ON.value, "after": "missed", "reader": "curvature"}[name]
    if get_origin(kind) in (Union, type(int | str)):
        return example(next(one for one in get_args(kind) if one is not type(None)), name)
    if get_origin(kind) is tuple:
        return (example(get_args(kind)[0], name),)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return next(iter(kind))
    values: dict[Any, Any] = {str: "K1", int: 1, float: 1.5, bool: True}
    return values.get(kind, {})


def made(event: events.EventType) -> Noted:
    fields = {field.name: example(field.type, field.name) for field in msgspec.structs.fields(event)}
    if event in (events.FaultBegan, events.FaultOver):
        fields["kind"] = "cut"
    return event(**fields)


@pytest.mark.parametrize("event", EVENT_WORDINGS, ids=lambda event: event.__name__)
def test_every_event_that_is_told_is_told_in_japanese_with_all_that_it_says(event: events.EventType) -> None:
    said = event_text(made(event), {"K1": Phrase("Here", "甲")})
    assert english_in(said.in_("ja")) == []
    assert re.search(r"[ぁ-んァ-ヶ一-龠]", said.ja)
    assert "{" not in said.en + said.ja
    shared = re.findall(r"K1|1\.5|甲", said.ja)
    if event is not events.Collision:  # whose text is the carrier's own
        assert len(shared) >= len(re.findall(r"K1|Here", said.en))


def test_what_a_set_lacks_to_its_next_charge_names_the_station() -> None:
    why = NoCharge("KRS", 20.04 * 3.6e6, 20.06 * 3.6e6, charges=False).words
    names = names_of(load_line(shipped_line("karasuyama")))
    said = event_text(UnableToLeave(station="OGN", why=why), names)
    assert said.en.startswith(
        "unable to leave Ogane: 20.1 kWh to Karasuyama, where it can charge next: it has 20.0 kWh"
    )
    assert "烏山" in said.ja and "KRS" not in said.ja


def test_doors_that_people_hold_open_are_no_fault() -> None:
    """A late day would be one of a hundred faults. A brake out of order is one, and so is what a fault opens."""
    tried = [wording_of(VehicleUnfit(why=why)) for why in ("doors not closed", "brake not in order")]
    assert [wording.kind for wording in tried if wording] == ["doors", "fault"]
    assert event_text(VehicleUnfit(why="doors not closed"), {}).en == "its doors are not shown as closed"


def test_of_a_low_battery_it_is_said_what_that_means() -> None:
    low = event_text(events.BatteryAt(unit_id="V4", level=events.BatteryLevel.LOW), {})
    assert low.en == "the battery of V4: low, heating and cooling are off"
    assert low.ja == "V4の蓄電池：低下（暖冷房などを停止）"


def test_a_reason_that_is_missing_takes_its_clause_with_it() -> None:
    refused = events.EVENTS["refused"](why="HELD")
    said = event_text(refused, {})
    assert said == Phrase("refused: HELD", "要求を拒否：他の列車が確保しています")


@pytest.mark.parametrize(
    ("there", "context"),
    [
        ({events.word_of(event).replace("_", " ") for event in events.EVENTS.values()}, "event"),
        (set(FAULTS), "fault"),
        ({f for kind in FAULTS.values() for f in kind.model_fields} - {"target"}, "fault figure"),
        ({kind.value for kind in ActKind}, "act"),
        ({purpose.value for purpose in TagPurpose}, "tag"),
        ({*READER_NAMES, *OUTCOMES, "driver's eye"}, "reader"),
        ({*(rule.value for rule in Checker), "unsafe"}, "rule"),
        ({danger.value for danger in events.Danger}, "danger"),
        ({ending.value for ending in Ending}, "ending"),
        ({cause.value for cause in Cause}, "cause"),
        ({part.value for part in OccupationPart}, "part"),
        ({told.kind for told in EVENT_WORDINGS.values()} | {"train", "expectation"}, "event kind"),
        (set(Late.model_fields), "drawn"),
        ({kind.__name__ for kind in get_args(messages.AnyMessage)}, "telegram"),
    ],
)
def test_every_list_of_the_catalogue_is_whole(there: set[str], context: str) -> None:
    assert there == set(phrases_of(context))


def reasons() -> Iterator[str]:
    """Every reason that a party gives: the members of its enums, and the constants that it writes as `why`."""
    for kind in (messages.RefusalReason, messages.PointsRefusalReason, StopVerdict):
        yield from (member.name for member in kind)
    for words in (DropReason, PictureClash, UnitStanding, ReentryStage):
        yield from (member.value for member in words)
    for path in (*(ROOT / "onboard").rglob("*.py"), *(ROOT / "wayside").rglob("*.py")):
        if path.name not in UNTOLD_OF:
            yield from _whys(ast.parse(path.read_text("utf-8")))


def _whys(tree: ast.AST) -> Iterator[str]:
    """Texts that go by the name of a reason, or to who writes one down."""
    for node in ast.walk(tree):
        given: list[ast.expr | None] = []
        if isinstance(node, ast.Call):
            given += [keyword.value for keyword in node.keywords if keyword.arg == "why"]
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in ("_refused", "_lose", "_unproven_note", "disagrees", "Limit"):
                given += node.args[1:3] if name != "_lose" else node.args[:1]
        elif isinstance(node, ast.Assign) and any(getattr(t, "id", "") == "why" for t in node.targets):
            given.append(node.value)
        for expression in given:
            yield from _texts(expression)


def _texts(expression: ast.AST | None) -> Iterator[str]:
    match expression:
        case ast.Constant(value=str() as text):
            yield text
        case ast.IfExp(body=one, orelse=other):
            yield from _texts(one)
            yield from _texts(other)
        case ast.JoinedStr(values=parts):
            yield "".join(str(p.value) if isinstance(p, ast.Constant) else "K1" for p in parts)
        case _:
            pass


def test_every_reason_has_japanese_words() -> None:
    found = {
        why: english_in(reason(why.lower().replace("_", " ")).in_("ja"))
        for why in reasons()
        if why not in UNTOLD
    }
    assert len(found) > 60
    assert {why: left for why, left in found.items() if left} == {}


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_is_said_with_its_figures(kind: str) -> None:
    fields = (name for name in FAULTS[kind].model_fields if name != "target")
    figures = {name: "2" if name == "section" else 2.0 for name in fields}
    said = script.fault_text(kind, "K1 <-> *", figures)
    assert english_in(said.ja) == [] and "全装置" in said.ja
    assert said.ja.count("2") >= len(figures)


EXPECTATIONS = (
    Expectation("it moves", event=matcher_of("points P7 move"), absent=True, until=matcher_of("K1 restarts")),
    Expectation("slow", holds=Property.SPEED_AT_MOST, unit="K1", kmh=25.0, within_s=20.0),
    Expectation("never", holds=Property.NEVER_ENTERS, unit="K1", section="5", by_s=36_000.0),
)


def test_an_expectation_is_said_from_what_is_judged() -> None:
    said = [script.expectation_text(expectation).ja for expectation in EXPECTATIONS]
    assert said == [
        "転てつ機の転換（P7）がない［K1の車上装置の再起動・装置の起動まで］",
        "K1の速度が 25 km/h 以下［20 秒以内］",
        "K1が5区間に入らない［10:00:00まで］",
    ]


@pytest.mark.parametrize(
    "name",
    [
        "rtri/09b_manager_power_by_hand",
        "karasuyama/12_terminal_power",
        "rtri/59_unit_barred",
        "rtri/06_unit_manager_link",
        "rtri/101_crossing_power",
        "rtri/105_crossing_asked_late",
        "rtri/115_crossing_by_pilot",
    ],
)
def test_of_a_drill_nothing_is_left_in_english(name: str) -> None:
    drill = load_scenario(find_drill(name), None).setup.script
    said = [script.item_text(item).ja for item in (*drill.faults, *drill.acts)]
    said += [script.expectation_text(expectation).ja for expectation in drill.expectations]
    assert drill.faults or drill.acts
    assert all(isinstance(item, ScriptedFault) for item in drill.faults)
    for person in {act.person for act in drill.acts}:  # people's own names
        said = [text.removeprefix(f"{person}：") for text in said]
    assert [text for text in said if english_in(text)] == []


def test_what_is_compared_has_its_words() -> None:
    whole = (ROOT / "study" / "compare" / "measures.py").read_text("utf-8")
    names = {
        node.args[i].value  # type: ignore[attr-defined]
        for node in ast.walk(ast.parse(whole))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "RunFigure"
        for i in (0, 1, 2)
        if isinstance(node.args[i], ast.Constant)
    }
    assert len(names) > 30
    assert {
        name for name in names - {name for name in names if compared_name(name).ja} if english_in(name)
    } == set()
    assert all(columns_in(table) for table in TABLES) and set(FATES) == set(MeetFate)
    assert [said.name.en for said in (*figures_of(DrivenHop).values(), EARLY) if not said.name.ja] == []


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_no_two_columns_of_a_table_are_headed_alike(row: type) -> None:
    headings = [said.heading for said in figures_of(row).values()]
    assert all(heading.ja for heading in headings)
    for said in ([heading.en for heading in headings], [heading.ja for heading in headings]):
        assert len(set(said)) == len(said)


def test_positions_and_directions_go_by_the_fields_words() -> None:
    assert [script.value_text("position", position).ja for position in Position] == ["定位", "反位"]
    assert script.value_text("direction", Direction.DOWN.name.lower()).ja == "下り"


FORMS = [*phrases_of("assumption").values(), *phrases_of("opinion").values()]
CODE = re.compile(r"(documents\.|network\.)?(busy_line|tag_layout)")


def shipped(folder: str) -> list[str]:
    return sorted(path.stem for path in (ROOT / "network" / folder).glob("*.toml"))


@pytest.mark.parametrize("line_id", shipped("lines"))
def test_what_a_shipped_line_rests_on_is_said_in_japanese(line_id: str) -> None:
    line = load_line(shipped_line(line_id))
    days = [
        tomllib.loads(path.read_text("utf-8")) for path in (ROOT / "network" / "timetables").glob("*.toml")
    ]
    of_line = [day["timetable"] for day in days if day["timetable"]["line"] == line_id]
    texts = [*line.assumed, *(text for day in of_line for text in day.get("assumed", ()))]
    left = {text: english_in(CODE.sub("", assumption(text, line).in_("ja"))) for text in texts}
    assert len(texts) > 3
    assert {text: words for text, words in left.items() if words} == {}


def test_what_the_program_assumes_of_a_day_that_it_makes_is_said_in_japanese() -> None:
    """`new line --scenario` makes one up, `arrange` and `import --train` change one of others'."""
    line, train = load_line(shipped_line("busy_line")), load_train(shipped_train("br642"))
    made = tomllib.loads(timetable_toml(line, "made"))["timetable"]["assumed"]
    moved = PrintedMove("1D", "ALP", "arrival", 0, 3)
    made += _assumed(
        train, Arranged({}, (moved,), proven=True, bound_s=3.0, reach_s=60, work=0.0), ["E1", "E2"]
    )
    left = {text: english_in(assumption(text, line).in_("ja").replace("inferred", "")) for text in made}
    assert len(left) == 4 and {text: words for text, words in left.items() if words} == {}


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.en[:40])
def test_a_sentence_is_found_by_its_form_with_its_figures(form: Phrase) -> None:
    count = form.en.count("{}")
    values = [str(11 * (i + 1)) for i in range(count)]
    said = phrase_by_form(FORMS, form.en.format(*values), Phrase)
    assert said is not None and said.en == form.en.format(*values)
    assert all(value in said.ja for value in values) or "times:" in form.en
    assert phrase_by_form(FORMS, "something else", Phrase) is None


def test_a_vehicle_that_lacks_something_is_said_not_to_come_further() -> None:
    said = text_of(Wait("K1", "1", 0.0, 1.0, Cause.UNABLE, "A", reason="power")).en
    assert said == "1 stays at A: it could not reach its next stop for want of power."
