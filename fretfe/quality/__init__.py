# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evidence: benchmarks with known answers, and companions of a user's case."""
