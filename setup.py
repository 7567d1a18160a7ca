"""Compile the integrator's kernel; everything else is declared in pyproject.toml."""

import shutil
import sys
from pathlib import Path

from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "fmu_src"))
from suspension.engine import KERNEL, kernel_name  # noqa: E402

NAME = kernel_name()
STAGE = Path("build") / NAME
# -ffp-contract=off: a fused multiply-add rounds once, so compiled and uncompiled runs would differ.
# Nearly all loops are over a few coordinates: written out they are fast, but as loops over vectors
# they spend their time on asking whether arrays overlap.
FLAGS = (
    []
    if sys.platform == "win32"
    else [
        "-O3",
        "-g0",
        "-ffp-contract=off",
        "-fno-wrapv",
        "-fno-math-errno",
        "-finline-limit=100000",
        "-fno-tree-loop-vectorize",
        "-fno-tree-loop-distribution",
        "-fno-tree-loop-distribute-patterns",
    ]
)
MODULES = (
    "linear", "bernstein", "signals", "laws", "elements", "network",
    "exact", "iteration", "lanes", "stepper", "switches", "cruise", "dense", "ledger", "watch",
    "march", "integrator",
)  # fmt: skip


def staged() -> None:
    """Copy the kernel under its hashed name: the names it imports itself by are compiled in."""
    shutil.rmtree(STAGE, ignore_errors=True)
    shutil.copytree(
        KERNEL, STAGE, ignore=shutil.ignore_patterns("suspension_kernel_*", "__pycache__")
    )


class KernelBuild(build_ext):
    """Puts the compiled files into the kernel's folder; without a compiler, leaves them out."""

    def get_ext_fullpath(self, ext_name: str) -> str:
        file = Path(self.get_ext_filename(ext_name)).name
        return str(Path(self.build_lib, "suspension", "kernel", NAME, file))

    def copy_extensions_to_source(self) -> None:
        for ext in self.extensions:
            built = Path(self.get_ext_fullpath(ext.name))
            if built.exists():
                (KERNEL / NAME).mkdir(exist_ok=True)
                shutil.copy2(built, KERNEL / NAME / built.name)

    def get_output_mapping(self) -> dict[str, str]:
        return {}

    def run(self) -> None:
        try:
            super().run()
        except Exception as error:
            self._leave_uncompiled(error)

    def build_extension(self, ext: Extension) -> None:
        try:
            super().build_extension(ext)
        except Exception as error:
            self._leave_uncompiled(error)

    def _leave_uncompiled(self, error: Exception) -> None:
        self.warn(f"the integrator stays uncompiled: the same results, only slower ({error})")


staged()
setup(
    cmdclass={"build_ext": KernelBuild},
    ext_modules=cythonize(
        [
            Extension(
                f"{NAME}.{module}",
                [str(STAGE / f"{module}.py")],
                extra_compile_args=FLAGS,
                optional=True,
            )
            for module in MODULES
        ],
        compiler_directives={
            "language_level": 3,
            "boundscheck": False,
            "wraparound": False,
            "cdivision": True,
            "initializedcheck": False,
        },
        include_path=["build"],
    ),
)
