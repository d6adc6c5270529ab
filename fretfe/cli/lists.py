# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands about what is there: backends, templates, versions, the schema, pictures of results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment
from fretfe.faults import collecting, guarded, require_none
from fretfe.report.texts import plain_table

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.backends import Installed
    from fretfe.case import Case
    from fretfe.mesh.templates import Parameter, Template

BACKENDS_EXAMPLES = examples("fretfe backends", "fretfe backends pad.toml")
REPORT_EXAMPLES = examples("fretfe report pad")


def backends(
    case: Annotated[
        Path | None, typer.Argument(metavar="CASE", help="Say which backends can solve this case.")
    ] = None,
) -> None:
    """List the installed backends, and why one cannot be used."""
    from fretfe.backends import installed_backends
    from fretfe.case import load_case
    from fretfe.console import Console

    # On every rank: a backend that starts MPI when it is imported waits for the others.
    installed = installed_backends()
    if rank_from_environment() > 0:
        return
    read = load_case(case) if case is not None else None
    Console().print(_backend_table(installed, read))


def _backend_table(backends: tuple[Installed, ...], case: Case | None) -> Table:
    """One row per backend: what it solves, or why it cannot be used or cannot solve the case."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(title="Backends", title_justify="left", box=box.SIMPLE, title_style="bold")
    for header in ("backend", "usable", "package", "what it solves, or why not"):
        table.add_column(header, overflow="fold")
    for installed in backends:
        usable, text = _usable(installed, case)
        table.add_row(installed.name, usable, installed.package, escape(text))
    return table


def _usable(installed: Installed, case: Case | None) -> tuple[str, str]:
    if installed.backend is None:
        return "no", installed.reason
    try:
        reasons = installed.backend.supports(case) if case is not None else ()
    except Exception as error:  # one backend must not hide the others
        reasons = (str(error),)
    return ("no", "\n".join(reasons)) if reasons else ("yes", installed.backend.summary)


TEMPLATES_EXAMPLES = examples("fretfe templates", "fretfe templates dovetail")


def templates(
    name: Annotated[
        str | None, typer.Argument(help="Template whose parameters are listed.")
    ] = None,
) -> None:
    """List the geometry templates, or the parameters of one of them."""
    from fretfe.console import Console
    from fretfe.mesh.templates import find_template, template_names

    def summary(name: str) -> str:
        return find_template(name).summary

    if name is None:
        columns = ("template", "geometry")
        table = _named_table("Templates", columns, template_names(), summary)
    else:
        table = _parameter_table(find_template(name, "NAME"))
    if rank_from_environment() == 0:
        Console().print(table)


MATERIALS_EXAMPLES = examples("fretfe materials", "fretfe materials Ti-6Al-4V")


def materials(
    name: Annotated[
        str | None, typer.Argument(help="Material, or file of one, that is printed.")
    ] = None,
) -> None:
    """List the materials that come with fretfe, or print one of them."""
    from fretfe.case.materials import find_material, material_names, read_material
    from fretfe.console import Console

    if rank_from_environment() > 0:
        return
    if name is not None:
        path = find_material(name, Path())
        read_material(path)
        print(path.read_text("utf-8"), end="")
        return

    def source(name: str) -> str:
        return read_material(find_material(name, Path())).source

    Console().print(_named_table("Materials", ("material", "source"), material_names(), source))


def _named_table(
    title: str, columns: tuple[str, str], names: Iterable[str], text: Callable[[str], str]
) -> Table:
    """One row per name, with a text, or why there is none: one plug-in must not hide the others."""
    from rich.markup import escape

    from fretfe.errors import FretfeError

    table = plain_table(title, columns[:1], text=1)
    table.add_column(columns[1])
    for name in names:
        try:
            said = text(name)
        except FretfeError as error:
            said = f"not usable: {error}"
        table.add_row(escape(name), escape(said))
    return table


def _parameter_table(template: Template) -> Table:
    """One row per parameter of a template."""
    from rich.markup import escape

    title = f"Template {template.name}\n{escape(template.summary)}"
    table = plain_table(title, ("parameter", "default", "range", "unit"), text=1)
    table.add_column("meaning")
    table.columns[3].justify = "left"
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        table.add_row(each.name, f"{each.default:g}", limits, unit, escape(each.description))
    return table


def parameter_rows(template: Template) -> str:
    """The parameters of a template as a table in Markdown."""
    lines = ["| parameter | default | range | unit | meaning |", "|---|---|---|---|---|"]
    for each in template.parameters:
        limits, unit = _range_and_unit(each)
        lines.append(
            f"| `{each.name}` | {each.default:g} | {limits} | {unit} | {each.description} |"
        )
    return "\n".join(lines) + "\n"


def _range_and_unit(parameter: Parameter) -> tuple[str, str]:
    limits = f"{parameter.minimum:g} … {parameter.maximum:g}"
    unit = "" if parameter.unit == "-" else parameter.unit
    return limits + (", whole" if parameter.whole else ""), unit


INFO_EXAMPLES = examples("fretfe info", "mpirun -n 2 fretfe info")


def info() -> None:
    """Show versions, MPI and linear algebra, and what cannot be used."""
    from fretfe.environment import loaded_libraries, reference_blas, versions

    first = rank_from_environment() == 0
    shown = print if first else lambda text: None
    for name, version in versions().items():
        shown(f"{name:12s} {version}")
    for name, tell in (("gmsh", _gmsh_lines), ("dolfinx", _dolfinx_lines)):
        try:
            for line in tell():
                shown(line)
        except Exception as error:  # whatever it is, the rest is told
            shown(f"{name:12s} cannot be used: {error}")
    libraries = loaded_libraries("blas")
    for library in libraries:
        shown(f"{'BLAS':12s} {library}")
    for library in reference_blas(libraries):
        shown(
            f"Warning: {library} is the reference BLAS, which makes factorisations about four "
            "times slower. Install OpenBLAS (Debian: libopenblas0-pthread)."
        )


def _gmsh_lines() -> list[str]:
    from fretfe.mesh.gmsh import import_gmsh

    import_gmsh()
    return []  # its version is that of the package


def _dolfinx_lines() -> list[str]:
    from fretfe.fem import _compat
    from fretfe.fem.bordered import unsymmetric_because

    why = unsymmetric_because()
    facts = {
        **_compat.versions(),
        "MPI ranks": _compat.MPI.COMM_WORLD.size,
        "factors": f"LU: {why}" if why else "symmetric",
    }
    return [f"{name:12s} {fact}" for name, fact in facts.items()]


SCHEMA_EXAMPLES = examples("fretfe schema > case.schema.json")


def schema() -> None:
    """Print the JSON schema of case files."""
    from fretfe.case import case_schema

    print(json.dumps(case_schema(), indent=2))


def report(
    directory: Results,
    station: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CONTACT.FRONT.STATION",
            help="Station of solids to draw beside the worst ones; can be given several times. "
            "Fronts are counted from 1, stations along them from 0; a contact or a front alone is "
            "its station of the largest |ΔK|/(f K_N).",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Make report.html again from the results in a folder.

    Pictures are drawn again if some of them are missing.
    """
    from fretfe.report.page.html import draw_plots, write_report
    from fretfe.report.pictures.folder import lacks_pictures, make_pictures
    from fretfe.results.reader import load_result, read_numbers
    from fretfe.results.run_folder import locked

    if rank_from_environment() > 0:
        return
    read_numbers(directory)
    with collecting(directory) as collected, locked(directory):
        if lacks_pictures(directory):
            print("Drawing the pictures, of which some are missing ...", flush=True)
            guarded("pictures", lambda: make_pictures(directory), lambda _: None)
        plots = draw_plots(load_result(directory), station) if station else None
        path = write_report(directory, plots)
    print(f"Report in {path}")
    require_none(collected.faults, directory)
