# SPDX-License-Identifier: LGPL-3.0-or-later
"""The geometry templates: where they are, and the parameters that they take.

A template is one Gmsh script (.geo). Its DefineConstant block defines the parameters with their
defaults, ranges and descriptions, which are read here, without Gmsh. What the parameters must
satisfy together is checked by the script itself when Gmsh reads it (`gmsh_model.script_model`).
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from fretfe.case.messages import found
from fretfe.errors import CaseError, MeshError
from fretfe.files import require_file
from fretfe.plugins import TEMPLATES, plug_ins, plugged_file

# DefineConstant[ size = {0.01, Min 1e-5, Max 1, Name "Parameters/01 Element size [mm]"}, ... ];
_BLOCK = re.compile(r"DefineConstant\s*\[(.*?)\n\s*\];", re.DOTALL)
_PARAMETER = re.compile(
    r"""(?P<name>\w+) \s*=\s* \{
        \s* (?P<default>[^,]+),
        \s* Min \s+ (?P<minimum>[^,]+),
        \s* Max \s+ (?P<maximum>[^,]+),
        \s* Name \s+ "Parameters/\d+ [ ] (?P<description>[^"\[]+) [ ] \[ (?P<unit>[^]]+) \]"
        (?P<whole>, \s* Step \s+ 1\b)?""",
    re.VERBOSE,
)


# Part of a value by which it may leave its range: products such as 0.2 * 1.5 do.
ROUND_OFF = 1e-9


@dataclass(frozen=True)
class Parameter:
    """A number that a template takes, with its default and its range (both ends allowed).

    Only whole numbers are allowed where the script says `Step 1`.
    """

    name: str
    default: float
    minimum: float
    maximum: float
    description: str
    unit: str
    whole: bool = False

    @property
    def is_mesh_size(self) -> bool:
        """True if it is about the mesh only: the size of elements or its growth."""
        return self.name == "growth" or self.is_size

    @property
    def is_size(self) -> bool:
        """True if it is the size of elements."""
        return self.name.endswith("size")

    def in_unit(self, length: str) -> Parameter:
        """The same parameter in another unit of length, if it is a length."""
        # Not loaded by a process that only reads a file.
        from fretfe.case.units import MILLIMETRES

        if self.unit != "mm" or length not in MILLIMETRES:
            return self
        unit = MILLIMETRES[length]
        low, default, high = (x / unit for x in (self.minimum, self.default, self.maximum))
        return replace(self, default=default, minimum=low, maximum=high, unit=length)


@dataclass(frozen=True)
class Template:
    """A parametric geometry in a .geo file; the summary is the first sentence of its comment."""

    name: str
    path: Path
    summary: str
    parameters: tuple[Parameter, ...]
    solid: bool


def template_directory() -> Path:
    """The folder `meshes`: inside the installed package, or next to it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "meshes"
    return installed if installed.is_dir() else package.parent / "meshes"


def _own_names() -> list[str]:
    return sorted(path.stem for path in template_directory().glob("*.geo"))


def template_names() -> tuple[str, ...]:
    """Names of all templates, sorted, then those of other packages."""
    return tuple(dict.fromkeys((*_own_names(), *(each.name for each in plug_ins(TEMPLATES)))))


def template_file(name: str) -> Path | None:
    """The script of a template, that of another package if fretfe has none; None without one.

    Raises:
        DependencyError: Another package fails to give its file.
    """
    if name in _own_names():
        return template_directory() / f"{name}.geo"
    return plugged_file(TEMPLATES, name)


def find_template(name: str, where: str = "geometry.template", length: str = "mm") -> Template:
    """The template of this name.

    Args:
        name: of the template.
        where: the name was given, for the message.
        length: label of the unit of length, to which defaults and ranges are converted. The
            numbers of a label that is not known count as mm.

    Raises:
        CaseError: There is no such template.
        DependencyError: Another package fails to give its file.
    """
    path = template_file(name)
    if path is None:
        names = template_names()
        raise CaseError(
            f"{where}: no template is called '{name}'{did_you_mean(name, names)};"
            f" there are: {', '.join(names)} (in {template_directory()})"
        )
    template = read_template(path)
    parameters = tuple(each.in_unit(length) for each in template.parameters)
    return replace(template, name=name, parameters=parameters)


def read_template(path: Path) -> Template:
    """The Gmsh script in a file, whoever wrote it, with the file as its name.

    Its parameters are those that are defined as in the templates; there may be none.

    Raises:
        MeshError: The file cannot be read.
    """
    require_file(path, "a Gmsh script", MeshError)
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path}: cannot read the Gmsh script: {error.strerror}") from error
    try:
        parameters = _read_parameters(text)
    except ValueError:
        # numbers written as formulas: the script knows its defaults, nobody else does
        parameters = ()
    return Template(str(path), path, _read_summary(text), parameters, "Physical Volume" in text)


def check_parameters(template: Template, values: Mapping[str, float]) -> dict[str, float]:
    """All parameters of the template: the given values, and the defaults of the others.

    Raises:
        CaseError: A name is unknown, or a value is no number or outside its range. Everything
            found is in the message.
    """
    known = {parameter.name: parameter for parameter in template.parameters}
    problems = [
        f"no parameter is called '{name}'{did_you_mean(name, known)}"
        for name in values
        if name not in known
    ]
    if problems:
        problems.append(f"the parameters are: {', '.join(known)}")
    problems += [
        problem
        for name, value in values.items()
        if name in known and (problem := _range_problem(known[name], value))
    ]
    if problems:
        raise parameter_error(template, problems)
    return {
        name: min(max(float(values.get(name, each.default)), each.minimum), each.maximum)
        for name, each in known.items()
    }


def parameter_error(template: Template, problems: Iterable[str]) -> CaseError:
    """The error that lists what is wrong with the parameters of a template."""
    lines = "".join(f"\n  - {problem}" for problem in problems)
    return CaseError(f"geometry.parameters of template '{template.name}':{lines}")


def _read_summary(text: str) -> str:
    """First sentence of the comment below the licence, without the slashes."""
    _, _, comment = text.partition("\n//\n")
    words = " ".join(line.removeprefix("//").strip() for line in comment.splitlines())
    return words.partition(". ")[0]


def _read_parameters(text: str) -> tuple[Parameter, ...]:
    block = _BLOCK.search(text)
    return tuple(
        Parameter(
            name=match["name"],
            default=float(match["default"]),
            minimum=float(match["minimum"]),
            maximum=float(match["maximum"]),
            description=match["description"],
            unit=match["unit"],
            whole=match["whole"] is not None,
        )
        for match in _PARAMETER.finditer(block.group(1) if block else "")
    )


def _range_problem(parameter: Parameter, value: object) -> str | None:
    kind = "whole number" if parameter.whole else "number"
    expected = f"expected a {kind} from {parameter.minimum:g} to {parameter.maximum:g}"
    if parameter.unit != "-":
        expected += f" {parameter.unit}"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return f"{parameter.name}: {expected}, found {found(value)}"
    slack = ROUND_OFF * abs(value)
    inside = parameter.minimum - slack <= value <= parameter.maximum + slack
    if not inside or (parameter.whole and value % 1):
        return f"{parameter.name}: {expected}, found {value:g}"
    return None


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """The valid names that a wrong one resembles, as a hint to add to a message; else nothing."""
    close = difflib.get_close_matches(name, list(names), n=2)
    return f" (did you mean {' or '.join(close)}?)" if close else ""
