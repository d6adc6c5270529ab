# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of histories, edges, slip, tractions and the solver, drawn by Matplotlib."""
