# Put this folder into a package repository as packages/nanoweft, then in a checkout of nanoweft:
#     spack dev-build nanoweft@main
import os

from spack.package import *


class Nanoweft(CMakePackage):
    """Fabrics, films and yarns of nano- and microfibres
    by the mesoscopic distinct element method."""

    license("BSD-2-Clause")

    # There is no public archive yet: dev-build takes the present folder.
    version("main")

    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("petsc@3.18: +mpi +double ~complex ~int64")
    depends_on("hdf5@1.10: +mpi")
    depends_on("metis@5.1:")
    depends_on("openssl@3:")
    depends_on("libyaml@0.2:")
    for package in ("python@3.11:", "py-numpy", "py-h5py", "py-matplotlib", "py-scipy",
                    "py-pillow"):
        depends_on(package, type="run")

    # g++'s vectors, OpenMP and flags are what has been tested.
    requires("%gcc@12:")

    def cmake_args(self):
        return [
            # Spack's compiler wrapper sets the instruction set of the target.
            self.define("NANOWEFT_ARCH", ""),
            self.define("NANOWEFT_TESTS", False),
            self.define("NANOWEFT_BENCHMARKS", False),
        ]

    @run_after("install")
    def use_own_python(self):
        scripts = find(self.prefix.share.nanoweft, "*", recursive=True)
        filter_file(r"^#!/usr/bin/python3$", "#!/usr/bin/env python3",
                    *filter(os.path.isfile, scripts))
