# SPDX-License-Identifier: LGPL-3.0-or-later
"""Does the half-plane edge description hold for a geometry? A case, its companions, a verdict."""

from __future__ import annotations

from fretfe.quality.validate.rows import Row, Verdict
from fretfe.quality.validate.run import Validation, validate

__all__ = ["Row", "Validation", "Verdict", "validate"]
