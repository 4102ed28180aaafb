"""`[patience]`: for how long passengers wait before they ask."""

from __future__ import annotations

from typing import Annotated

from network.files.kinds import about
from network.files.quantities import Wait
from network.files.toml_input import Record


class WaitSettings(Record):
    """`[patience]`: what passengers put up with."""

    wait_s: Annotated[Wait, about("until somebody asks", "assumed: ten minutes")] = 600.0
