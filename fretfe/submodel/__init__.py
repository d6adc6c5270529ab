# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane problems in place of a station of solids."""
