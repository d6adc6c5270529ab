# SPDX-License-Identifier: LGPL-3.0-or-later
"""The loads of a case file: each is one channel, driven by one scalar history of segments."""

from __future__ import annotations

from collections.abc import Collection
from functools import reduce
from itertools import pairwise
from operator import or_
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    Self,
    get_args,
)

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
    unit_vector,
)
from fretfe.case.segments import Segment
from fretfe.case.units import Units

# Columns of a file of strains, of plane bodies the first four, and their components.
STRAINS = {"exx": (0, 0), "eyy": (1, 1), "ezz": (2, 2), "exy": (0, 1), "eyz": (1, 2), "exz": (0, 2)}
PLANE_STRAINS = 4

# A direction of a case file: an axis, "normal", or components.
Along = str | tuple[float, ...]
# Columns of the values in the table of a load, by the number of coordinates of the mesh.
Columns = dict[int, tuple[str, ...]]


LengthFactor = Annotated[
    Positive,
    Field(
        description="Factor of all lengths, coordinates and displacements: 1000 for metres in a "
        "case in millimetres."
    ),
]


class Load(Table):
    """A load: one channel with one history.

    Each kind of load is one class of this module and stands in `KINDS` once: there the case file
    has its types from. A class says what its load asks of the case and what others may ask of it;
    what it does to bodies is in `bodies.loads`.

    Attributes:
        needs: keys of the constants that each body has to have that it acts on.
        rigid: whether its boundary moves as one rigid piece, a platen.
        moves: whether it prescribes displacements of a boundary that is no platen.
        by_shape: whether these are a shape, with as many components as the mesh has coordinates.
        body_force: whether it pushes bodies everywhere.
        half_plane: whether some loads of its kind act on half-planes, too.
        undivided: why it cannot act on a part of its boundary, in words before "all of it".
        history_unit: unit of the history, in those of a case by their keys.
    """

    if TYPE_CHECKING:
        type: str

    history: tuple[Segment, ...] = Field(
        min_length=1,
        description="Segments in the order of time, on the clock of the case, which starts at 0 "
        "with the value 0. After the last segment the value stays.",
    )

    needs: ClassVar[tuple[str, ...]] = ()
    rigid: ClassVar[bool] = False
    moves: ClassVar[bool] = False
    by_shape: ClassVar[bool] = False
    body_force: ClassVar[bool] = False
    half_plane: ClassVar[bool] = False
    undivided: ClassVar[str] = ""
    history_unit: ClassVar[str] = "1"

    def unit(self, units: Units) -> str:
        """Unit of the history, in those of a case."""
        return self.history_unit.format(**dict(units))

    @property
    def title(self) -> str:
        """The kind of load in a sentence, with its article."""
        return f"{'an' if self.type[0] in 'aei' else 'a'} {self.type}"

    @property
    def on(self) -> str:
        """Boundary that it acts on; empty if it acts in bodies or between them."""
        return getattr(self, "boundary", "")

    @property
    def along(self) -> Along | None:
        """Its direction, if loads of this kind have one."""
        return getattr(self, "direction", None)

    @property
    def about(self) -> Along | None:
        """Its axis, if loads of this kind have one."""
        return getattr(self, "axis", None)

    @property
    def places(self) -> dict[tuple[str | int, ...], tuple[float, ...]]:
        """Points that it names, by their keys."""
        points = enumerate(getattr(self, "points", None) or ())
        named = {(key,): getattr(self, key, None) for key in ("centre", "through")}
        own = {key: point for key, point in named.items() if point is not None}
        return own | {("points", number): point for number, point in points}

    @property
    def within(self) -> tuple[str, ...] | None:
        """Bodies that it acts on; None for all."""
        return getattr(self, "bodies", None)

    @property
    def closes(self) -> str:
        """Contact whose gap it closes, if it does that."""
        return getattr(self, "contact", "")

    @property
    def tightens(self) -> str:
        """Tie whose parts it lets overlap, if it does that."""
        return getattr(self, "tie", "")

    @property
    def loosens(self) -> bool:
        """True if nothing but its own force goes across the tie that it has."""
        return False

    @property
    def push(self) -> Along | None:
        """Direction of the force that it gives on its boundary; None if it gives none."""
        return None

    def half_plane_obstacle(self, top: str, sides: Collection[str]) -> str:
        """Reason why it does not act on half-planes; empty if it does.

        Args:
            top: boundary of the upper body.
            sides: boundaries of the lower body at which a bulk tension acts.
        """
        return (
            f"expected a platen force or a traction on {top!r}, or a tension on a side of the "
            f"block, found {self.title} ({self.on or 'everywhere'})"
        )


BETWEEN_POINTS = (
    "linear in between, in triangles or tetrahedra of points that span the space, else along their "
    "line or plane and constant across it. They must reach as far as what they are for."
)


class LoadAtPoints(Load):
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

    columns: ClassVar[Columns] = {2: ("value",), 3: ("value",)}

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


class PlatenLoad(Load):
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

    rigid = True
    half_plane = True
    undivided = "one rigid piece,"

    def unit(self, units: Units) -> str:
        """Unit of the history, in those of a case."""
        return units.force if self.control == "force" else units.length

    @property
    def push(self) -> Along | None:
        """Direction of the force, if the history is that."""
        return self.direction if self.control == "force" else None

    def half_plane_obstacle(self, top: str, sides: Collection[str]) -> str:
        """Reason why it does not act on half-planes; empty if it does."""
        if self.boundary != top:
            return super().half_plane_obstacle(top, sides)
        if self.control == "force":
            return ""
        return (
            f"expected control = 'force', found {self.control!r} (the approach of half-planes is "
            "not determined)"
        )


class TiltLoad(Load):
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

    rigid = True
    undivided = "one rigid piece,"

    def unit(self, units: Units) -> str:
        """Unit of the history, in those of a case."""
        return "rad" if self.control == "rotation" else f"{units.force}·{units.length}"


class TractionLoad(LoadAtPoints):
    """A traction on a boundary, uniform unless it has values at points.

    These are factors of the history.
    """

    type: Literal["traction"] = Field(description='"traction": force per area on a boundary.')
    boundary: Text = Field(description="Physical group of the boundary.")
    values: tuple[Number, ...] | None = Field(
        default=None, description="Factors of the history, one for each point."
    )
    function: Text | None = Field(
        default=None,
        description="Name of a plug-in that gives the factors, in place of points and file.",
    )
    direction: SurfaceDirection = Field(
        description='"normal" (outward, so that a positive value pulls), "x", "y", "z" or a vector '
        "(its length does not matter). The history is in stress units."
    )

    half_plane = True
    history_unit = "{stress}"

    @property
    def at_points(self) -> bool:
        """True if it is not uniform."""
        return self.function is not None or super().at_points

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if self.function is not None and super().at_points:
            raise ValueError("expected one of 'points', 'file' and 'function', found 'function' "
                             "and another")  # fmt: skip
        return self

    @property
    def push(self) -> Along:
        """Direction of the traction."""
        return self.direction

    def half_plane_obstacle(self, top: str, sides: Collection[str]) -> str:
        """Reason why it does not act on half-planes; empty if it does."""
        if self.at_points:
            return "expected a uniform traction, found values at points"
        if self.boundary in sides:
            known = self.direction == "normal" or abs(unit_vector(self.direction, 2)[1]) < 1e-9
            return "" if known else f"expected a bulk tension along x, found {self.direction!r}"
        return "" if self.boundary == top else super().half_plane_obstacle(top, sides)


class DisplacementLoad(Load):
    """One prescribed displacement component of a boundary; the others stay free."""

    type: Literal["displacement"] = Field(
        description='"displacement": one prescribed displacement component.'
    )
    boundary: Text = Field(description="Physical group of the boundary.")
    direction: Axis = Field(
        description='Component that is prescribed: "x", "y" or "z". The history is in length units.'
    )

    moves = True
    history_unit = "{length}"


class ShapeLoad(LoadAtPoints):
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
    factor: LengthFactor = 1.0

    moves = True
    by_shape = True
    columns: ClassVar[Columns] = {2: ("ux", "uy"), 3: ("ux", "uy", "uz")}

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


class OtherRun(Load):
    """A load that another run gives; the history runs through its steps."""

    position: Literal["time", "number"] = Field(
        default="time",
        description='What the history counts: the "time" of the run, or the "number" of its steps '
        "in the file, from 1 on.",
    )
    factor: LengthFactor = 1.0
    arrays: tuple[Text, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=3,
        description="Values at the nodes to take from a file that VTK reads, by their names: one "
        'array, or of displacements a number for each axis, as ["disp_x", "disp_y"]; without it '
        "the one with a usual name.",
    )

    if TYPE_CHECKING:
        file: str
    quantity: ClassVar[Literal["displacements", "temperatures"]]


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

    moves = True
    by_shape = True
    quantity = "displacements"

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

    needs = ("expansion", "reference_temperature")
    quantity = "temperatures"


class ForceLoad(Load):
    """A force spread over a boundary, or a part of it."""

    type: Literal["force"] = Field(
        description='"force": total force on a boundary, spread over it or over its part around a '
        "point. The history is in force units, for the whole thickness."
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
    through: Point | None = Field(
        default=None,
        description="Point on its line of action, as a reference point of a distributing coupling: "
        "its traction is then linear over the boundary. Without it even, in the middle.",
    )

    undivided = "a force spread over"
    history_unit = "{force}"

    @property
    def push(self) -> Along:
        """Direction of the force."""
        return self.direction

    @model_validator(mode="after")
    def _both_or_none(self) -> Self:
        if (self.centre is None) != (self.radius is None):
            found = "centre" if self.radius is None else "radius"
            raise ValueError(f"expected 'centre' and 'radius', or none of them, found {found!r}")
        return self


class RotationLoad(Load):
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

    needs = ("density",)
    body_force = True
    history_unit = "1/{time}"


class AccelerationLoad(Load):
    """Body force density * acceleration in all bodies, as that of gravity."""

    type: Literal["acceleration"] = Field(
        description='"acceleration": body force density * acceleration in all bodies, as by '
        "gravity. The history is the acceleration, in length over time squared."
    )
    direction: Direction = Field(
        description='Direction of the force: "x", "y", "z" or a vector (its length does not '
        "matter). What is accelerated feels a force in the opposite direction."
    )

    needs = ("density",)
    body_force = True
    history_unit = "{length}/{time}^2"


class InterferenceLoad(Load):
    """A press fit: surfaces of a contact that are larger than they are drawn."""

    type: Literal["interference"] = Field(
        description='"interference": overlap of the surfaces of a contact, along its normal, on '
        "top of their initial gap. The history is in length units."
    )
    contact: Name = Field(description="Contact whose surfaces overlap.")

    history_unit = "{length}"


class PretensionLoad(Load):
    """A bolt that is tightened: tied parts overlap across the plane in which it was cut."""

    type: Literal["pretension"] = Field(
        description='"pretension": tied parts overlap along the normal of their boundaries, as a '
        "bolt becomes shorter that is tightened."
    )
    tie: Name = Field(description="Table of [ties] whose boundaries overlap, which are plane.")
    control: Literal["force", "displacement"] = Field(
        description='What the history prescribes: "force", the tension in the bolt for the whole '
        'thickness, in force units, or "displacement", the overlap, in length units.'
    )

    moves = True

    @property
    def loosens(self) -> bool:
        """True if nothing but its own force goes across its tie."""
        return self.control == "force"

    def unit(self, units: Units) -> str:
        """Unit of the history, in those of a case."""
        return units.force if self.control == "force" else units.length


class TemperatureLoad(LoadAtPoints):
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

    needs = ("expansion", "reference_temperature")
    columns: ClassVar[Columns] = {2: ("T",), 3: ("T",)}

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        given = [key for key in ("value", "points", "file") if getattr(self, key) is not None]
        if len(given) != 1:
            listed = " and ".join(map(repr, given)) or "none"
            raise ValueError(f"expected exactly one of 'value', 'points', 'file', found {listed}")
        return self


class EigenstrainLoad(Load):
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

    columns: ClassVar[Columns] = {2: tuple(STRAINS)[:PLANE_STRAINS], 3: tuple(STRAINS)}

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


# In the order in which messages name them.
KINDS: tuple[type[Load], ...] = (
    PlatenLoad, TiltLoad, TractionLoad, DisplacementLoad, ShapeLoad, FieldLoad,
    TemperatureFieldLoad, ForceLoad, RotationLoad, AccelerationLoad, InterferenceLoad,
    PretensionLoad, TemperatureLoad, EigenstrainLoad,
)  # fmt: skip
# By the type that the case file calls them by.
LOADS = {get_args(kind.model_fields["type"].annotation)[0]: kind for kind in KINDS}


def _load_type(load: Any) -> str | None:
    """Tag of a raw load, None if its type is missing or unknown."""
    kind = load.get("type") if isinstance(load, dict) else getattr(load, "type", None)
    return f"{TAG}{kind}" if isinstance(kind, str) and kind in LOADS else None


if TYPE_CHECKING:
    AnyLoad = Load
else:
    AnyLoad = Annotated[
        reduce(or_, (Annotated[load, Tag(f"{TAG}{kind}")] for kind, load in LOADS.items())),
        Discriminator(_load_type),
    ]
