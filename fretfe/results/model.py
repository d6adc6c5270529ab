# SPDX-License-Identifier: LGPL-3.0-or-later
"""The results of a run in memory, whoever computed or read them.

T is the number of states (steps plus the unloaded state 0), d the number of space dimensions.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.caution import Caution, about
from fretfe.errors import CaseError, ConvergenceError, ModelError, OutputError
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.headline import Headline
from fretfe.evaluate.limits import ModelLimit
from fretfe.evaluate.refinement import Refinement
from fretfe.evaluate.stress import (
    LocalParameters,
    StressHistory,
    StressParameters,
    local_parameters,
    stress_parameters,
)
from fretfe.faults import Fault
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import History
from fretfe.mesh.mesh import BodyMesh
from fretfe.reason import Kind
from fretfe.results.hdf5_file import STRESSES, read_stress
from fretfe.results.quantities import EDGES, SOLIDS, STATIONS, axis_label, unit
from fretfe.results.station_stress import STATION_STRESSES, StationStress, read_station_stress
from fretfe.results.tables import (
    edge_records,
    make_dataset,
    require,
    solid_records,
    station_records,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

# Columns of the card in a notebook, those that there are.
CARD = {
    "contact", "edge", "half_width", "k_n", "k_n_spread", "k_t_range", "k_t_range_spread",
    "slip_2", "slip_2_spread", "steady", "normal_force", "contact_area", "stick_area",
    "largest_pressure", "dissipation",
}  # fmt: skip


@dataclass(frozen=True)
class Result:
    """A solved case; T states, state 0 unloaded.

    Attributes:
        case: as it was run.
        loads: the T states that were solved, fewer than the case has if `failure` is set; its
            cycle is then None.
        contacts: resultants, fronts and slip zones of each contact, in the order of the case.
        backend: name of the backend, which the caller of the backend fills in.
        root_solution: `solution` on rank 0; None on the others.
        notes: what was assumed, in words.
        failure: why not all steps were solved, or None.
        bodies: the meshes, by body; empty without meshes, or on ranks other than 0.
        versions: of what the backend is made of; of everything that took part if read from files.
        seconds: wall time by phase.
        ranks: number of processes.
        refinement: how the mesh refined itself, or None.
        limits: quantities that must be small for the model to hold, with what was found.
        directory: folder with the files of the run; None if nothing was written.
        faults: errors of fretfe itself, for which something is unknown.
    """

    case: Case
    loads: History
    contacts: tuple[Contact, ...]
    root_solution: Solution | None
    backend: str = ""
    notes: tuple[str, ...] = ()
    failure: ConvergenceError | None = None
    bodies: Mapping[str, BodyMesh] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    ranks: int = 1
    refinement: Refinement | None = None
    limits: tuple[ModelLimit, ...] = ()
    directory: Path | None = None
    faults: tuple[Fault, ...] = ()

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """All that a reader must know, of the run and of each contact."""
        refinement = self.refinement
        run: tuple[Caution, ...] = ()
        if refinement is not None and not refinement.converged:
            run = (*about("", "", [Kind.NOT_CONVERGED.found(why=refinement.reason)]),)
        return (*run, *(each for contact in self.contacts for each in contact.warnings))

    @cached_property
    def headline(self) -> Headline:
        """The worst place, its numbers and whether to trust them, with the first lines of a run.

        Raises:
            OutputError: if what sub-models found at an end of a front cannot be read.
        """
        # It reads files of results, which stand behind this.
        from fretfe.results.first_lines import headline_of

        return headline_of(self)

    @property
    def solution(self) -> Solution:
        """Steps as they were solved, and tractions along the contacts.

        Raises:
            OutputError: on ranks other than 0, which have none.
        """
        if self.root_solution is None:
            raise OutputError(
                f"{self.directory or self.case.source}: expected tractions along the contacts, "
                "found none: they are those of process 0"
            )
        return self.root_solution

    @property
    def solid(self) -> bool:
        """True if the bodies are solids."""
        return any(contact.solid for contact in self.contacts)

    def unit(self, kind: str) -> str:
        """Unit of a kind of quantity, a key of `fretfe.results.quantities.UNITS`."""
        return unit(kind, self.case.units, solid=self.solid)

    def axis_label(self, name: str) -> str:
        """Symbol and unit of a number of a station or a contact: ``K_N [MPa/√mm]``."""
        return axis_label(name, self.case.units, solid=self.solid)

    def edges(self) -> list[dict[str, Any]]:
        """One flat record of numbers and texts for each edge of plane contacts."""
        return [] if self.solid else edge_records(self.contacts)

    def records(self) -> list[dict[str, Any]]:
        """The records of `edges`; of solids one for each contact in its last state."""
        return solid_records(self.contacts) if self.solid else self.edges()

    def history(self, contact: str, front: str, number: int = 0) -> dict[str, Array]:
        """Histories of one station, T numbers each.

        Args:
            contact: name of the contact.
            front: "left" or "right"; of solids "front 1" and so on.
            number: of the station along the front, from 0.

        Returns:
            ``time``, ``k_n``, ``k_t``, ``k_s``, ``k_i``, ``position`` and each load as
            ``loads.NAME``.

        Raises:
            CaseError: if there is no such station.
        """
        fronts = {
            f"{each.name} {front.name}": front for each in self.contacts for front in each.fronts
        }
        wanted = f"{contact} {front}"
        if wanted not in fronts:
            raise CaseError(
                f"{self.case.source}: expected one of the {'fronts' if self.solid else 'edges'} "
                f"{', '.join(fronts) or '(none)'}, found {wanted}"
            )
        stations = fronts[wanted].stations
        if not 0 <= number < len(stations):
            raise CaseError(
                f"{self.case.source}: expected a station of {wanted} from 0 to "
                f"{len(stations) - 1}, found {number}"
            )
        one, loads = stations[number], self.loads
        return {
            "time": loads.times,
            **{f"loads.{name}": loads.values[:, n] for n, name in enumerate(loads.channels)},
            **{name: getattr(one, name) for name in ("k_n", "k_t", "k_s", "k_i", "position")},
        }

    def find(self, name: str) -> tuple[Contact, Front, Station]:
        """Return an edge or a station by its name, with its contact and front.

        Args:
            name: "CONTACT.left" or "CONTACT.right"; of solids "CONTACT.FRONT.STATION", fronts
                counted from 1 and stations from 0. A contact or a front alone stands for the
                largest |ΔK|/(f K_N) there.

        Raises:
            CaseError: if there is none.
            OutputError: if the run is not complete.
            ModelError: if it is too near an end, or nothing is known of any that it may be.
        """
        meant = self._meant(name)
        if len(meant) > 1:
            meant = [each for each in meant if each[2].defined and each[2].slip_by_range > 0]
            if not meant:
                raise ModelError(
                    f"edge {name}: expected K_N and the range of K_T to be known somewhere along "
                    "it, each with an error bar of less than half of it, found that they are not"
                    f"{self._why(name)}"
                )
        contact, front, station = max(meant, key=lambda each: each[2].slip_by_range)
        if not station.defined:
            raise ModelError(
                f"edge {name}: expected a station with factors of its own, found one so near to a "
                f"free end that they are unknown or mean nothing ({station.to_end:.3g})"
            )
        return contact, front, station

    def _meant(self, name: str) -> list[tuple[Contact, Front, Station]]:
        """The stations whose name begins with this one, at least one; as for `find`."""
        where = self.directory or self.case.source
        if self.failure is not None:
            raise OutputError(f"{where}: expected complete results, found: {self.failure}")
        fronts = [(contact, front) for contact in self.contacts for front in contact.fronts]
        meant = [
            (contact, front, station)
            for contact, front in fronts
            for station in front.stations
            if f"{contact.name_of(station)}.".startswith(f"{name}.")
        ]
        if meant:
            return meant
        every = (station for _, front in fronts for station in front.stations)
        if not any(each.defined and each.slip_by_range > 0 for each in every):
            raise ModelError(
                f"{where}: expected an edge with a K_N and a range of K_T, found none{self._why()}"
            )
        ends = (
            [contact.name_of(front.stations[place]) for place in (0, -1)]
            for contact, front in fronts
        )
        known = ", ".join(" to ".join(dict.fromkeys(pair)) for pair in ends)
        contacts = ", ".join(each.name for each in self.contacts)
        raise CaseError(
            f"{where}: expected one of the edges {known or '(none)'}, found {name!r}; a contact "
            f"({contacts}) stands for its worst edge"
        )

    def _why(self, name: str = "") -> str:
        """Reasons why the factors of edges whose names begin so are not known, each once."""
        own = [each for each in self.contacts if name.startswith(each.name) or not name]
        lacks = dict.fromkeys(lack.text for each in own for lack in each.lacks)
        return "".join(f"; {text}" for text in lacks)

    def contact_history(self, contact: str) -> ContactHistory:
        """Return tractions, gap and slip along a contact, or along one of its patches.

        Raises:
            OutputError: if there is no such contact, or this is not process 0.
        """
        for each in self.solution.contacts:
            if each.name == contact:
                return each
        known = ", ".join(each.name for each in self.solution.contacts)
        raise OutputError(f"expected one of the contacts {known}, found {contact!r}")

    def local_parameters(self, contact: str) -> LocalParameters:
        """Range of slip, friction work, wear and Ruiz's parameter at the nodes of a contact.

        Of the evaluated cycle, or of the whole history without one.

        Raises:
            OutputError: as for `contact_history`, or if not all states of the cycle are kept.
        """
        history = self.contact_history(contact)
        states = self.solution.loads.evaluated
        if not self.solution.keeps(*states):
            raise OutputError(
                f"expected the tractions of states {states[0]} to {states[1]}, found those of some "
                "of them only: run the case with [output] tractions of all states"
            )
        return local_parameters(history, states)

    @property
    def has_stress(self) -> bool:
        """True if the run wrote the stress near the contacts."""
        return self.directory is not None and (self.directory / STRESSES).is_file()

    def stress_history(self, contact: str) -> StressHistory:
        """Return the stress of both bodies near a contact, through the evaluated or worst cycle.

        Raises:
            OutputError: if the run has no folder, or did not write any (`[output] stress_depths`),
                or there is no such contact in the case.
        """
        if self.directory is None:
            raise OutputError(
                "expected the stress near the contacts, found a run without files: run the case "
                "with an output folder and [output] stress_depths"
            )
        found = read_stress(self.directory, contact)
        if wrong := {each.name for each in found.bodies} - self.case.bodies.keys():
            raise OutputError(
                f"{self.directory / STRESSES}: expected bodies of the case, found {wrong.pop()!r}"
            )
        return found

    @property
    def has_station_stress(self) -> bool:
        """True if the run wrote the stress around the stations of solids."""
        return self.directory is not None and (self.directory / STATION_STRESSES).is_file()

    def station_stress(self, contact: str) -> StationStress:
        """Return the stress of elements around the stations of a contact of solids.

        Raises:
            OutputError: if the run has no folder, or did not write any (`[output] stress_depths`),
                or there is no such contact in the case.
        """
        if self.directory is None:
            raise OutputError("expected the stress at stations, found a run without files")
        return read_station_stress(self.directory, contact)

    def stress_parameters(
        self, contact: str, fatemi_socie: tuple[float, float] | None = None
    ) -> tuple[StressParameters, StressParameters]:
        """Ruiz 2, Smith-Watson-Topper and Fatemi-Socie of body 1 and body 2 near a contact.

        Args:
            contact: its name in the case.
            fatemi_socie: k and yield stress of that parameter; None leaves it out.

        Raises:
            OutputError: as for `stress_history`.
            CaseError: if k is negative or the yield stress not positive.
        """
        history = self.stress_history(contact)
        first, second = (
            stress_parameters(history, number, self.case.bodies[body.name], fatemi_socie)
            for number, body in enumerate(history.bodies)
        )
        return first, second

    def to_dataframe(self, *, stations: bool = False) -> pd.DataFrame:
        """The flat records as a table, with the units of its columns as ``attrs["units"]``.

        Args:
            stations: whether it has a row for each station, with all of its numbers, in place of
                those of `records`.

        Raises:
            DependencyError: if pandas is not installed.
        """
        columns = STATIONS if stations else SOLIDS if self.solid else EDGES
        rows = station_records(self.contacts) if stations else self.records()
        table: pd.DataFrame = require("pandas").DataFrame(rows)
        table.attrs["units"] = {each.name: self.unit(each.kind) for each in columns}
        return table

    def plot(
        self,
        kind: Literal["tractions", "factors", "loads"] = "factors",
        ax: Axes | Iterable[Axes] | None = None,
    ) -> tuple[Axes, ...]:
        """Draw what `fretfe.plot_tractions`, `plot_factors` or `plot_loads` draws."""
        import fretfe  # results stand before what draws them: the interface finds it

        draw = {
            "tractions": fretfe.plot_tractions,
            "factors": fretfe.plot_factors,
            "loads": fretfe.plot_loads,
        }
        if kind not in draw:
            raise OutputError(f"kind: expected one of {', '.join(draw)}, found {kind!r}")
        return draw[kind](self, ax)

    def to_xarray(self) -> xr.Dataset:
        """Histories of loads, contacts and stations, and the tractions, with named dimensions.

        Dimensions are ``time``, ``load``, ``contact`` and ``edge``, of solids ``station`` and
        ``axis`` in its place; the fields of a contact NAME are called ``NAME.traction`` and so on,
        over ``NAME.node`` (see docs/python.md). If they are those of some states only, ``kept``
        takes the place of ``time``.

        Raises:
            DependencyError: if xarray is not installed.
        """
        return make_dataset(self.loads, self.contacts, self.root_solution)

    def __repr__(self) -> str:
        """Three lines: the case, what was solved, and where it is."""
        loads, contacts = self.loads, self.contacts
        plural, fronts = "s" * (len(contacts) != 1), sum(len(each.fronts) for each in contacts)
        failed = f", not complete: {self.failure}" if self.failure is not None else ""
        title = self.case.title or self.case.source.name
        return (
            f"Result of {title!r} by {self.backend or 'no backend'}\n"
            f"  {len(loads.times)} states to t = {loads.times[-1]:g} {self.case.units.time}, "
            f"{len(contacts)} contact{plural}, {fronts} edges or fronts{failed}\n"
            f"  {self.directory or 'in memory only'}"
        )

    def _repr_html_(self) -> str:
        """A card for notebooks: lines of `repr`, first lines, main numbers, and warnings."""
        columns = [each for each in (SOLIDS if self.solid else EDGES) if each.name in CARD]
        units = (self.unit(each.kind) for each in columns)
        head = "".join(
            f"<th>{html.escape(f'{each.name} [{unit}]' if unit else each.name)}</th>"
            for each, unit in zip(columns, units, strict=True)
        )
        rows = "".join(
            f"<tr>{''.join(f'<td>{_cell(record[each.name])}</td>' for each in columns)}</tr>"
            for record in self.records()
        )
        told = *repr(self).splitlines(), *self.headline.sentences.lines
        title, *lines = (html.escape(line.strip()) for line in told)
        warnings = "".join(f"<br>{html.escape(each.sentence)}" for each in self.warnings)
        table = f"<table><tr>{head}</tr>{rows}</table>" if rows else ""
        return f"<b>{title}</b><br>{'<br>'.join(lines)}{table}<small>{warnings}</small>"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}" if math.isfinite(value) else "–"
    return html.escape(str(value))
