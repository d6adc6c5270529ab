# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of the bodies: made, read, checked, extruded, written."""
