# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry of the user's: one module for each kind of file, with one mesh or model as result."""
