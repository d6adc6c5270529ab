# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces: orientation, opposite facets, mortar coupling, initial gap."""
