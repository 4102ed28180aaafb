"""Patches of every file: what they change, what they leave, what they list, and whom they blame."""

from pathlib import Path

import pytest

from network.errors import InputError
from network.files.edits import Change
from network.timetable import AtPortal
from scenario.scenario import Scenario, load_scenario

HEAD = 'extends = "{}"\nid = "what_if"\nname = "What if"\n'


def patched(
    tmp_path: Path, text: str, base: str = "karasuyama_weekday", name: str = "what_if.toml"
) -> Scenario:
    file = tmp_path / name
    file.write_text(HEAD.format(base) + text, "utf-8")
    return load_scenario(str(file))


def departures(scenario: Scenario, number: str) -> list[int | None]:
    return [call.departure_s for call in scenario.setup.timetable.trains[number].calls]


def hms(text: str) -> int:
    hours, minutes, *seconds = (int(part) for part in text.split(":"))
    return hours * 3600 + minutes * 60 + (seconds[0] if seconds else 0)


def test_a_departure_by_train_and_station(tmp_path: Path) -> None:
    what_if = patched(tmp_path, '[patch.timetable.set]\n"trains.323M.calls.OGN.departure" = "06:57"\n')
    plain = load_scenario("karasuyama_weekday")
    assert departures(what_if, "323M")[4] == hms("06:57") == (departures(plain, "323M")[4] or 0) + 60
    others = set(plain.setup.timetable.trains) - {"323M"}
    assert all(what_if.setup.timetable.trains[n] == plain.setup.timetable.trains[n] for n in others)
    key = "trains.323M.calls.OGN.departure"
    change = Change(file="karasuyama_weekday.toml", key=key, old="06:56", new="06:57")
    assert what_if.inputs.changes == [change]


LIKE_331M = """[[patch.timetable.like]]
number = "331M-2"
train = "331M"
later_s = 7200
stock = "V9"
"""


def test_a_train_like_another_two_hours_later(tmp_path: Path) -> None:
    ways = 'begins = "stabled"\nends = "stabled"\n'
    what_if = patched(tmp_path, LIKE_331M + ways).setup.timetable
    old, new = (what_if.trains[number] for number in ("331M", "331M-2"))
    assert [(c.station_id, c.first_s - 7200, c.last_s - 7200) for c in new.calls] == [
        (c.station_id, c.first_s, c.last_s) for c in old.calls
    ]
    assert any(diagram.train_numbers == ("331M-2",) for diagram in what_if.diagrams)


@pytest.mark.parametrize(
    ("more", "key"),
    [
        ("", r"like\[0\]\.(begins|ends).*a set of its own"),
        ('begins = "stabled"\nends = "becomes:333M"\n', r"like\[0\]\.ends is 'becomes:333M'"),
    ],
)
def test_a_train_like_another_has_a_set_of_its_own(tmp_path: Path, more: str, key: str) -> None:
    with pytest.raises(InputError, match=key):
        patched(tmp_path, LIKE_331M + more)


def test_a_train_like_one_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"like\[0\]\.train is '9M'"):
        patched(tmp_path, LIKE_331M.replace('"331M"', '"9M"'))


def test_running_times_by_share_between_hours(tmp_path: Path) -> None:
    """321M leaves HSK at 05:37 and runs 5, 3, 4, 6, 4, 4, 5 min; only runs that begin before 05:50 are stretched."""
    text = '[[patch.timetable.scale]]\nfrom = "05:30"\nto = "05:50"\ntimes = 1.5\ntrains = ["321M"]\n'
    what_if = patched(tmp_path, text)
    calls = what_if.setup.timetable.trains["321M"].calls
    assert [call.first_s for call in calls[:5]] == [
        hms("05:37"),
        hms("05:42") + 150,  # 5 min and half of it
        hms("05:46") + 150 + 90,
        hms("05:50") + 150 + 90 + 120,
        hms("05:57") + 360,  # this run began at 05:51
    ]
    assert calls[-1].arrival_s == hms("06:11") + 360
    dwell_s = [call.last_s - call.first_s for call in calls[1:-1]]
    assert dwell_s == [60, 0, 60, 0, 60, 0]


def test_trains_go_with_their_place_in_the_diagram(tmp_path: Path) -> None:
    plain = load_scenario("karasuyama_weekday").setup.timetable
    numbers = plain.diagrams[0].train_numbers
    # The set's last visit to the line: from where it last came in to its end.
    cut = max(i for i, number in enumerate(numbers) if isinstance(plain.trains[number].begins, AtPortal))
    last = numbers[cut:]
    what_if = patched(tmp_path, f"[patch.timetable]\nremove.trains = {list(last)}\n".replace("'", '"'))
    after = what_if.setup.timetable
    assert set(plain.trains) - set(after.trains) == set(last)
    assert after.diagrams[0].train_numbers == numbers[:cut]


def test_a_train_is_added_with_its_diagram(tmp_path: Path) -> None:
    text = """
    [[patch.timetable.add.trains]]
    number = "T9"
    direction = "down"
    begins = "portal:PW"
    ends = "stabled"
    calls = [{ station = "A", track = "1", departure = "11:00" }, { station = "B", track = "2", arrival = "11:03" }]
    [[patch.timetable.add.diagrams]]
    stock = "K9"
    trains = ["T9"]
    """
    what_if = patched(tmp_path, text, "rtri_test_line")
    assert set(what_if.setup.timetable.trains) == {"T1", "T9"}
    assert set(what_if.setup.trains) == {"K1", "K9"}


def test_a_train_file_by_id_and_by_share(tmp_path: Path) -> None:
    text = '[patch.train.ev_e301]\nset = { mass_empty_t = 80.0 }\ntimes = { "brakes.notch_deceleration_kmhps" = 0.5 }\n'
    plain, what_if = load_scenario("rtri_test_line"), patched(tmp_path, text, "rtri_test_line")
    before, after = (s.setup.trains["K1"].row[0] for s in (plain, what_if))
    assert after["mass_empty_kg"] == 80_000.0
    assert after["brake_deceleration_mps2"] == pytest.approx(before["brake_deceleration_mps2"] / 2)
    assert after["length_m"] == before["length_m"]
    # The figure is nobody's any more: the report says so.
    assert any("body.mass_empty_t: assumed: set by what_if.toml" in text for text in what_if.inputs.assumed)
    assert {c.key for c in what_if.inputs.changes} == {"body.mass_empty_t", "brakes.notch_deceleration_kmhps"}


def test_air_by_share_of_what_the_base_says_or_of_the_default(tmp_path: Path) -> None:
    air = patched(tmp_path, "[patch.air.times]\nloss_good_p = 3.0\nreorder_delay_s = 2.0\n")
    assert air.setup.air.loss_good_p == pytest.approx(0.03)  # the weekday's is 0.01
    assert air.setup.air.reorder_delay_s == 2.0  # the default is 1
    assert [(c.key, c.old) for c in air.inputs.changes] == [
        ("air.loss_good_p", 0.01),
        ("air.reorder_delay_s", 1.0),
    ]


def test_all_entries_at_once(tmp_path: Path) -> None:
    blocks = patched(
        tmp_path, '[patch.line.set]\n"sections.6.virtual_blocks" = 2\n', "rtri_test_line", "two.toml"
    )
    more = patched(tmp_path, '[patch.line.times]\n"sections.6.virtual_blocks" = 2\n', "two.toml", "four.toml")
    # a number of pieces stays whole
    assert len(more.setup.line.sections) == len(blocks.setup.line.sections) + 2
    what_if = patched(tmp_path, '[patch.line.times]\n"points.*.throw_time_s" = 2.0\n')
    assert {points.throw_time_s for points in what_if.setup.line.points.values()} == {12.0}


FAULT = '[[fault]]\nkind = "stuck"\ntarget = "{}"\nstart = "09:59:00"\nduration_s = 60.0\n'


def test_adding_to_a_list_and_replacing_it_are_two_things(tmp_path: Path) -> None:
    (tmp_path / "low.toml").write_text(HEAD.format("rtri_test_line") + FAULT.format("P5"), "utf-8")
    replaced = patched(tmp_path, FAULT.format("P7"), "low")
    added = patched(tmp_path, "[[patch.fault.add]]\n" + FAULT.format("P7").partition("\n")[2], "low")
    fewer = patched(tmp_path, "[patch.fault]\nremove = [0]\n", "low")
    longer = patched(tmp_path, '[patch.fault.times]\n"0.duration_s" = 2.0\n', "low")
    assert [f.fault.target for f in replaced.setup.script.faults] == ["P7"]
    assert [f.fault.target for f in added.setup.script.faults] == ["P5", "P7"]
    assert fewer.setup.script.faults == ()
    assert longer.setup.script.faults[0].duration_s == 120.0


def test_patches_of_scenarios_that_extend_one_another_add_up(tmp_path: Path) -> None:
    """The lower one's entry stays although the upper one adds to the same list."""
    row = '[[patch.line.add.tags]]\nid = {}\nsection = "6"\nkm = {}\npurpose = "position"\n'
    (tmp_path / "low.toml").write_text(HEAD.format("rtri_test_line") + row.format(971, 0.6), "utf-8")
    tags = patched(tmp_path, row.format(972, 0.7), "low").setup.line.tags
    assert {971, 972} <= set(tags)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[patch.lines]\nset = {}", "patch.lines"),
        ("[patch.air.set]\nloss_good_p = 1.5", 'patch.air.set."loss_good_p"'),
        ("[patch.air.times]\nloss_good_p = -1", 'patch.air.times."loss_good_p"'),
        ("[patch.air.times]\ndelay_shape = 2.0", 'patch.air.times."delay_shape"'),
        ("[patch.air.set]\nlos = 1.5", 'patch.air.set."los"'),
        ("[patch.train.br642]\nset = {}", "patch.train.br642"),
        ("[patch.train.ev_e301.set]\nmass_empty_t = -1.0", 'patch.train.ev_e301.set."body.mass_empty_t"'),
        ("[patch.train.ev_e301.add]\nbody = []", "patch.train.ev_e301.add"),
        ('[patch.timetable.set]\n"trains.999M.number" = "1"', 'patch.timetable.set."trains.999M.number"'),
        (
            '[patch.timetable.set]\n"trains.321M.calls.OGN.departure" = "5.57"',
            'patch.timetable.set."trains.321M.calls.OGN.departure"',
        ),
        ('[patch.timetable]\nremove.trains = ["999M"]', "patch.timetable.remove.trains[0]"),
        ('[patch.timetable]\nremove.trains = ["321M"]', "patch.timetable"),  # 324M comes from it
        (
            '[[patch.timetable.scale]]\nfrom = "02:00"\nto = "03:00"\ntimes = 1.1',
            "patch.timetable.scale[0]",
        ),
        ('[[patch.timetable.scale]]\nfrom = "2"\nto = "03:00"\ntimes = 1.1', "patch.timetable.scale[0].from"),
        ("[patch.fault]\nremove = [3]", "patch.fault.remove"),
    ],
)
def test_what_cannot_be_is_put_down_to_the_patch(tmp_path: Path, text: str, key: str) -> None:
    with pytest.raises(InputError) as refused:
        patched(tmp_path, text)
    assert refused.value.file == str(tmp_path / "what_if.toml")
    assert refused.value.key == key
    assert "\n" not in str(refused.value)


def test_a_table_of_defaults_is_no_number_to_multiply(tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        patched(tmp_path, "[patch.law.times]\npid = 2.0\n", "rtri_test_line")
    assert error.value.key == 'patch.law.times."pid"'
    assert error.value.value is None
