"""A plan whose train cannot manage a gradient of its way is refused, or told, with the place and the forces."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Line
from scenario.scenario import load_scenario
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.faults.vehicle import Motors
from simulation.scatter import ScatterSettings, Weather
from simulation.settings import Load
from simulation.setup import Setup
from study.feasibility import climbs
from study.feasibility.check import PlanRefusedError, feasibility, refuse
from study.feasibility.climbs import worst_conditions
from study.feasibility.finding import Finding, FindingKind, Severity
from vehicle.train_file import load_train, shipped_train

TRAIN, STOCK, DEPARTS_S = "T1", "K1", 36_000.0


def sloped(permille: float) -> Setup:
    """The paper's test line on one gradient: from A (km 0.44) up to B."""
    setup = load_scenario("rtri_test_line").setup
    line = setup.line
    main = line.alignments["main"]
    gradients = tuple(replace(g, permille=permille) for g in main.gradients)
    line = replace(line, alignments={**line.alignments, "main": replace(main, gradients=gradients)})
    assert isinstance(line, Line)
    return replace(setup, line=line)


def gradients(setup: Setup) -> list[Finding]:
    return [found for found in feasibility(setup).findings if found.kind is FindingKind.GRADIENT]


def test_a_train_that_cannot_start_is_refused_with_place_gradient_forces_and_load() -> None:
    setup = sloped(60.0)
    (found,) = gradients(setup)
    assert (found.severity, found.trains, found.place, found.minute) == (
        Severity.IMPOSSIBLE,
        (TRAIN,),
        "A-B",
        "10:00",
    )
    for part in ("cannot start at km 0.440", "60.0 permille", "50.0 kN", "49.8 kN", "20% laden"):
        assert part in found.text
    with pytest.raises(PlanRefusedError, match=r"cannot start at km 0\.440"):
        refuse("steep", setup)


def test_switched_off_it_is_not_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(climbs.Climbs, "on", lambda *_args, **_named: None)
    assert gradients(sloped(60.0)) == []


@pytest.mark.parametrize(
    ("permille", "severities"),
    [(30.0, []), (127.0, [Severity.TIGHT]), (135.0, [Severity.IMPOSSIBLE])],
)
def test_what_the_heaviest_load_of_the_scenario_cannot_is_told(
    permille: float, severities: list[Severity]
) -> None:
    """BR 642, whose force does not grow with its load: 72 t at the mean, 76 t at the most, 94.4 kN."""
    br642 = load_train(shipped_train("br642"))
    setup = replace(
        sloped(permille), trains={STOCK: br642}, load=Load(load_share_mean=0.2, load_share_spread=0.2)
    )
    assert [found.severity for found in gradients(setup)] == severities
    even = replace(setup, load=Load(load_share_mean=0.2, load_share_spread=0.0))
    assert [found.severity for found in gradients(even)] == [
        s for s in severities if s is Severity.IMPOSSIBLE
    ]


def test_motors_cut_out_at_the_departure_are_told() -> None:
    def with_fault(at_s: float, duration_s: float | None) -> Setup:
        fault = ScriptedFault(Motors(target=STOCK, cut_out=2), Trigger(at_s=at_s), duration_s)
        return replace(sloped(30.0), script=Script(faults=(fault,)))

    (found,) = gradients(with_fault(DEPARTS_S - 60.0, None))
    assert found.severity is Severity.TIGHT
    assert "with 2 of 4 motors" in found.text
    assert gradients(with_fault(DEPARTS_S - 60.0, 30.0)) == []
    assert gradients(with_fault(DEPARTS_S + 60.0, None)) == []
    assert worst_conditions(with_fault(DEPARTS_S, 60.0), STOCK, DEPARTS_S).motors_share == 0.5


def test_the_worst_rail_of_the_weather_is_told() -> None:
    rain = Weather.model_validate({"from": "09:00", "to": "11:00", "adhesion_low": 0.2, "adhesion_high": 0.9})
    (found,) = gradients(replace(sloped(30.0), scatter=ScatterSettings(weather=(rain,))))
    assert found.severity is Severity.TIGHT
    assert "on 20% of the dry rail's adhesion" in found.text


def test_where_a_train_could_not_start_again_is_told() -> None:
    """Level for the start, then a climb that its momentum carries it over."""
    setup = sloped(0.0)
    main = setup.line.alignments["main"]
    (level,) = main.gradients
    steep = (
        replace(level, to_m=700.0),
        replace(level, from_m=700.0, to_m=800.0, permille=70.0),
        replace(level, from_m=800.0),
    )
    alignments = {**setup.line.alignments, "main": replace(main, gradients=steep)}
    (found,) = gradients(replace(setup, line=replace(setup.line, alignments=alignments)))
    assert found.severity is Severity.TIGHT
    assert "could not start again if it had to stop at km 0.7" in found.text


@given(permille=st.floats(-60.0, 120.0))
def test_a_plan_is_refused_exactly_where_its_train_needs_more_than_it_has(permille: float) -> None:
    setup = replace(sloped(permille), load=Load(load_share_mean=0.2, load_share_spread=0.0))
    found = gradients(setup)
    refused = [one for one in found if one.severity is Severity.IMPOSSIBLE]
    assert bool(refused) == (permille > 60.0) or abs(permille - 60.0) < 1.0
