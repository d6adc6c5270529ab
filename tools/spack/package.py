# SPDX-License-Identifier: LGPL-3.0-or-later
"""Package file for Spack: packages/py_fretfe/package.py of a repository of your own."""

from spack.package import default_args, depends_on, license, variant, version
from spack_repo.builtin.build_systems.python import PythonPackage


class PyFretfe(PythonPackage):
    """Edge factors of frictional contacts under cyclic load, by finite elements."""

    homepage = "https://pypi.org/project/fretfe/"
    pypi = "fretfe/fretfe-0.1.0.tar.gz"

    license("LGPL-3.0-or-later")
    version("0.1.0")
    variant("fem", default=True, description="Finite elements")

    depends_on("cxx", type="build")
    depends_on("cmake@3.21:", type="build")
    depends_on("ninja", type="build")
    depends_on("py-scikit-build-core@0.11:", type="build")
    depends_on("py-nanobind@2.4:", type="build")

    with default_args(type=("build", "run")):
        depends_on("python@3.11:")
        depends_on("py-h5py@3.10:")
        depends_on("py-jinja2@3.1:")
        depends_on("py-matplotlib@3.8:")
        depends_on("py-numpy@1.26:")
        depends_on("py-pydantic@2.6:")
        depends_on("py-rich@13:")
        depends_on("py-scipy@1.12:")
        depends_on("py-threadpoolctl@3.1:")
        depends_on("py-tomli-w@1.0:")
        depends_on("py-typer@0.12:")
        depends_on("py-fenics-dolfinx@0.9:0.11", when="+fem")
        depends_on("py-mpi4py", when="+fem")
        depends_on("petsc+mumps~complex", when="+fem")
        depends_on("gmsh@4.11:+shared+opencascade", when="+fem")
