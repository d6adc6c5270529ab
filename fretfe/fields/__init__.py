# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement fields of other runs, from files of this and other programs."""
