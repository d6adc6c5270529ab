# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that several tests ask about, and their bodies, are solved and condensed once."""

from __future__ import annotations

from harness.solving import _fast_processes, _processes, solved

__all__ = ["_fast_processes", "_processes", "solved"]
