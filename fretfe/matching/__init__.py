# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laboratory tests with the edge factors of a component, and how far their fields agree."""
