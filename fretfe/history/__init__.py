# SPDX-License-Identifier: LGPL-3.0-or-later
"""A solved history: its arrays, and the file in which they are while it is solved."""
