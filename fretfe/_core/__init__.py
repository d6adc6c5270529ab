# SPDX-License-Identifier: LGPL-3.0-or-later
"""C++ kernels: arrays in, arrays out, no DOLFINx; and a routine of the BLAS for MUMPS."""
