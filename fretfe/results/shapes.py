# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether the arrays of a contact in a file fit together."""

from __future__ import annotations

import h5py

from fretfe.results.dataset import NODAL


def require_shapes(group: h5py.Group, states: int, kept: int) -> None:
    """Check that the arrays of a contact are over the same states and nodes.

    Args:
        group: of the contact.
        states: T.
        kept: number of states whose tractions are stored.

    Raises:
        ValueError: for the first array that does not fit.
        KeyError: for one that is not there.
    """
    nodes = group["weights"].shape
    expected = {
        "friction": ((states,), 1),
        "points": (nodes, 2),
        "frames": (nodes, 3),
        **{name: ((kept, *nodes), 3 if last else 2) for name, last in NODAL.items()},
    }
    for name, (shape, dimensions) in expected.items():
        found = group[name].shape
        if found[: len(shape)] != shape or len(found) != dimensions:
            raise ValueError(f"{group.name}/{name}: expected an array over {shape}, found {found}")
