"""The RTRI test line with its one train, as a setup, for the tests of the loop's parts."""

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import load_timetable
from simulation.setup import Setup
from vehicle.train_file import load_train, shipped_train


@pytest.fixture(scope="session")
def rtri_setup() -> Setup:
    line = load_line(shipped_line("rtri_test_line"))
    timetable = load_timetable(shipped_timetable("rtri_test_line"), line)
    kind = load_train(shipped_train("ev_e301"))
    return Setup("test", line, timetable, {diagram.stock_id: kind for diagram in timetable.diagrams})


@pytest.fixture(scope="session")
def karasuyama_setup() -> Setup:
    line = load_line(shipped_line("karasuyama"))
    timetable = load_timetable(shipped_timetable("karasuyama_weekday"), line)
    kind = load_train(shipped_train("ev_e301"))
    return Setup("test", line, timetable, {diagram.stock_id: kind for diagram in timetable.diagrams})
