# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plane problem next to an edge of a contact, with three displacement components."""
