# SPDX-License-Identifier: LGPL-3.0-or-later
"""The report of a run as one HTML file, and tables for the terminal."""
