# SPDX-License-Identifier: LGPL-3.0-or-later
"""Geometry of a case: templates, CAD files, element sizes."""
