# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed-form contact mechanics of half-planes and contact edges. NumPy and SciPy only."""
