# SPDX-License-Identifier: LGPL-3.0-or-later
"""Benchmarks with known answers, run through every backend."""
