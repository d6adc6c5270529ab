# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of nodes in contact, and resultants of piecewise-linear tractions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array


@dataclass(frozen=True, slots=True)
class Patch:
    """A run of nodes in contact, first to last (both included), and the force it carries."""

    first: int
    last: int
    force: float


@dataclass(frozen=True)
class Resultants:
    """P, Q (force per thickness) and the moment of the pressure about the given centre."""

    normal_force: float
    shear_force: float
    moment: float


def contact_patches(x: Array, p: Array, tol: float = 0.0) -> list[Patch]:
    """Return the runs of nodes with p > tol (a pressure), from left to right; x, p (n,)."""
    ends = np.flatnonzero(np.diff(p > tol, prepend=False, append=False)).reshape(-1, 2)
    share = p * _node_lengths(x)
    return [Patch(int(i), int(j) - 1, float(share[i:j].sum())) for i, j in ends]


def main_patch(x: Array, p: Array, tol: float = 0.0) -> Patch:
    """Return the patch that carries most force.

    Raises:
        ValueError: if no node has p > tol.
    """
    patches = contact_patches(x, p, tol)
    if not patches:
        raise ValueError(f"p must exceed tol = {tol:g} at one node at least, found none")
    return max(patches, key=lambda patch: patch.force)


def resultants(x: Array, p: Array, q: Array, centre: float) -> Resultants:
    """Return the exact resultants of piecewise-linear tractions; x, p, q (n,).

    A positive moment presses on the side x > centre.
    """
    length, moment = _node_lengths(x), pressure_moments(x, p[None], np.array([centre]))
    return Resultants(float(length @ p), float(length @ q), float(moment[0]))


def pressure_moments(x: Array, p: Array, centre: Array) -> Array:
    """Return (T,) moments of piecewise-linear pressures (T, n) at x (n,) about centres (T,)."""
    arm, left, right = x - centre[:, None], p[:, :-1], p[:, 1:]
    moments = arm[:, :-1] * (2 * left + right) + arm[:, 1:] * (left + 2 * right)
    return np.asarray(moments @ np.diff(x) / 6)


def _node_lengths(x: Array) -> Array:
    """Return the integrals of the hat functions of all nodes."""
    h = np.diff(x, prepend=x[0], append=x[-1])
    return (h[1:] + h[:-1]) / 2
