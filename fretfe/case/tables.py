# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tables of a case file other than loads: geometry, bodies, contacts, supports, output."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, StrictBool, Tag, model_validator

from fretfe.case.base import (
    TAG,
    BoundarySelector,
    Count,
    HeldAlong,
    Name,
    NotNegative,
    Number,
    Point,
    Positive,
    Selector,
    Table,
    Text,
    Vector,
    file_problem,
)
from fretfe.case.friction import Friction, InFile, OverArc, OverHeat, OverPressure, OverTime
from fretfe.case.layer import Layer

Plane = Literal["strain", "stress"]


class Model(Table):
    """Kinematic assumption and discretisation."""

    plane: Plane = Field(
        default="strain", description='Plane state of a plane model: "strain" or "stress".'
    )
    thickness: Positive = Field(
        default=1.0,
        description="Thickness of a plane model, in length units. Platen forces are for the whole "
        "thickness; line forces in the results are per unit thickness.",
    )
    degree: int = Field(
        default=2,
        strict=True,
        ge=1,
        le=2,
        description="Polynomial degree of the displacements, 1 or 2.",
    )


class Solid(Table):
    """Extrusion of plane bodies to solid ones."""

    length: Positive = Field(description="Extent in z, in length units; > 0.")
    skew: Number = Field(
        default=0.0,
        gt=-60,
        lt=60,
        description="Angle in degrees by which the extrusion leans in x; the direction is "
        "(tan(skew), 0, 1). -60 < skew < 60.",
    )
    layers: Count = Field(description="Number of layers of elements along the length; >= 1.")
    end_size: Positive | None = Field(
        default=None,
        description="Thickness of the layers at the ends, but where supports hold bodies along z "
        "that do not lean; further inside they grow to the length "
        "over layers. Without it all layers are equal.",
    )
    spans: dict[Name, tuple[NotNegative, Positive]] = Field(
        default_factory=dict,
        description="Where bodies begin and end in z that are shorter than the length, such as "
        "{ blade = [0.0, 11.0] }; layers are thin there, too.",
    )

    @model_validator(mode="after")
    def _thinner_at_ends(self) -> Self:
        equal = self.length / self.layers
        if self.end_size is not None and self.end_size > equal:
            raise ValueError(
                "expected an end_size of at most the thickness of equal layers "
                f"({self.length:g}/{self.layers} = {equal:g}), found {self.end_size:g}"
            )
        return self

    @model_validator(mode="after")
    def _spans_within(self) -> Self:
        for body, (start, end) in self.spans.items():
            if not start < end <= self.length:
                raise ValueError(
                    f"expected spans that increase, up to the length {self.length:g}, found "
                    f"{body} = [{start:g}, {end:g}]"
                )
        return self

    def finer(self, factor: float) -> Self:
        """The same extrusion with thinner layers by a factor."""
        end = self.end_size and self.end_size / factor
        layers = math.ceil(self.layers * factor - 1e-9)
        return self.model_copy(update={"layers": layers, "end_size": end})

    def span(self, body: str) -> tuple[float, float]:
        """Begin and end of a body in z."""
        return self.spans.get(body, (0.0, self.length))

    def shared(self, *bodies: str) -> float:
        """Length that all of some bodies have."""
        starts, ends = zip(*map(self.span, bodies), strict=True)
        return float(min(ends) - max(starts))


class Part(Table):
    """Elements near a centre, which are all that is kept of a mesh."""

    centre: Point = Field(
        description="Centre of a circle in the plane, of a cylinder along the extrusion of plane "
        "bodies, or, with three coordinates, of a ball in solid ones."
    )
    radius: Positive = Field(
        description="Elements within this distance from the centre are kept. The facets around "
        "them that were inside a body are its boundary BODY_cut."
    )


class Geometry(Table):
    """Source of the mesh: a template or a file."""

    template: Name | None = Field(
        default=None,
        description="Name of a geometry template that comes with fretfe. Exactly one of template "
        "and file must be given.",
    )
    parameters: dict[Name, Number] = Field(
        default={},
        description="Parameters of the template, or of a .geo file, that differ from its defaults.",
    )
    order: int = Field(
        default=2,
        strict=True,
        ge=1,
        le=2,
        description="Order of the mesh made from a template, a .geo or a CAD file: 1 straight, "
        "2 curved edges. A mesh file has its own order.",
    )
    file: Text | None = Field(
        default=None,
        description="Geometry or mesh file, relative to the case file's folder: .msh, .geo, .step, "
        ".stp, .brep, .xdmf or .inp.",
    )
    facets: Text | None = Field(
        default=None,
        description="XDMF file with the numbers of the facets, where 'file' does not have them.",
    )
    size: Positive | None = Field(
        default=None,
        description="Element size on the contact surfaces of a CAD file, in length units; that of "
        "the first mesh of solids that refine themselves. Without it the mesh is for "
        "edges.tolerance, by default 0.1; solids need it unless they sweep a section.",
    )
    merge: Positive | None = Field(
        default=None,
        description="Distance up to which nodes of a body in a mesh file become one, in length "
        "units. Without it double nodes are refused.",
    )
    bodies: dict[Name, Selector] = Field(
        default={}, description="What the names of bodies stand for in a CAD, XDMF or .inp file."
    )
    boundaries: dict[Name, BoundarySelector] = Field(
        default={},
        description="What the names of boundaries stand for in a CAD, XDMF or .inp file.",
    )
    solid: Solid | None = Field(default=None, description="Extrude plane bodies into solids.")
    part: Part | None = Field(
        default=None, description="Keep a part of the bodies only, as a sub-model has."
    )

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.template is None) == (self.file is None):
            found = "neither" if self.file is None else "both"
            raise ValueError(f"expected exactly one of 'template' and 'file', found {found}")
        given = self.model_fields_set - {"template", "file", "part"}
        if self.file is not None:
            if problem := file_problem(self.file, given, self.bodies, self.boundaries):
                raise ValueError(problem)
        elif wrong := sorted(given - {"parameters", "order", "solid"}):
            keys = " and ".join(map(repr, wrong))
            raise ValueError(f"expected {keys} with a file only, found together with 'template'")
        return self


class Contact(Table):
    """Two surfaces that may touch, with Coulomb friction between them."""

    surface1: Text = Field(
        description="Physical group of the surface on body 1 (the upper body: the local y axis, "
        "normal of body 2, points into it)."
    )
    surface2: Text = Field(
        description="Physical group of the surface on body 2. The reported shear acts on body 2."
    )
    friction: Friction = Field(
        description="Coulomb friction coefficient, >= 0: a number, or a table over time, along "
        "the surface, over pressure or temperature."
    )
    friction_from: NotNegative = Field(
        default=0.0,
        description="Time after which friction acts: steps up to and including this time are "
        "frictionless. Must be the time of a step; 0 means friction in every step.",
    )
    layer: Layer | None = Field(
        default=None,
        description="Layer that gives under tractions: its stiffness, or a thin coating.",
    )
    gap: Text | None = Field(
        default=None,
        description="Text file with the column gap and with arc, or with x, y (and z), relative to "
        "the folder of the case file: what is added to the gap between the surfaces.",
    )
    multipliers: Literal["finer", "surface1", "surface2"] = Field(
        default="finer",
        description="Surface that carries the unknown contact tractions: the one with the finer "
        'mesh at the contact ("finer"), "surface1" or "surface2".',
    )

    @property
    def rough(self) -> bool:
        """True if there may be friction at some time and place."""
        return isinstance(self.friction, InFile) or self.largest_friction > 0

    @property
    def largest_friction(self) -> float:
        """Largest coefficient; NaN if that stands in a file."""
        match self.friction:
            case OverTime() | OverArc() | OverPressure() | OverHeat():
                return max(self.friction.values)
            case InFile():
                return math.nan
        return self.friction


# Depths at which the stress is written; far more than a figure can show.
MOST_DEPTHS = 10
# Stations of a front of solids: about ten on each quarter of an ellipse.
STATIONS = 40


class Edges(Table):
    """Accuracy of the edge factors, for which a mesh refines itself; stations of solids."""

    tolerance: Positive | None = Field(
        default=None,
        le=0.1,
        description="Relative change of K_N, ΔK_T and the slip-zone lengths from one mesh to the "
        "next, at every contact edge, of solids of K_N and ΔK at every station not near an end, "
        "below which the mesh is fine enough; 0 < tolerance <= 0.1.",
    )
    unknowns: Annotated[int, Field(strict=True, ge=1, le=10_000_000)] = Field(
        default=200_000,
        description="Number of displacements of the largest mesh that is solved; refinement ends "
        "there.",
    )
    stations: Annotated[int, Field(strict=True, ge=8, le=1000)] = Field(
        default=STATIONS,
        description="Number of stations, evenly spaced, on each contact front of solids.",
    )
    local: StrictBool = Field(
        default=True,
        description="Whether the plane problem next to every station of solids is solved, which "
        "gives its slip zones where the elements of the bodies do not resolve them.",
    )
    ends: StrictBool = Field(
        default=False,
        description="Whether parts around the free end with the largest |ΔK| are solved after the "
        "run, as by fretfe submodel --run. It takes geometry.solid.",
    )
    reference_length: Positive | None = Field(
        default=None,
        description="Length at which K_N, K_T and K_I are told at edges between unlike "
        "materials with friction; without it that of the slip zone that they predict.",
    )


class Support(Table):
    """A boundary with displacement components, or one along a direction, held at zero."""

    boundary: Text = Field(description="Physical group of the boundary.")
    fix: tuple[HeldAlong, ...] = Field(
        default=(),
        min_length=1,
        description='Components held at zero: a list of "x", "y", "z", of sectors also "radial" '
        'and "tangential", which are directions about the axis of the sector. Exactly one of fix '
        "and direction must be given.",
    )
    direction: Vector | None = Field(
        default=None,
        description="Direction along which the boundary is held, as on inclined rollers: a vector "
        "(its length does not matter). Across it the boundary is free.",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if bool(self.fix) == (self.direction is not None):
            found = "both" if self.fix else "neither"
            raise ValueError(f"expected exactly one of 'fix' and 'direction', found {found}")
        return self

    @property
    def holds_along_z(self) -> bool:
        """True if the boundary cannot move along z."""
        if self.direction is None:
            return "z" in self.fix
        return len(self.direction) == 3 and not any(self.direction[:2])


# Far more sectors than a disc has: with more of them neighbours hardly turn against each other.
MOST_SECTORS = 1000


class Symmetry(Table):
    """A sector of a disc: of two boundaries each is the other one turned about an axis."""

    type: Literal["cyclic"] = Field(
        description='"cyclic": the bodies are one of several equal sectors around an axis, and so '
        "are their loads."
    )
    boundary1: Text = Field(description="Physical group of one side of the sector.")
    boundary2: Text = Field(
        description="Physical group of the other side, which is the first one turned about the "
        "axis by a full turn over the number of sectors, in either sense."
    )
    sectors: int = Field(
        strict=True,
        ge=2,
        le=MOST_SECTORS,
        description=f"Number of equal sectors in a full turn; 2 to {MOST_SECTORS}.",
    )
    centre: Point = Field(description="A point on the axis, in length units.")
    axis: Vector = Field(
        default=(0.0, 0.0, 1.0),
        description="Direction of the axis (its length does not matter); [0, 0, 1] in a plane "
        "model.",
    )

    @model_validator(mode="after")
    def _two_sides(self) -> Self:
        if self.boundary1 == self.boundary2:
            raise ValueError(f"expected two boundaries, found {self.boundary1!r} twice")
        return self


class TiedParts(Table):
    """Two boundaries of parts of one body that are bonded to each other."""

    boundary1: Text = Field(description="Physical group of the boundary of one part.")
    boundary2: Text = Field(
        description="Physical group of that of another part of the same body, in the same place. "
        "One of the two may reach beyond the other; their nodes need not match."
    )

    @model_validator(mode="after")
    def _two_boundaries(self) -> Self:
        if self.boundary1 == self.boundary2:
            raise ValueError(f"expected two boundaries, found {self.boundary1!r} twice")
        return self


# Cycles that solids are given at most to become steady, beyond those of the case.
MORE_CYCLES = 20


class Cycle(Table):
    """The load cycle that is evaluated, and repeated cycles."""

    start: NotNegative | None = Field(
        default=None,
        description="Time of the first step of the evaluated cycle; without it and 'end' that is "
        "the last period of the slowest wave.",
    )
    end: Positive | None = Field(
        default=None, description="Time of the last step of the cycle; later than start."
    )
    until_steady: bool = Field(
        default=True,
        strict=True,
        description="Repeated blocks of the load history are solved until one of them leaves the "
        "contact as it found it; those that follow have its states and are not solved again. "
        "false: every step is solved.",
    )
    more: int | None = Field(
        default=None,
        strict=True,
        ge=0,
        le=1000,
        description="Largest number of cycles that are solved after those of the load history, "
        f"until the last one is steady; 0: none. Default: {MORE_CYCLES} for solids whose loads end "
        "with waves, unless until_steady is false; none in the plane.",
    )

    @property
    def most_more(self) -> int:
        """Largest number of cycles that may be added between solids."""
        if self.more is None:
            return MORE_CYCLES if self.until_steady else 0
        return self.more

    @property
    def given(self) -> tuple[float, float] | None:
        """Start and end, if the case gives them."""
        return None if self.start is None or self.end is None else (self.start, self.end)

    @model_validator(mode="after")
    def _ends_after_start(self) -> Self:
        if (self.start is None) != (self.end is None):
            missing = "start" if self.start is None else "end"
            raise ValueError(f"expected both start and end, or none of them, found no {missing}")
        if self.given is not None and self.given[1] <= self.given[0]:
            raise ValueError(f"expected start < end, found start = {self.start}, end = {self.end}")
        return self


class Start(Table):
    """State of another run, from which this case goes on."""

    results: Text = Field(
        alias="from",
        description="Results folder of a run of the same bodies on the same mesh, relative to the "
        "folder of the case file. Loads until 'time' must be those of that run; friction, layers, "
        "given gaps and all that follows may be others.",
    )
    time: Positive = Field(
        description="Time of a step of both histories, until which the states are those of the run."
    )


def _named_or_listed(value: Any) -> str:
    return f"{TAG}times" if isinstance(value, list | tuple) else f"{TAG}name"


def _increasing(depths: tuple[float, ...]) -> tuple[float, ...]:
    if any(later <= before for before, later in pairwise(depths)):
        raise ValueError(f"expected increasing depths, found {list(depths)}")
    return depths


class Output(Table):
    """Output besides the results file."""

    fields: Annotated[
        Annotated[Literal["extremes", "last", "none", "all"], Tag(f"{TAG}name")]
        | Annotated[tuple[NotNegative, ...], Tag(f"{TAG}times")],
        Discriminator(_named_or_listed),
    ] = Field(
        default="extremes",
        description="Steps whose fields are written, for pictures and ParaView: "
        '"extremes" (the two load extremes of the evaluated cycle, and the last step), "last", '
        '"none", "all" (of added cycles the evaluated one alone) or a list of times, each the time '
        "of a step.",
    )
    stress_depths: Annotated[
        tuple[NotNegative, ...], Field(max_length=MOST_DEPTHS), AfterValidator(_increasing)
    ] = Field(
        default=(),
        description="Depths below the contact surfaces, in length units, at which the stress of "
        "both bodies is written through the evaluated cycle, for parameters on critical planes: an "
        "increasing list of at most 10 numbers >= 0, where 0 is the surface. Empty: none. Of "
        "solids any of them asks for the stress around the stations of the fronts, at depths that "
        "fretfe chooses. The backend fem only.",
    )
    tractions: Literal["all", "cycle", "extremes"] | None = Field(
        default=None,
        description="States whose tractions, slip and status are kept in results.h5: "
        '"all", "cycle" (those of the evaluated cycle, and those of "extremes"), "extremes" (the '
        "unloaded state, the load extremes, the ends of the last half cycles, the last state). "
        'Without it "all", or "cycle" if there are more than 1000 states. Numbers and histories '
        "of edges and contacts are those of all states in any case.",
    )
