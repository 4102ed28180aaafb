"""A station's panel at the desk: the next departures, and a telephone to the dispatcher by which a train is held.

    python station_panel.py ws://127.0.0.1:8580/desk OGN
    python station_panel.py ws://127.0.0.1:8580/desk OGN --hold V3 300
    python station_panel.py ws://127.0.0.1:8580/desk OGN --record panel.jsonl

It uses nothing of branchline, only the protocol (docs/desk-protocol.json) and the package websockets.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

VERSION = 3
ROWS = 6


def board(welcome: dict[str, Any], state: dict[str, Any], station: str) -> list[str]:
    """The next departures from a station: planned time, train, and how late it was last heard."""
    at_m = next(one["at_m"] for one in welcome["stations"] if one["id"] == station)
    late_s = {train["train"]: train["late_s"] for train in state["trains"]}
    rows = []
    for train in welcome["plan"]:
        times = [t for t, m in zip(train["times_s"], train["at_m"], strict=True) if m == at_m]
        if times and times[-1] + max(0.0, late_s.get(train["train"]) or 0.0) > state["time_s"]:
            rows.append((times[-1], train["train"]))
    return [f"{clock(t)} {number:6} {minutes(late_s.get(number))}" for t, number in sorted(rows)[:ROWS]]


def clock(time_s: float) -> str:
    """Hours and minutes."""
    return f"{int(time_s // 3600):02}:{int(time_s // 60) % 60:02}"


def minutes(late_s: float | None) -> str:
    """How late, for passengers: nothing below a minute."""
    return f"{int(late_s // 60)} min late" if late_s is not None and late_s >= 60.0 else ""


def messages(desk: ClientConnection, seat: str, record: str | None) -> Iterator[dict[str, Any]]:
    """Take a seat, and give all that the desk says; each message is a line of the record."""
    desk.send(json.dumps({"say": "hello", "seat": seat, "version": VERSION}))
    for text in desk:
        if record is not None:
            with Path(record).open("a", encoding="utf-8") as file:
                file.write(f"{text}\n")
        yield json.loads(text)


def call(desk: ClientConnection, unit: str, hold_s: float) -> None:
    """Have the dispatcher's desk hold a train; the answer comes with the same number."""
    act = {"kind": "hold_train", "target": unit, "hold_s": hold_s}
    desk.send(json.dumps({"say": "act", "number": 1, "act": act}))


def main(arguments: list[str]) -> None:
    """Show the board whenever it is another one; after a call, say what came of it and end."""
    parser = argparse.ArgumentParser()
    parser.add_argument("address")
    parser.add_argument("station")
    parser.add_argument("--hold", nargs=2)
    parser.add_argument("--record")
    asked = parser.parse_args(arguments)
    welcome: dict[str, Any] = {}
    shown: list[str] = []
    with connect(asked.address, max_size=None) as desk:
        for message in messages(desk, "dispatcher" if asked.hold else "guest", asked.record):
            match message["say"]:
                case "welcome":
                    welcome = message
                    if asked.hold:
                        call(desk, asked.hold[0], float(asked.hold[1]))
                case "answer":
                    sys.stdout.write("held\n" if message["good"] else f"refused: {message['why']}\n")
                    return
                case "state" if not asked.hold and board(welcome, message, asked.station) != shown:
                    shown = board(welcome, message, asked.station)
                    sys.stdout.write("\n".join([clock(message["time_s"]), *shown, ""]))
                    sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
