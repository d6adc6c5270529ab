# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields of displacements and temperatures of other runs, from files of this and other programs."""
