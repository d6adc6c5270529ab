# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results for other programs, and results of other programs beside one's own."""
