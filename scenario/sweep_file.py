"""The sweep file's tables: which scenario is varied and how, over which seeds, and what is watched."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from network.files.chances import Confidence, DrawnValue, SweepDays
from network.files.kinds import TEXTS_MAX, about
from network.files.names import Identifier, Prose, Title
from network.files.quantities import Seed
from network.files.toml_input import Record

AXES_MAX = 20  # assumed: a grid of two values each has a million points then
VALUES_MAX = 200  # assumed: of an axis


class SeedsTable(Record):
    """`[seeds]`: the days of each point of the grid, one a seed; every point has the same seeds."""

    first: Annotated[Seed, about("seed of the first day", "assumed: any will do")] = 1
    days: Annotated[SweepDays, about("days of each point; --days comes first")]


class AxisPoint(Record):
    """`[[axis.point]]`: one place of an axis that says several things at once."""

    label: Annotated[Title, about("display name")]
    says: Annotated[dict[str, Any], about("values of the scenario by key path; nothing: as it is", "")] = (
        Field(default_factory=dict, alias="set")
    )


class AxisTable(Record):
    """`[[axis]]`: one axis of the grid; a point of the grid takes one place of each axis.

    Either a key with its values, or places that say several things each.
    """

    name: Annotated[Title, about("display name")]
    key: Annotated[str | None, about("key path in a scenario file, as TOML writes it; patches too")] = None
    values: Annotated[list[Any], Field(max_length=VALUES_MAX), about("values of the key")] = Field(
        default_factory=list
    )
    labels: Annotated[
        list[Title], Field(max_length=VALUES_MAX), about("display name of each value; left out: the value")
    ] = Field(default_factory=list)
    point: Annotated[
        list[AxisPoint], Field(max_length=VALUES_MAX), about("places that say several things each")
    ] = Field(default_factory=list)


class DrawTable(Record):
    """`[[draw]]`: a value drawn anew each day by seed and name; the same at every point of the grid."""

    name: Annotated[Identifier, about("names the source of chance: another name draws otherwise")]
    key: Annotated[str, about("key path in a scenario file, as TOML writes it; patches too")]
    distribution: Annotated[
        Literal["uniform", "normal", "lognormal", "exponential", "triangular", "choice"],
        about("uniform and triangular want low and high, normal mean and sigma, lognormal median and sigma"),
    ]
    low: Annotated[DrawnValue | None, about("least value; elsewhere than uniform: cut there")] = None
    high: Annotated[DrawnValue | None, about("greatest value; elsewhere than uniform: cut there")] = None
    mean: Annotated[DrawnValue | None, about("mean of normal and exponential, before cutting")] = None
    median: Annotated[DrawnValue | None, about("median of lognormal, before cutting")] = None
    mode: Annotated[DrawnValue | None, about("mode of triangular; left out: the middle")] = None
    sigma: Annotated[
        DrawnValue | None, about("standard deviation: of normal, and of the logarithm in lognormal")
    ] = None
    values: Annotated[list[Any], Field(max_length=VALUES_MAX), about("values of a choice")] = Field(
        default_factory=list
    )
    weights: Annotated[
        list[DrawnValue], Field(max_length=VALUES_MAX), about("weights of a choice; left out: all equal")
    ] = Field(default_factory=list)
    whole: Annotated[
        bool,
        about("the value is a whole number; of uniform each is as likely", "assumed: most keys take any"),
    ] = False


class StopTable(Record):
    """`[stop]`: each point ends early, once the confidence interval of its mean is narrow enough.

    Days count in the order of their seeds, whoever runs them: the table is the same wherever the days were run. It is
    looked at after `least_days`, and after half as many days again each time; intervals hold at all looks together.
    """

    figure: Annotated[str, about("which figure of a day")]
    narrower_than: Annotated[DrawnValue, about("width of the interval, in the figure's unit")]
    least_days: Annotated[
        SweepDays, about("days that are always run", "assumed: fewer say little of their own scatter")
    ] = 30


class SweepFile(Record):
    """A sweep: a scenario varied over a grid and over random draws, each point for many days."""

    id: Annotated[Identifier, about("name of the sweep and of its directory")]
    name: Annotated[Title, about("display name")]
    scenario: Annotated[str, about("scenario that is varied, shipped or beside the sweep file")]
    carrier: Annotated[
        Literal["sumo", "plain"],
        about(
            "what moves the trains; with plain every tenth day runs again on sumo and must be the same; --carrier"
            " overrides it",
            "assumed: the quicker one, which the tenth days judge",
        ),
    ] = "plain"
    assumed: Annotated[
        list[Prose], Field(max_length=TEXTS_MAX), about("what has no published source, for the report")
    ] = Field(default_factory=list)
    seeds: SeedsTable
    axis: Annotated[list[AxisTable], Field(max_length=AXES_MAX), about("axes of the grid")] = Field(
        default_factory=list
    )
    draw: Annotated[list[DrawTable], Field(max_length=TEXTS_MAX), about("what is drawn for each day")] = (
        Field(default_factory=list)
    )
    watch: Annotated[
        list[str],
        Field(min_length=1, max_length=TEXTS_MAX),
        about("figures of a day that are shown as it runs and drawn; the tables have all"),
    ] = Field(default_factory=lambda: ["mean_late_s", "within_60_s"])
    confidence: Annotated[Confidence, about("confidence of all intervals", "assumed: usual")] = 0.95
    stop: Annotated[StopTable | None, about("when a point has days enough; left out: all days run")] = None
    keep: Annotated[
        list[Literal["journal", "trajectory", "report"]],
        Field(max_length=3),
        about("what is kept of each day besides its record; report: the whole run directory"),
    ] = Field(default_factory=list)
