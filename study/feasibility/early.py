"""What of a scenario's script has a time before its run begins: it begins with the run, in the order of the script."""

from __future__ import annotations

from network.clock import clock
from simulation.faults.script import Act, ScriptedFault
from simulation.setup import Setup
from simulation.world.roster import begins_s, drawn_up
from study.wording.script import item_text


def early_text(setup: Setup) -> str:
    """Faults and acts with such times, in a sentence; empty where there are none. Raises as `drawn_up` does."""
    duties = drawn_up(setup, setup.believed_line).values()
    run_s = begins_s(duty for drawn in duties for duty in drawn)
    items: tuple[ScriptedFault | Act, ...] = (*setup.script.faults, *setup.script.acts)
    timed = [
        (item.trigger.at_s + item.trigger.after_s, item) for item in items if item.trigger.at_s is not None
    ]
    said = [f"{item_text(item).en} ({clock(int(at_s))})" for at_s, item in timed if at_s < run_s]
    return f"before the run begins, at {clock(int(run_s))}, and so with it: {', '.join(said)}" if said else ""
