# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rig file: pads, specimen and forces that a laboratory has, in the unit of the component."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import AfterValidator, Field, ValidationError, model_validator

from fretfe.case import Body, Units, complaint
from fretfe.case.base import NotNegative, Number, Positive, Table, Text
from fretfe.case.messages import field_problems
from fretfe.case.toml_file import read_tables
from fretfe.errors import CaseError
from fretfe.materials.moduli import contact_modulus

Shape = Literal["cylinder", "flat_rounded", "wedge"]
SHAPES: tuple[Shape, ...] = get_args(Shape)


def _in_order(bounds: tuple[float, float]) -> tuple[float, float]:
    if bounds[0] > bounds[1]:
        raise ValueError(f"expected the smaller bound first, found [{bounds[0]:g}, {bounds[1]:g}]")
    return bounds


# Of the template; the formulas of wedges are for shallow ones.
Angle = Annotated[Positive, Field(le=20)]
Bounds = Annotated[tuple[Positive, Positive], AfterValidator(_in_order)]
Angles = Annotated[tuple[Angle, Angle], AfterValidator(_in_order)]
FromZero = Annotated[tuple[NotNegative, NotNegative], AfterValidator(_in_order)]


class Pad(Table):
    """Pads that can be made, and their material."""

    shapes: tuple[Shape, ...] = Field(
        default=("cylinder", "flat_rounded"), min_length=1, description="Shapes to look at."
    )
    young: Positive = Field(description="Young's modulus, in stress units.")
    poisson: Number = Field(gt=-1, lt=0.5, description="Poisson's ratio.")
    radius: Bounds | None = Field(
        default=None, description="Radius of a cylinder, or of the rounded ends of a flat."
    )
    flat_half_width: Bounds | None = Field(default=None, description="Half of the width of a flat.")
    angle: Angles | None = Field(
        default=None, description="Angle of a wedge to the specimen, degrees; at most 20."
    )
    half_width: Positive = Field(description="Half of the width of a pad.")
    height: Positive = Field(description="Height of a pad.")

    @model_validator(mode="after")
    def _has_bounds(self) -> Self:
        needs = {
            "cylinder": ("radius",),
            "flat_rounded": ("radius", "flat_half_width"),
            "wedge": ("angle",),
        }
        for shape in self.shapes:
            for key in needs[shape]:
                if getattr(self, key) is None:
                    raise ValueError(f"expected {key!r} for the shape {shape!r}, found none")
        return self


class Specimen(Table):
    """The flat specimen."""

    young: Positive = Field(description="Young's modulus, in stress units.")
    poisson: Number = Field(gt=-1, lt=0.5, description="Poisson's ratio.")
    thickness: Positive = Field(description="Thickness, from the contact to the base.")
    half_width: Positive = Field(description="Half of its length in the plane of the model.")
    yield_stress: Positive | None = Field(
        default=None, description="Yield stress of the weaker material, in tension."
    )


class Forces(Table):
    """Forces of the rig, per unit length of the pad, and the bulk stress."""

    normal: Bounds = Field(description="Normal force P, its extremes if it cycles.")
    shear: FromZero = Field(description="Amplitude of the shear force Q.")
    normal_amplitude: FromZero | None = Field(
        default=None,
        description="Amplitude of P, in step with Q, to match K_I too; without it P is constant.",
    )
    bulk_range: NotNegative = Field(default=0.0, description="Range of the bulk stress to apply.")
    bulk_phase: Number = Field(default=0.0, description="Lag of it behind Q, degrees.")

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if self.normal_amplitude is not None and self.bulk_range > 0:
            raise ValueError(
                "expected a normal force that cycles or a bulk stress, found both "
                "'normal_amplitude' and 'bulk_range'"
            )
        return self


class Rig(Table):
    """A fretting rig.

    Attributes:
        title: shown in the output.
        units: labels, which must be those of the component.
        pad: pads.
        specimen: specimen.
        forces: forces.
        friction: coefficient of the pair, if known to be another than that of the component.
        process_zone: length over which the fields should agree.
    """

    title: Text = "rig"
    units: Units = Field(default_factory=Units)
    pad: Pad
    specimen: Specimen
    forces: Forces
    friction: Positive | None = None
    process_zone: Positive | None = None

    @property
    def e_star(self) -> float:
        """Composite modulus in plane strain."""
        pad = Body(young=self.pad.young, poisson=self.pad.poisson)
        specimen = Body(young=self.specimen.young, poisson=self.specimen.poisson)
        return contact_modulus(pad, specimen, "strain")


def load_rig(path: Path | str) -> Rig:
    """Read a rig file.

    Raises:
        CaseError: the file cannot be read, is not TOML, or is not a valid rig: a line for each
            problem.
    """
    source = Path(path)
    return parse_rig(read_tables(source, "a rig file (TOML)"), source)


def parse_rig(data: dict[str, Any], source: Path | str = "rig.toml") -> Rig:
    """Validate the contents of a rig file.

    Raises:
        CaseError: as `load_rig`.
    """
    try:
        return Rig.model_validate(data)
    except ValidationError as error:
        problems = field_problems(error, Rig)
        lines = [complaint(Path(source), *problem) for problem in problems]
        raise CaseError("\n".join(lines)) from None
