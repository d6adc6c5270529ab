# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane contacts: sections at two fronts, patches in a row, fits to full stick."""
