# SPDX-License-Identifier: LGPL-3.0-or-later
"""The loads of a case file: each is one channel, driven by one scalar history of segments."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from fretfe.case.base import (
    TAG,
    Axis,
    Direction,
    Name,
    NotNegative,
    Number,
    Point,
    Positive,
    SurfaceDirection,
    Table,
    Temperature,
    Text,
    Vector,
)
from fretfe.case.segments import Segment


class Channel(Table):
    """Base of all loads: each has a history."""

    history: tuple[Segment, ...] = Field(
        min_length=1,
        description="Segments in the order of time, on the clock of the case, which starts at 0 "
        "with the value 0. After the last segment the value stays.",
    )


BETWEEN_POINTS = (
    "linear in between, in triangles or tetrahedra of points that span the space, else along their "
    "line or plane and constant across it. They must reach as far as what they are for."
)


class ChannelAtPoints(Channel):
    """Base of loads that may be given by values at points."""

    points: tuple[Point, ...] | None = Field(
        default=None, min_length=2, description=f"Points with a value; {BETWEEN_POINTS}"
    )
    values: tuple[Any, ...] | None = Field(default=None, description="Values, one for each point.")
    file: Text | None = Field(
        default=None,
        description="CSV file with columns x, y (and z of solids) and T, of a traction value, "
        "relative to the folder of the case file; used as points and values are.",
    )

    @property
    def at_points(self) -> bool:
        """True if it is given by values at points."""
        return self.points is not None or self.file is not None

    @model_validator(mode="after")
    def _one_value_each(self) -> Self:
        points, values = self.points, self.values
        found = "none" if values is None else str(len(values))
        if points is None:
            if values is not None:
                raise ValueError(f"expected 'values' with 'points' only, found {found} values")
            return self
        if values is None or len(points) != len(values):
            raise ValueError(
                f"expected as many values as points, found {len(points)} points and {found} values"
            )
        if self.file is not None:
            raise ValueError("expected one of 'points' and 'file', found both")
        if len({len(point) for point in points}) > 1:
            raise ValueError("expected points of 2 coordinates or of 3, found both")
        if len(set(points)) < len(points):
            raise ValueError("expected every point once, found one of them twice")
        return self


class PlatenLoad(Channel):
    """A boundary that moves as one rigid piece and does not turn, unless it has a tilt."""

    type: Literal["platen"] = Field(description='"platen": a rigid, guided boundary.')
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Direction = Field(
        description='Direction of force or displacement: "x", "y", "z" or a vector (its length '
        "does not matter). Directions of a platen without a load are held."
    )
    control: Literal["force", "displacement"] = Field(
        description='What the history prescribes: "force", the total force on the platen for the '
        'whole thickness, in force units, or "displacement", in length units; positive along '
        "direction."
    )


class TiltLoad(Channel):
    """A platen that turns about an axis as well."""

    type: Literal["tilt"] = Field(description='"tilt": a rigid boundary that turns about an axis.')
    boundary: Text = Field(
        description="Physical group of the boundary, a platen. Without a platen load of its own it "
        "is held in every direction, and about every axis without a tilt."
    )
    axis: Direction = Field(
        default="z",
        description='Axis that it turns about, anticlockwise: "x", "y", "z" or a vector (its '
        'length does not matter); "z" in a plane model.',
    )
    centre: tuple[Number, ...] = Field(
        min_length=2, max_length=3, description="A point on the axis, in length units."
    )
    control: Literal["moment", "rotation"] = Field(
        description='What the history prescribes: "moment", about the axis for the whole '
        'thickness, in force times length units (0 lets the platen tilt freely), or "rotation", in '
        "radians."
    )


class TractionLoad(ChannelAtPoints):
    """A traction on a boundary, uniform unless it has values at points.

    These are factors of the history.
    """

    type: Literal["traction"] = Field(description='"traction": force per area on a boundary.')
    boundary: Text = Field(description="Physical group of the boundary.")
    values: tuple[Number, ...] | None = Field(
        default=None, description="Factors of the history, one for each point."
    )
    direction: SurfaceDirection = Field(
        description='"normal" (outward, so that a positive value pulls), "x", "y", "z" or a vector '
        "(its length does not matter). The history is in stress units."
    )


class DisplacementLoad(Channel):
    """One prescribed displacement component of a boundary; the others stay free."""

    type: Literal["displacement"] = Field(
        description='"displacement": one prescribed displacement component.'
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Axis = Field(
        description='Component that is prescribed: "x", "y" or "z". The history is in length units.'
    )


class ShapeLoad(ChannelAtPoints):
    """A boundary whose displacement is an amplitude times a shape, as that of a mode."""

    type: Literal["shape"] = Field(
        description='"shape": displacement of a boundary that is a factor, the history, times a '
        "shape. Exactly one of points and file must be given."
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    values: tuple[Point, ...] | None = Field(
        default=None, description="Displacements, one for each point, in length units."
    )
    file: Text | None = Field(
        default=None,
        description="CSV file with columns x, y (and z of solids), ux, uy (and uz), relative to "
        "the folder of the case file; lines that begin with # are skipped.",
    )
    factor: Positive = Field(
        default=1.0,
        description="Factor of all lengths, coordinates and displacements: 1000 for metres in a "
        "case in millimetres.",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if not self.at_points:
            raise ValueError("expected one of 'points' and 'file', found none")
        for point, value in zip(self.points or (), self.values or (), strict=True):
            if len(point) != len(value):
                raise ValueError(
                    f"expected displacements with {len(point)} components, as the points have, "
                    f"found {len(value)}"
                )
        return self


class OtherRun(Channel):
    """A load that another run gives; the history runs through its steps."""

    position: Literal["time", "number"] = Field(
        default="time",
        description='What the history counts: the "time" of the run, or the "number" of its steps '
        "in the file, from 1 on.",
    )
    factor: Positive = Field(
        default=1.0,
        description="Factor of all lengths, coordinates and displacements: 1000 for metres in a "
        "case in millimetres.",
    )
    arrays: tuple[Text, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=3,
        description="Values at the nodes to take from a file that VTK reads, by their names: one "
        'array, or of displacements a number for each axis, as ["disp_x", "disp_y"]; without it '
        "the one with a usual name.",
    )


class FieldLoad(OtherRun):
    """A cut boundary whose displacement is that of another run."""

    type: Literal["field"] = Field(
        description='"field": displacement of a cut, in the steps of another run. The history is '
        "the position in that run: 0 is unloaded, and between its steps displacements are linear."
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    file: Text = Field(
        description="Displacements of the run: a CSV file with columns x, y (z), ux, uy (uz) and "
        "time or step, a .frd, .vtu, .vtk, .pvd or VTKHDF file, or a results folder; relative to "
        "the folder of the case file."
    )
    part: Text | None = Field(
        default=None,
        description="Part of the run that the boundary is cut from, of a results folder its body; "
        "without it the part with the name of the body.",
    )
    displacement_factor: Positive | None = Field(
        default=None,
        description="Factor of the displacements alone, where their unit is not that of the "
        "coordinates; without it 'factor'.",
    )

    @property
    def displacement_scale(self) -> float:
        """Factor of the displacements."""
        return self.factor if self.displacement_factor is None else self.displacement_factor


class TemperatureFieldLoad(OtherRun):
    """Temperatures of bodies that are those of another run."""

    type: Literal["temperature_field"] = Field(
        description='"temperature_field": temperatures of bodies in the steps of another run, by '
        "which they expand. The history is the position in that run: 0 is the reference "
        "temperature everywhere, and between its steps temperatures are linear."
    )
    file: Text = Field(
        description="Temperatures of the run, in degrees Celsius: a CSV file with columns x, y "
        "(z), T and time or step, or a .frd, .vtu, .vtk, .pvd or VTKHDF file; relative to the "
        "folder of the case file."
    )
    bodies: tuple[Name, ...] | None = Field(
        default=None, min_length=1, description="Bodies that it acts on; all without this key."
    )


class ForceLoad(Channel):
    """A force spread evenly over a boundary, or a part of it."""

    type: Literal["force"] = Field(
        description='"force": total force on a boundary, spread evenly over it or over its part '
        "around a point. The history is in force units, for the whole thickness."
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Direction = Field(
        description='Direction of the force: "x", "y", "z" or a vector (its length does not '
        "matter)."
    )
    centre: Point | None = Field(
        default=None, description="Middle of the part of the boundary that the force acts on."
    )
    radius: Positive | None = Field(
        default=None,
        description="Distance from the centre up to which it acts; given with the centre.",
    )

    @model_validator(mode="after")
    def _both_or_none(self) -> Self:
        if (self.centre is None) != (self.radius is None):
            found = "centre" if self.radius is None else "radius"
            raise ValueError(f"expected 'centre' and 'radius', or none of them, found {found!r}")
        return self


class RotationLoad(Channel):
    """Centrifugal body force density * omega^2 * r in all bodies."""

    type: Literal["rotation"] = Field(
        description='"rotation": centrifugal body force, density * omega^2 * distance from the '
        "axis. The history is omega, in radians per time unit."
    )
    centre: tuple[Number, ...] = Field(
        min_length=2, max_length=3, description="A point on the axis, in length units."
    )
    axis: Vector = Field(
        default=(0.0, 0.0, 1.0),
        description="Direction of the axis (its length does not matter); [0, 0, 1] in a plane "
        "model.",
    )


class AccelerationLoad(Channel):
    """Body force density * acceleration in all bodies, as that of gravity."""

    type: Literal["acceleration"] = Field(
        description='"acceleration": body force density * acceleration in all bodies, as by '
        "gravity. The history is the acceleration, in length over time squared."
    )
    direction: Direction = Field(
        description='Direction of the force: "x", "y", "z" or a vector (its length does not '
        "matter). What is accelerated feels a force in the opposite direction."
    )


class InterferenceLoad(Channel):
    """A press fit: surfaces of a contact that are larger than they are drawn."""

    type: Literal["interference"] = Field(
        description='"interference": overlap of the surfaces of a contact, along its normal, on '
        "top of their initial gap. The history is in length units."
    )
    contact: Name = Field(description="Contact whose surfaces overlap.")


class TemperatureLoad(ChannelAtPoints):
    """A change of temperature, by which bodies expand."""

    type: Literal["temperature"] = Field(
        description='"temperature": thermal strain, expansion * (T - reference_temperature) of '
        "each body. The history is the part of the way from the reference temperature to the one "
        "given here: 0 none, 1 all of it."
    )
    value: Temperature | None = Field(
        default=None,
        description="Temperature everywhere, in degrees Celsius. Exactly one of value, points and "
        "file must be given.",
    )
    values: tuple[Temperature, ...] | None = Field(
        default=None, description="Temperatures, one for each point."
    )
    bodies: tuple[Name, ...] | None = Field(
        default=None, min_length=1, description="Bodies that it acts on; all without this key."
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        given = [key for key in ("value", "points", "file") if getattr(self, key) is not None]
        if len(given) != 1:
            listed = " and ".join(map(repr, given)) or "none"
            raise ValueError(f"expected exactly one of 'value', 'points', 'file', found {listed}")
        return self


class EigenstrainLoad(Channel):
    """Strain that a treatment, such as shot peening or welding, has left in bodies."""

    type: Literal["eigenstrain"] = Field(
        description='"eigenstrain": initial strain, in a layer below surfaces, where it is the '
        "same in all directions of the surface and none across it, or any strain from a file. "
        "The history is a factor of it."
    )
    surfaces: tuple[Text, ...] | None = Field(
        default=None,
        min_length=1,
        description="Physical groups of the surfaces that a layer lies below. Either surfaces, "
        "depths and values must be given, or file.",
    )
    depths: tuple[NotNegative, ...] | None = Field(
        default=None,
        min_length=1,
        description="Depths below the surfaces, in length units, increasing from 0.",
    )
    values: tuple[Number, ...] | None = Field(
        default=None,
        min_length=1,
        description="Strains at the depths, positive where the layer would grow; linear in "
        "between, and below the last depth as there.",
    )
    file: Text | None = Field(
        default=None,
        description="CSV file with columns x, y (and z of solids), exx, eyy, ezz, exy (and eyz, "
        "exz), components of the strain tensor (exy is half of the shear angle), relative to the "
        f"folder of the case file; lines that begin with # are skipped; {BETWEEN_POINTS}",
    )
    bodies: tuple[Name, ...] | None = Field(
        default=None, min_length=1, description="Bodies that a file acts on; all without this key."
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        layer = ("surfaces", "depths", "values")
        given = [key for key in (*layer, "file") if getattr(self, key) is not None]
        if given not in ([*layer], ["file"]):
            found = ", ".join(map(repr, given)) or "none"
            raise ValueError(
                f"expected 'surfaces', 'depths' and 'values', or 'file', found {found}"
            )
        if self.file is None and self.bodies is not None:
            raise ValueError("expected 'bodies' with 'file' only, found it with 'surfaces'")
        return self

    @model_validator(mode="after")
    def _profile(self) -> Self:
        depths, values = self.depths or (0.0,), self.values or (0.0,)
        if len(depths) != len(values):
            raise ValueError(
                "expected as many values as depths, "
                f"found {len(depths)} depths and {len(values)} values"
            )
        if depths[0] != 0 or any(b <= a for a, b in pairwise(depths)):
            raise ValueError(f"expected depths that increase from 0, found {list(depths)}")
        return self


Load = (
    PlatenLoad
    | TiltLoad
    | TractionLoad
    | DisplacementLoad
    | ShapeLoad
    | FieldLoad
    | TemperatureFieldLoad
    | ForceLoad
    | RotationLoad
    | AccelerationLoad
    | InterferenceLoad
    | TemperatureLoad
    | EigenstrainLoad
)
LOADS: dict[str, type[Channel]] = {
    "platen": PlatenLoad,
    "tilt": TiltLoad,
    "traction": TractionLoad,
    "displacement": DisplacementLoad,
    "shape": ShapeLoad,
    "field": FieldLoad,
    "temperature_field": TemperatureFieldLoad,
    "force": ForceLoad,
    "rotation": RotationLoad,
    "acceleration": AccelerationLoad,
    "interference": InterferenceLoad,
    "temperature": TemperatureLoad,
    "eigenstrain": EigenstrainLoad,
}


def _load_type(load: Any) -> str | None:
    """Tag of a raw load, None if its type is missing or unknown."""
    kind = load.get("type") if isinstance(load, dict) else getattr(load, "type", None)
    return f"{TAG}{kind}" if isinstance(kind, str) and kind in LOADS else None


AnyLoad = Annotated[
    Annotated[PlatenLoad, Tag(f"{TAG}platen")]
    | Annotated[TiltLoad, Tag(f"{TAG}tilt")]
    | Annotated[TractionLoad, Tag(f"{TAG}traction")]
    | Annotated[DisplacementLoad, Tag(f"{TAG}displacement")]
    | Annotated[ShapeLoad, Tag(f"{TAG}shape")]
    | Annotated[FieldLoad, Tag(f"{TAG}field")]
    | Annotated[TemperatureFieldLoad, Tag(f"{TAG}temperature_field")]
    | Annotated[ForceLoad, Tag(f"{TAG}force")]
    | Annotated[RotationLoad, Tag(f"{TAG}rotation")]
    | Annotated[AccelerationLoad, Tag(f"{TAG}acceleration")]
    | Annotated[InterferenceLoad, Tag(f"{TAG}interference")]
    | Annotated[TemperatureLoad, Tag(f"{TAG}temperature")]
    | Annotated[EigenstrainLoad, Tag(f"{TAG}eigenstrain")],
    Discriminator(_load_type),
]
