# SPDX-License-Identifier: LGPL-3.0-or-later
"""From stress to a decision: criteria of endurance, short cracks, margins of edges."""
