"""The cheapest equipment: a curve of which every point is proven, recounted, and refused where a choice is left out."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import pytest

from network.errors import InputError
from plan.equipping.cheapest import (
    EquipmentAsked,
    EquippedLine,
    choices_of,
    curve_of,
    equipped,
    objections_to,
    proof_of,
    worked_out,
)
from plan.equipping.options import EquipmentOption, options_of, options_of_file, tables_of
from plan.moving import refutation
from plan.where_to_meet import laying, loop_choices
from scenario.scenario import load_scenario
from simulation.setup import Setup

WEEKDAY = "karasuyama_weekday"
ONLY_LOOPS = frozenset({"quick_points", "limits", "quick_radio", "coverage", "blocks"})


def with_tables(tables: Mapping[str, Any]) -> Setup:
    return load_scenario(WEEKDAY, tables=tables or None).setup


ASKED = EquipmentAsked(1, without=ONLY_LOOPS)


@cache
def all_worked_out() -> tuple[EquippedLine, ...]:
    return tuple(worked_out(with_tables, choices_of(with_tables, ASKED)))


def test_every_choice_is_there_once_and_what_needs_another_not_alone() -> None:
    choices = choices_of(with_tables, EquipmentAsked(1))
    assert len({choice.names for choice in choices}) == len(choices) == 6 * 2**3 * 5
    costs = [choice.cost for choice in choices]
    assert costs == sorted(costs)
    assert not any("blocks" in c.names and not {"by_section", "coverage"} <= set(c.names) for c in choices)


@pytest.mark.nightly
def test_the_curve_is_what_no_choice_beats() -> None:
    found = all_worked_out()
    curve = curve_of(found)
    assert [(one.choice.names, one.interval_s) for one in curve][:1] == [((), 2208)]
    for point in curve:
        for one in found:
            cheaper = one.choice.cost < point.choice.cost
            assert one.interval_s > point.interval_s or not cheaper
    for one in found:
        assert any(p.choice.cost <= one.choice.cost and p.interval_s <= one.interval_s for p in curve)
    # docs/best.md, where to lay loops: Niita is the best of the single halts
    loops = {one.choice.names: one.interval_s for one in found if len(one.choice.names) == 1}
    assert min((s, name) for name, s in loops.items() if name[0].startswith("loop")) == (1287, ("loop_NIT",))


def test_what_a_user_says_a_loop_costs_changes_the_curve() -> None:
    dear = choices_of(
        with_tables, EquipmentAsked(1, without=ONLY_LOOPS, costs={"loop": 50.0, "loop_NIT": 500.0})
    )
    assert {c.names: c.cost for c in dear if len(c.names) == 1}["loop_NIT",] == 500.0
    assert {c.names: c.cost for c in dear if len(c.names) == 1}["loop_SHN",] == 50.0
    with pytest.raises(InputError, match="loop_XYZ"):
        choices_of(with_tables, EquipmentAsked(1, costs={"loop_XYZ": 1.0}))
    typo = EquipmentOption("signals", "more signals", 5.0, needs=("by_secton",))
    again = EquipmentOption("blocks", "more blocks", 5.0)
    for own, wrong in ((typo,), "by_secton"), ((again,), "name is 'blocks'"), ((again, again), "blocks"):
        with pytest.raises(InputError, match=wrong):
            choices_of(with_tables, EquipmentAsked(0, own=own))


def test_a_proof_with_a_choice_left_out_or_a_number_changed_is_refused() -> None:
    choices = choices_of(with_tables, ASKED)
    found = worked_out(with_tables, choices, 1440.0)
    assert found[-1].interval_s <= 1440.0
    proof = proof_of(found, 1440)
    assert proof.cheaper
    assert list(objections_to(with_tables, choices, proof)) == []
    fewer = msgspec.structs.replace(proof, cheaper=proof.cheaper[1:])
    assert list(objections_to(with_tables, choices, fewer)) != []
    quicker = msgspec.structs.replace(proof, interval_s=2300)
    assert list(objections_to(with_tables, choices, quicker)) != []
    swapped = msgspec.structs.replace(proof.cheaper[0], proof=proof.cheaper[-1].proof)
    assert list(
        objections_to(
            with_tables, choices, msgspec.structs.replace(proof, cheaper=(swapped, *proof.cheaper[1:]))
        )
    )


def test_a_line_on_which_nothing_runs_from_end_to_end_is_no_objection() -> None:
    """The test line's one train runs one way: all choices are found out by it, and by who checks."""

    def of_test_line(tables: Mapping[str, Any]) -> Setup:
        return load_scenario("rtri_test_line", tables=tables or None).setup

    choices = choices_of(of_test_line, EquipmentAsked(0))
    found = worked_out(of_test_line, choices[:3])
    assert all("expected trains each way" in one.why_not for one in found)
    assert list(objections_to(of_test_line, choices[:2], proof_of(found, 1440))) == []


def test_what_is_not_decided_is_no_choice_that_cannot_be_had(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refutation, "CASES_MAX", 0)
    nothing, *_ = choices_of(with_tables, EquipmentAsked(0))
    for search in (lambda: equipped(with_tables, nothing), lambda: loop_choices(with_loops, ("NIT",), 0)):
        with pytest.raises(InputError, match="the search for a proof: cases"):
            search()


def with_loops(loops: Sequence[str]) -> Setup:
    return with_tables(laying(loops))


def test_every_option_is_a_scenario_that_a_line_can_have() -> None:
    options = {one.name: one for one in options_of(with_tables({}))}
    for one in options.values():
        with_tables(tables_of([*(options[name] for name in one.needs), one]))
    assert set(options) == {"quick_points", "limits", "quick_radio", "by_section", "coverage", "blocks"}


def test_options_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(
        '[[option]]\nname = "walk"\nwhat = "a second driver at the ends"\ncost = 3.0\n'
        'set = { "operation.change_ends_s" = 20.0 }\n',
        "utf-8",
    )
    (own,) = options_of_file(path)
    assert own == EquipmentOption(
        "walk", "a second driver at the ends", 3.0, {"operation": {"change_ends_s": 20.0}}
    )
    assert with_tables(tables_of([own])).operation.change_ends_s == 20.0
    path.write_text('[[option]]\nname = "walk"\nwhat = "x"\ncost = -3.0\n', "utf-8")
    with pytest.raises(InputError, match="cost"):
        options_of_file(path)
