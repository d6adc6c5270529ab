# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables and figures of a solved case."""
