# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elasticity of materials: constants, crystals, half-planes and the moduli of contacts.

The folder also has the materials that come with fretfe, a file (.toml) for each.
"""
