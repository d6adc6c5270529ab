# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table `[units]`, units of which the labels are known, and numbers that hardly fit them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from pydantic import Field, model_validator

from fretfe.case.base import Table, Text

if TYPE_CHECKING:
    from fretfe.case.bodies import AnyBody
    from fretfe.case.model import Case

# Millimetres in the units of length that have these labels.
MILLIMETRES = {
    "um": 1e-3,
    "µm": 1e-3,  # micro sign
    "μm": 1e-3,  # Greek letter
    "mm": 1.0,
    "cm": 10.0,
    "m": 1e3,
    "km": 1e6,
    "in": 25.4,
    "inch": 25.4,
    "ft": 304.8,
}
# Units by their labels, in SI.
POUND = 0.45359237
INCH = 0.0254
METRES = {label: size / 1e3 for label, size in MILLIMETRES.items()}
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": POUND * 9.80665}
PSI = FORCES["lbf"] / INCH**2
STRESSES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "N/mm^2": 1e6, "N/mm²": 1e6, "GPa": 1e9}
STRESSES |= {"psi": PSI, "ksi": 1e3 * PSI, "Msi": 1e6 * PSI}
DENSITIES = {"kg/m^3": 1.0, "g/cm^3": 1e3, "t/mm^3": 1e12, "lb/in^3": POUND / INCH**3}
TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}
# Other ways to write units.
SYNONYMS = {"": "1", "-": "1", "sec": "s", "C": "°C", "degC": "°C", "um": "µm", "inch": "in"}
SYNONYMS |= {"N/mm^2": "MPa"}
# Labels without a table.
LENGTH = "mm"
FORCE = "N"
# Labels of units that belong together may differ by this part, as digits of conversions do.
SAME_UNIT = 1e-6


def stress_label(units: Mapping[str, Any]) -> str:
    """Label of force/length² with the labels of a table `[units]`, which may lack some."""
    length, force = units.get("length", LENGTH), units.get("force", FORCE)
    if size := _stress(length, force):
        known = (each for each, own in STRESSES.items() if abs(own / size - 1) < SAME_UNIT)
        return next(known, f"{force}/{length}²")
    return f"{force}/{length}²"


def _stress(length: Any, force: Any) -> float | None:
    """Force/length² in Pa; None if a label is not known."""
    known = isinstance(length, str) and isinstance(force, str)
    if not (known and length in METRES and force in FORCES):
        return None
    return FORCES[force] / METRES[length] ** 2


def unit_size(unit: str) -> tuple[float, str] | None:
    """Size of a unit in SI, and of what; None if it is not known."""
    written = unit.strip("[](){}<>\"' ")
    of_kinds = (("stress", STRESSES), ("force", FORCES), ("length", METRES), ("time", TIMES))
    for of, known in of_kinds:
        if written in known:
            return known[written], of
    force, _, length = (each.strip() for each in written.partition("/"))
    if force in FORCES and length in METRES:
        return FORCES[force] / METRES[length], "force/length"
    return None


def same_unit(one: str, two: str) -> bool:
    """True if two units are written alike but for roots, products, brackets and spaces."""
    return _unit(one) == _unit(two)


def equal_units(one: str, two: str) -> bool:
    """True if two units are written alike, or known to be of the same size."""
    own, other = unit_size(one), unit_size(two)
    if own is None or other is None or own[1] != other[1]:
        return same_unit(one, two)
    return abs(own[0] / other[0] - 1) < SAME_UNIT


def _unit(text: str) -> str:
    text = re.sub(r"√\(?([^\s)·*/]+)\)?|sqrt\(([^)]*)\)", r"\1\2^0.5", text)
    text = re.sub(r"[\s·*]+", "*", text.strip()).replace("^(1/2)", "^0.5").replace("**", "^")
    bare = re.sub(r"[\[\](){}<>\"']", "", text).replace("²", "^2").replace("μ", "µ")
    return SYNONYMS.get(bare, bare)


class Units(Table):
    """Labels for the output; numbers are never converted, so use one consistent set.

    Only what states its unit is converted to that of the labels: lengths of STEP files, defaults
    and ranges of templates, and constants of material files.
    """

    length: Text = Field(default=LENGTH, description="Label of the unit of length.")
    force: Text = Field(default=FORCE, description="Label of the unit of force.")
    stress: Text = Field(
        default="MPa",
        description="Label of the unit of stress, which is force/length^2. Without it that of the "
        "other two labels.",
    )
    time: Text = Field(default="s", description="Label of the unit of the clock of the histories.")

    @model_validator(mode="before")
    @classmethod
    def _stress_of_the_others(cls, data: Any) -> Any:
        if isinstance(data, dict) and "stress" not in data and {"length", "force"} & data.keys():
            return {**data, "stress": stress_label(data)}
        return data

    @model_validator(mode="after")
    def _belong_together(self) -> Self:
        """Labels that contradict each other would put a wrong unit to every result."""
        expected, found = _stress(self.length, self.force), STRESSES.get(self.stress)
        if expected and found and abs(found / expected - 1) > SAME_UNIT:
            label = stress_label({"length": self.length, "force": self.force})
            raise ValueError(
                f"expected stress = {label!r}, which is force/length² with force = {self.force!r} "
                f"and length = {self.length!r}, found {self.stress!r}, which is "
                f"{found / expected:.6g} of it"
            )
        return self


class _Materials(NamedTuple):
    """A constant of all materials, in SI.

    Attributes:
        lowest: of it.
        highest: of it.
        words: for what is below and above.
        usual: least and largest of most solids.
        written: units in which it is found in tables, by their labels.
    """

    lowest: float
    highest: float
    words: tuple[str, str]
    usual: tuple[float, float]
    written: Mapping[str, float]


# From soft rubber to five times diamond; from foam to osmium.
STIFFNESS = _Materials(
    1e6, 5e12, ("softer", "stiffer"), (1e9, 1e12), {"Pa": 1.0, "MPa": 1e6, "GPa": 1e9}
)
DENSITY = _Materials(10.0, 25e3, ("lighter", "denser"), (500.0, 25e3), DENSITIES)


def stiffness_doubts(case: Case) -> Iterator[str]:
    """Bodies whose stiffness no material has in the unit of the case, in words."""
    stiffnesses = {name: _stiffness(body) for name, body in case.bodies.items()}
    values = {f"bodies.{name}.{key}": value for name, (key, value) in stiffnesses.items()}
    unit = STRESSES.get(case.units.stress) or _stress(case.units.length, case.units.force)
    return _doubts(case, values, case.units.stress, unit, STIFFNESS)


def unit_doubts(case: Case) -> Iterator[str]:
    """Constants of bodies that no material has in the units of the case, in words."""
    yield from stiffness_doubts(case)
    units = case.units
    values = {
        f"bodies.{name}.density": body.density
        for name, body in case.bodies.items()
        if body.density is not None
    }
    label = f"{units.force}·{units.time}²/{units.length}⁴"
    unit = None
    if units.force in FORCES and units.time in TIMES and units.length in METRES:
        unit = FORCES[units.force] * TIMES[units.time] ** 2 / METRES[units.length] ** 4
    yield from _doubts(case, values, label, unit, DENSITY)


def _stiffness(body: AnyBody) -> tuple[str, float]:
    """Young's modulus, or of a crystal its largest stiffness, with the key that gives it."""
    # Imported here: the case, which has bodies, imports this module.
    from fretfe.case.bodies import Crystal

    if isinstance(body, Crystal):
        return "elastic", float(body.elastic.stiffness.max())
    return "young", body.young


def _doubts(
    case: Case, values: Mapping[str, float], label: str, unit: float | None, known: _Materials
) -> Iterator[str]:
    """Values by their keys that no material has; one text for equal ones."""
    alike: dict[float, list[str]] = {}
    for key, value in values.items():
        if unit is not None and not known.lowest <= value * unit <= known.highest:
            alike.setdefault(value, []).append(key)
    origin = "by [units]" if case.units.model_fields_set else "as [units] is not given"
    for value, keys in alike.items():
        assert unit is not None
        high = value * unit > known.highest
        bound = (known.highest if high else known.lowest) / unit
        text = (
            f"{', '.join(keys)}: {value:g} is in {label}, {origin}, and no material is "
            f"{known.words[high]} than {bound:g} {label}"
        )
        low, most = known.usual
        fits = (each for each, size in known.written.items() if low <= value * size <= most)
        if written := next(fits, None):
            text += (
                f". In {written} it would be usual: that is "
                f"{value * known.written[written] / unit:g} {label}; or all numbers of the case "
                "are in other units, which [units] has to say"
            )
        yield text
