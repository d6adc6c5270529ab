# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fretting contacts: edge factors K_N and K_T and slip zones of two-body contacts."""
