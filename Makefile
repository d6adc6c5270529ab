# SPDX-License-Identifier: LGPL-3.0-or-later
# Each target does its own set-up: .venv (for `demo` only what it needs, else everything) or .venv-light (all that works without
# DOLFINx). PYTHON=... chooses the interpreter, CXX=... the compiler, SLOW=1 adds the slow tests.

PYTHON ?=
export PYTHON
# A foreign package must not shadow those of the environment.
unexport PYTHONPATH PYTHONHOME
# Without compiled files each of many processes compiles all of fretfe and of the tests anew.
unexport PYTHONDONTWRITEBYTECODE

BIN := .venv/bin
LIGHT := .venv-light/bin
CPP := $(wildcard fretfe/_core/*.cpp fretfe/_core/*.hpp)
BUILD_INPUTS := pyproject.toml CMakeLists.txt $(CPP) $(wildcard meshes/*.geo tools/*.*)
PYTHON_SOURCES := $(shell find fretfe -name '*.py')

# Compiler warnings are errors where changes are checked, not on a user's machine.
is_set = $(filter-out 0 false,$(1))
WERROR := $(if $(call is_set,$(CI)),ON,OFF)
SETTINGS := --config-settings=cmake.define.CMAKE_COMPILE_WARNING_AS_ERROR=$(WERROR)

# One thread: the same rounding in every run, and no contest between MPI ranks.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# What hangs in compiled code is ended. Not in pyproject.toml: pytest 8, which Debian 13 has, does
# not know the option and rejects it.
export PYTEST_ADDOPTS := -o faulthandler_exit_on_timeout=true
# A stage in which nothing is collected fails: pytest then exits with 5.
PYTEST := $(ONE_THREAD) $(BIN)/pytest
# The tests of one file stay in one process: they share what they solve.
# Files begin in the order of tests/conftest.py: those that take longest come first.
SHARED_OUT := --numprocesses=auto --maxprocesses=4 --dist=loadfile --no-loadscope-reorder
# The tests of `make test`, by their markers; slow ones may take half an hour each.
CHOSEN ?= $(if $(call is_set,$(CI) $(SLOW)),,not slow)

# The Debian of `make test-debian` and `make deb`; FRESH=1 does without the system of the last time.
SUITE ?= trixie
FRESH ?=

.PHONY: help demo bench campaign test test-light test-debian deb wheels lint docs clean

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 14

demo: .venv/.runs  ## solve the dovetail demo and write results/dovetail
	$(BIN)/fretfe run demos/dovetail.toml -o results/dovetail

bench: .venv/.installed  ## times and memory of runs, phases, ranks and commands; an hour on a quiet machine
	$(BIN)/python tools/bench.py

campaign: .venv/.installed  ## error bars of 400 irregular histories beside exact numbers, by half-planes and elements; an hour
	for which in irregular "irregular elements"; do \
	    $(ONE_THREAD) PYTHONPATH=tests $(BIN)/python -m campaign $$which; done

test: .venv/.installed  ## all tests on 1 rank, those marked mpi on 2; the slow ones if CI or SLOW is set
	$(PYTEST) $(SHARED_OUT) -o faulthandler_timeout=1860 --durations=20 -m "$(CHOSEN)"
	$(ONE_THREAD) $(BIN)/mpirun -n 2 $(BIN)/pytest tests/fem tests/system -m "mpi and not slow" \
	    -p no:cacheprovider --timeout-method=thread </dev/null

test-light: .venv-light/.installed  ## the tests of the parts without DOLFINx, in .venv-light
	$(ONE_THREAD) $(LIGHT)/pytest $(SHARED_OUT) -m "not fem and not slow"

test-debian:  ## install on Debian (SUITE=trixie, sid) as docs/install.md says and test there; as root
	tools/debian/test.sh $(SUITE) $(if $(call is_set,$(FRESH)),fresh)

deb:  ## build the Debian package on SUITE=trixie or sid into build/deb, install and try it; as root
	tools/debian/deb.sh $(SUITE)

wheels:  ## source package and wheel for PyPI in build/dist, checked by auditwheel and twine
	tools/wheels.sh $(PYTHON)

lint: .venv/.installed  ## ruff, mypy, clang-format
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run --Werror $(CPP)

docs: .venv/.installed  ## the site in build/docs/html: pages, API reference, gallery; without a network
	$(ONE_THREAD) $(BIN)/python tools/site/prepare.py build/docs/source
	rm -rf build/docs/html
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going --conf-dir tools/site \
	    --doctree-dir build/docs/doctrees build/docs/source build/docs/html
	$(BIN)/python tools/site/check.py build/docs/html

clean:  ## remove environments, builds and caches; results stay
	rm -rf .venv .venv-light .venv-debian build .pytest_cache .mypy_cache .ruff_cache
	find fretfe tests tools -name __pycache__ -prune -exec rm -rf {} +

# A stamp carries the time at which its set-up began: a file that is saved meanwhile counts as new.
# Editable: changes of Python files count at once; a change of the inputs rebuilds the extension.
.venv/.installed: $(BUILD_INPUTS)
	@mkdir -p build && touch build/started
	tools/install.sh .venv $(SETTINGS) -e '.[fem,report,test,lint,docs]'
	@! $(BIN)/fretfe info | grep 'cannot be used'
	@mv build/started $@ && cp -p $@ .venv/.runs

# All that a run and its report need, without what tests, checks and documents need besides.
.venv/.runs: $(BUILD_INPUTS)
	@mkdir -p build && touch build/started-runs
	tools/install.sh .venv $(SETTINGS) -e '.[fem,report]'
	@! $(BIN)/fretfe info | grep 'cannot be used'
	@mv build/started-runs $@

# Not editable: this is what a user gets from pip install.
.venv-light/.installed: $(BUILD_INPUTS) $(PYTHON_SOURCES)
	@mkdir -p build && touch build/started-light
	tools/install.sh .venv-light $(SETTINGS) '.[test]'
	@mv build/started-light $@
