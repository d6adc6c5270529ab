# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of a case as they act on bodies: each kind is one class."""
