# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of a run: in memory, in files, as flat records."""
