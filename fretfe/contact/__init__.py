# SPDX-License-Identifier: LGPL-3.0-or-later
"""The frictional interface problem: law, Newton's method, load history. NumPy and SciPy only.

The backends (finite elements, half-planes) supply the compliance of the bodies at the contact
nodes.
"""
