# SPDX-License-Identifier: LGPL-3.0-or-later
"""Finite elements with DOLFINx; `_compat` loads the libraries before any module imports them."""

from __future__ import annotations

import fretfe.fem._compat  # noqa: F401
