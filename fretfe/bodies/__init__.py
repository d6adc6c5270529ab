# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies, supports, loads and contact pairs that a case and its mesh describe; no DOLFINx."""
