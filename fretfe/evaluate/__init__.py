# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors, slip zones and resultants of a solved history.

For plane contacts, whose nodes form one line.
"""

from __future__ import annotations

from fretfe.evaluate.slip_zones import SlipZone
from fretfe.evaluate.summary import ContactSummary, Edge, evaluate

__all__ = ["ContactSummary", "Edge", "SlipZone", "evaluate"]
