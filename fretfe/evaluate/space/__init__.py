# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts of solids: sectors along curved fronts, found and followed."""
