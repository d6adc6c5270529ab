# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of bodies: meshes, stress, stick and slip."""
