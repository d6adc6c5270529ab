#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# The part of test.sh that runs in namespaces of its own.
# Usage: in_namespace.sh CACHE SUITE PACKAGES INSTALL      the last two: shell commands of docs/install.md
set -euo pipefail

cache=$1 suite=$2 packages=$3 install=$4
. "$(dirname "${BASH_SOURCE[0]}")/system.sh"
root=$cache/$suite

install_packages() {
    as_root "$apt_limit" "apt-get -qq update
        $packages" >"$root.log" 2>&1
}

# The file that says so comes last: an interrupted installation is begun anew.
if [ ! -e "$root/etc/fretfe-packages" ]; then
    new_system
    mount_system
    keep_downloads
    step "packages of docs/install.md"
    install_packages || give_up "test-debian: the packages of docs/install.md cannot be installed"
    echo "$packages" >"$root/etc/fretfe-packages"
else
    mount_system
fi
copy_checkout

step "check that the packages are what fretfe needs"
as_tester 300 "cd fretfe; python3 tools/debian/check_packages.py"

step "fretfe as docs/install.md says"
as_tester "$build_limit" "cd fretfe
$install"

# In tests/ a Python finds the fretfe that is installed, not that of the checkout.
pytest="$home/fretfe/.venv-debian/bin/python -m pytest"
# What Python, NumPy and SciPy alone do is the same as where `make test` ran it. Here stands what may
# differ, once: pydantic and typer; h5py, pandas and xarray; Matplotlib and PyVista, which draws on a
# display; what this compiler makes of the C++ code; all that fretfe calls of DOLFINx, UFL and PETSc,
# in planes and in space. On two ranks: what these share, and whole runs.
chosen=(_core case surface/test_mortar_in_space.py cli/test_app.py cli/test_app_completion.py
    report/test_page.py::test_page_is_one_file_that_loads_nothing
    report/test_figures.py::test_drawings_have_ids_and_glyphs_of_their_own
    report/test_pictures.py::test_a_display_is_made_where_there_is_none
    report/test_pictures_stress.py exchange/test_export.py results/test_writer_solids.py
    test_environment.py system/test_reference_numbers.py
    fem/test_{compat,elasticity,elasticity_form_cache,elasticity_spread_loads}.py
    fem/test_{restraints,stress_output}.py
    fem/test_interaction_integral_fronts.py::test_fields_of_crystals_bend_with_the_front
    fem/test_elasticity_eigenstrain.py::test_a_held_body_has_the_stress_and_its_contact_feels_nothing)
step "tests on one rank"
as_tester "$test_limit" "cd fretfe/tests; $pytest ${chosen[*]} \
    -m 'not slow' --numprocesses=2 --dist=loadfile"
step "tests on two ranks"
as_tester "$test_limit" "cd fretfe/tests; mpirun -n 2 $pytest \
    fem/test_{bordered,compat,fields,parallel,parallel_groups}.py system/test_verify.py \
    -m 'mpi and not slow' -p no:cacheprovider --timeout-method=thread"
step "done"
