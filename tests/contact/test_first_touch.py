# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies that lie loose until loads move them: a blade in a slot that opens while it is pulled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.marching import march_through
from reference import halfplane_interface as halfplane
from reference.halfplane_interface import Flank

from fretfe._typing import Array
from fretfe.contact.first_touch import displacement_at_first_touch
from fretfe.contact.interface import Interface
from fretfe.contact.march import March
from fretfe.contact.state import StepLoads

PULL = -0.8
OPENING = 0.05


def flat(x: Array) -> Array:
    """Second integral of the gap of a flat with rounded ends."""
    return np.where(np.abs(x) > 0.7, (np.abs(x) - 0.7) ** 4 / 72.0, 0.0)


def slot(taper: float = 0.0) -> Interface:
    """A loose blade on two flanks at 45°; a load opens gaps by 1 + taper times the distance up."""
    nodes = np.arange(-1.5, 1.5, 0.03) + 0.003
    flanks = [
        Flank(nodes, flat, 45.0, (3.0, 0.0)),
        Flank(-nodes[::-1], flat, -45.0, (-3.0, 0.0)),
    ]
    built = halfplane.build(flanks, ("free", "force", "free"))
    opens = np.zeros((built.size, 2, 1))
    up = np.concatenate([nodes[1:-1], nodes[1:-1][::-1]])
    opens[:, 0, 0] = built.roots * (1 + taper * up)
    return replace(built, loads=opens.reshape(-1, 1), coordinate_loads=np.zeros((3, 1)))


def pulled(interface: Interface, pull: float, opening: float, friction: float) -> StepLoads:
    values = np.array([0.0, pull, 0.0])
    return StepLoads(np.array([opening]), values, np.full(interface.size, friction))


def test_a_loose_blade_moves_until_both_flanks_touch() -> None:
    interface = slot()
    nothing = np.zeros(interface.size, dtype=bool)
    loads = pulled(interface, PULL, OPENING, 0.4)
    found = displacement_at_first_touch(interface, loads, nothing)
    assert found is not None
    gap, along = (found / interface.roots[:, None]).T
    # It moves by gap / cos 45°, and along each flank by gap · tan 45°.
    assert gap.min() == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(gap[[0, -1]], gap.max(), rtol=1e-6)
    np.testing.assert_allclose(np.abs(along), OPENING, rtol=1e-6)


def test_nothing_stops_a_blade_that_is_lifted() -> None:
    interface = slot()
    nothing = np.zeros(interface.size, dtype=bool)
    lifted = pulled(interface, -PULL, OPENING, 0.4)
    assert displacement_at_first_touch(interface, lifted, nothing) is None


def test_no_body_is_loose_where_nodes_hold_it() -> None:
    interface = slot()
    held = np.zeros(interface.size, dtype=bool)
    held[[10, -10]] = True
    assert displacement_at_first_touch(interface, pulled(interface, PULL, 0, 0.4), held) is None


@pytest.mark.parametrize("friction", [0.4, 0.9])
@pytest.mark.parametrize("taper", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("pull", [PULL, PULL / 80])
def test_a_slot_that_opens_lets_the_blade_slide_outwards(
    friction: float, taper: float, pull: float
) -> None:
    """The whole contact slips, so that statics give P = F/[2 (cos α + f sin α)]."""
    interface = slot(taper)
    steps = [pulled(interface, part * pull, part * 10 * OPENING, friction) for part in (0, 0.5, 1)]
    for part, result in zip((0.5, 1.0), march_through(March(interface), steps), strict=True):
        expected = part * -pull / (np.sqrt(2) * (1 + friction))
        for nodes in interface.contacts.values():
            pressure, shear = interface.roots[nodes] @ result.state.traction[nodes]
            assert pressure == pytest.approx(expected, rel=1e-9)
            assert abs(shear) == pytest.approx(friction * expected, rel=1e-9)
        assert result.certificate.worst < 1e-8
        assert (result.parts, result.fallbacks) == (1, 0)
