# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that nothing holds are named before anything is solved."""

from __future__ import annotations

from typing import Any

import pytest
from cases import blocks
from cases.contact_runs import ramp, run

from fretfe.errors import ModelError


def two_blocks(loads: dict[str, Any], supports: dict[str, Any]) -> None:
    bodies = {name: {"young": 200.0, "poisson": 0.3} for name in ("upper", "lower")}
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.4}
    run(
        {"bodies": bodies, "contacts": {"main": contact}, "loads": loads, "supports": supports},
        blocks.block("upper", [0.0, 0.5, 1.0], [0.0, 1.0]),
        blocks.block("lower", [0.0, 0.4, 1.0], [-1.0, 0.0]),
    )


PULL = {"type": "traction", "boundary": "upper_top", "direction": "y", "history": ramp(-1.0)}
PRESS = {
    "type": "platen",
    "boundary": "upper_top",
    "direction": "y",
    "control": "force",
    "history": ramp(-1.0),
}


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("loads", "supports", "hint"),
    [
        ({"pull": PULL}, {}, ""),
        # The guided platen holds the upper body sideways, nothing holds either along y.
        ({"press": PRESS}, {}, " A force holds nothing: press."),
        (
            {"pull": PULL},
            {"base": {"boundary": "lower_bottom", "fix": ["x"]}},
            "",
        ),
    ],
    ids=["nothing", "force along y", "support along x"],
)
def test_bodies_that_nothing_holds_are_named(
    loads: dict[str, Any], supports: dict[str, Any], hint: str
) -> None:
    with pytest.raises(ModelError, match="nothing holds 'lower' and 'upper'") as caught:
        two_blocks(loads, supports)
    assert str(caught.value).endswith(f"every translation and rotation.{hint}")
