# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stages of `fem` behind the steps, broken in turn on rank 0 while the others wait: no hang."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad, press, shear

from fretfe.backends import RunOptions, find_backend
from fretfe.backends.protocol import Session
from fretfe.case import Case, parse_case
from fretfe.faults import collecting
from fretfe.fem._compat import MPI

COMM = MPI.COMM_WORLD
# Where an error is made, what is unknown for it, and whether K_N is.
STAGES = {
    "fretfe.evaluate.evaluate.separate_patches": ("patches of the contacts", True),
    "fretfe.fem.run.add_integrals": ("edge integrals", False),
    "fretfe.evaluate.evaluate.evaluate_plane": ("contact main", True),
    "fretfe.fem.run.model_limits": ("limits of the model", False),
    "fretfe.fem.run.with_crossed_spreads": ("error bars by cross compliances", True),
    "fretfe.fem.run.with_cut_spreads": ("error bars by cuts", True),
    "fretfe.fem.run.imbalance": ("balance of forces", False),
    "fretfe.fem.run.unlike_notes": ("notes", False),
    "fretfe.fem.run.FieldOutput": ("fields", False),
}


def broken(*_: object, **__: object) -> Any:
    raise ZeroDivisionError("division by zero")


@pytest.fixture(scope="module")
def case() -> Case:
    tables = pad(loads={"press": press(steps=2), "shear": shear(steps=4)})
    tables["geometry"]["parameters"]["size"] = 0.05
    tables["output"] = {"fields": "last"}
    return parse_case(tables)


@pytest.fixture(scope="module")
def session(case: Case) -> Iterator[Session]:
    """Bodies that are condensed once."""
    with closing(find_backend("fem").session()) as made:
        yield made


@pytest.mark.mpi
@pytest.mark.parametrize("stage", STAGES)
def test_a_broken_stage_costs_no_other(
    stage: str, case: Case, session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, unknown = STAGES[stage]
    if COMM.rank == 0:
        monkeypatch.setattr(stage, broken)
    with collecting(tmp_path) as found:
        result = session.solve(case, RunOptions(fields=tmp_path / "fields.hdf"))
    assert [fault.place for fault in found.faults] == [place] * (COMM.rank == 0)
    (contact,) = result.contacts
    assert contact.normal_force[-1] == pytest.approx(600, rel=1e-9)
    told = [each.reported_k_n for each in contact.stations]
    assert np.isnan(told).all() if unknown else np.isfinite(told).all()
