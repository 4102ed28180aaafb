"""`branchline best`: what would be best, each answer with a bound or a proof."""

from __future__ import annotations

import typer

from branchline.best_equipment import equipment
from branchline.best_interval import interval
from branchline.best_loops import loops
from branchline.best_robust import robust
from branchline.best_roster import roster
from branchline.best_trains import trains
from branchline.dispatching import deadlock, displib
from branchline.progress import going_on

best = typer.Typer(
    no_args_is_help=True,
)


@best.callback()
def _of_all_searches(context: typer.Context) -> None:
    """Search for the best interval, loops, trains, equipment or duties, with a proven bound."""
    context.obj = going_on


best.command()(interval)
best.command()(loops)
best.command()(trains)
best.command()(robust)
best.command()(equipment)
best.command()(roster)
best.command()(displib)
best.command()(deadlock)
