# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command line: a module for each command; `app` declares them."""
