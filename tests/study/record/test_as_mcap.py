"""A run as MCAP, opened with the package's own reader: every entry and sample, in order, each by its schema."""

import json
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from scenario.scenario import load_scenario
from simulation.journal import encode_entry
from study.record.directory import JOURNAL_FILE, reserved
from study.record.read_back import read_run
from study.runner.run import PartyLink, execute, fill_run


def test_the_whole_run_comes_back(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader", reason="the extra [mcap] is not installed")
    from study.record.as_mcap import DAY_NS, NS_PER_S, write_mcap

    with reserved(tmp_path / "run") as place:
        done = execute(load_scenario("rtri_test_line"), PartyLink.SIMULATED, journal=place.journal)
        fill_run(done, place)
    run, file = read_run(tmp_path / "run"), tmp_path / "run.mcap"
    counts = write_mcap(run, file)
    with file.open("rb") as stream:
        messages = list(reader.make_reader(stream).iter_messages())
    assert len(messages) == counts.events + counts.samples
    times = [message.log_time for _, _, message in messages]
    assert times == sorted(times)
    journal = [m.data for _, channel, m in messages if channel.topic.startswith("/journal/")]
    assert journal == (tmp_path / "run" / JOURNAL_FILE).read_bytes().splitlines()
    assert journal == [encode_entry(entry) for entry in done.result.journal.entries]
    samples = [json.loads(m.data) for _, channel, m in messages if channel.topic == "/units/K1"]
    assert [row["kilometrage_m"] for row in samples] == run.tables.trajectory["kilometrage_m"].to_list()
    for schema, channel, message in messages:
        keys, data = json.loads(schema.data)["properties"], json.loads(message.data)
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert set(data) <= set(keys)
        assert message.log_time == round(data.get("t", data.get("t_s")) * NS_PER_S)

    begins_s = run.tables.trajectory["t_s"].min()
    early = run.tables.trajectory.with_columns(t_s=pl.col("t_s") - begins_s - 60.0)
    write_mcap(replace(run, directory=tmp_path, tables=replace(run.tables, trajectory=early)), file)
    with file.open("rb") as stream:
        messages = list(reader.make_reader(stream).iter_messages())
    assert len(messages) == counts.samples
    assert messages[0][2].log_time == DAY_NS - 60 * NS_PER_S  # since the midnight before
