# SPDX-License-Identifier: LGPL-3.0-or-later
"""The frictional interface problem: law, Newton's method, load history. NumPy and SciPy only.

Whoever supplies the compliance of the bodies at the contact nodes (finite elements, half-planes)
has it solved here.
"""
