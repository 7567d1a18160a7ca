"""Compile the integrator; everything else is declared in pyproject.toml."""

import sys

from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

# -ffp-contract=off: a fused multiply-add rounds once, so compiled and uncompiled runs would differ.
FLAGS = [] if sys.platform == "win32" else ["-O3", "-ffp-contract=off"]


class OptionalBuild(build_ext):
    """Leaves the integrator uncompiled, and says so, where it cannot be compiled."""

    def run(self) -> None:
        try:
            super().run()
        except Exception as error:
            self.warn(f"the integrator stays uncompiled, the same results, but slower: {error}")

    def build_extension(self, ext: Extension) -> None:
        try:
            super().build_extension(ext)
        except Exception as error:
            self.warn(f"the integrator stays uncompiled, the same results, but slower: {error}")


setup(
    cmdclass={"build_ext": OptionalBuild},
    ext_modules=cythonize(
        [
            Extension(
                "suspension.integrator",
                ["fmu_src/suspension/integrator.py"],
                extra_compile_args=FLAGS,
                optional=True,
            )
        ],
        compiler_directives={
            "language_level": 3,
            "boundscheck": False,
            "wraparound": False,
            "cdivision": True,
            "initializedcheck": False,
        },
        build_dir="build",
    ),
)
