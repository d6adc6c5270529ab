# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m fretfe`: the same as the command `fretfe`."""

from __future__ import annotations

from fretfe.cli import main

if __name__ == "__main__":
    main()
