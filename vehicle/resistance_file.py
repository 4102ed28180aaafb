"""`[resistance]` of a train file, which `vehicle.train_file` reads: what keeps it from running."""

from __future__ import annotations

from typing import Annotated

from network.files.kinds import about
from network.files.quantities import AirResistance, CurveResistance, Resistance, ResistanceSlope
from network.files.toml_input import Record


class RunningResistance(Record):
    """`[resistance]`: R = sum of the mass terms and the air term, speeds in km/h."""

    motored_constant_n_per_kn: Annotated[Resistance, about("motored cars, constant term")]
    motored_linear_n_per_kn_kmh: Annotated[ResistanceSlope, about("motored cars, linear term")]
    trailer_constant_n_per_kn: Annotated[Resistance, about("trailers, constant term")]
    trailer_linear_n_per_kn_kmh: Annotated[ResistanceSlope, about("trailers, linear term")]
    air_n_per_kmh2: Annotated[AirResistance, about("air, with the square of speed")]
    starting_n_per_kn: Annotated[Resistance, about("resistance at a start")]
    curve_coefficient_m: Annotated[
        CurveResistance, about("permille of resistance times the radius of a curve")
    ]
