# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks between the parameters of a geometry template: do they describe a body that can exist.

Each check takes all parameters of its template (lengths in mm, angles in degrees, each inside its
own range) and returns what is wrong in the user's terms, or None.
"""

from __future__ import annotations

from collections.abc import Mapping

from fretfe.geometry.template_checks import cylinder, dovetail, firtree, flat_rounded, wedge
from fretfe.geometry.template_checks.bounds import Check

CROSS_CHECKS: Mapping[str, tuple[Check, ...]] = {
    "cylinder": cylinder.CHECKS,
    "dovetail": dovetail.CHECKS,
    "firtree": firtree.CHECKS,
    "flat_rounded": flat_rounded.CHECKS,
    "wedge": wedge.CHECKS,
}
