# SPDX-License-Identifier: LGPL-3.0-or-later
"""Strength measured in laboratory tests, and what it says of the edges of computed components."""
