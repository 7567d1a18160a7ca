"""Compile the integrator's kernel; everything else is declared in pyproject.toml.

With PHASEPLANE_PURE=1 in the environment nothing is compiled, and the wheel is for any platform.
"""

import gc
import os
import re
import shutil
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "fmu_src"))
from kernel_source import joined  # noqa: E402
from suspension.kernel_name import KERNEL, kernel_name  # noqa: E402

NAME = kernel_name()
STAGE = Path("build", "kernel", NAME)
PURE = os.environ.get("PHASEPLANE_PURE", "0") not in ("", "0")

# One binary for every CPython from 3.11 on, so that an FMU runs compiled in all of them. Against the
# full API steps cost at most 2 % more, calls of a method from Python a fifth (0.02 us), and making an
# integrator a quarter (80 us).
STABLE_ABI = sys.implementation.name == "cpython" and not sysconfig.get_config_var(
    "Py_GIL_DISABLED"
)
MACROS = [("Py_LIMITED_API", "0x030B0000"), ("CYTHON_LIMITED_API", "1")] if STABLE_ABI else []

# -ffp-contract=off: a fused multiply-add rounds once, so compiled and uncompiled runs would differ.
# -Wno-all: Python asks for -Wall, and looking for what to warn of takes a third of the compiling, even
# if -w keeps the warnings back.
FLAGS = ["-g0", "-Wno-all", "-w", "-ffp-contract=off", "-fno-wrapv", "-fno-math-errno"]
# What makes steps fast is that small functions are inlined, that loops of constant length are unrolled,
# and that functions are compiled for the arguments they get. Vectors only slow motions of two or four
# coordinates. Inlining may enlarge the code by 80 %, twice the default: steps take 3 % less time.
# Functions begin at cache lines: aligned to half of one, steps of a session took 7 % longer after code
# elsewhere had grown.
FLAGS_OF_GCC = [
    "-O3",
    "-fno-tree-vectorize",
    "-finline-limit=400",
    "--param=inline-unit-growth=80",
    "-falign-functions=64",
]
# GCC compiles one file on all cores if it does so when it links.
ON_ALL_CORES = ["-flto=auto", "-fno-fat-lto-objects"] if sys.platform == "linux" else []
# Other compilers refuse flags of GCC's.
ATTEMPTS = (
    [[]]
    if sys.platform == "win32"
    else [[*FLAGS, *FLAGS_OF_GCC, *ON_ALL_CORES], [*FLAGS, *FLAGS_OF_GCC], [*FLAGS, "-O3"]]
)
# Functions that Python calls take arguments apart and set things up. Without optimisation an integrator
# takes a quarter longer to make (16 us) and steps as long as before; the kernel compiles in two thirds of
# the time.
CALLED_FROM_PYTHON = re.compile(r"^static (?=[^;{=\n]*\b__pyx_p[wf]_)", re.MULTILINE)
UNOPTIMISED = """\
#if defined(__GNUC__) && !defined(__clang__)
#define UNOPTIMISED __attribute__((optimize("O0")))
#else
#define UNOPTIMISED
#endif
"""
DIRECTIVES = {
    "language_level": 3,
    "boundscheck": False,
    "wraparound": False,
    "cdivision": True,
    "initializedcheck": False,
    "auto_pickle": False,  # two fifths of the machine code, which nothing called
    "infer_types": True,  # local variables have the type of their first value
    "binding": False,  # methods as CPython's own: under the limited API they are called faster
    "warn.multiple_declarators": False,  # arrays of one kind are declared together
}


def staged() -> str:
    """Write the kernel as one module under its hashed name, and say where."""
    shutil.rmtree(STAGE.parent, ignore_errors=True)
    STAGE.mkdir(parents=True)
    (STAGE / "__init__.py").touch()
    target = STAGE / "interface.py"
    source, types = joined(KERNEL)
    target.write_text(source, encoding="utf-8")
    target.with_suffix(".pxd").write_text(types, encoding="utf-8")
    return str(target)


def translated(source: str) -> str:
    """Translate the kernel to C, and say where."""
    from Cython.Build import cythonize  # noqa: PLC0415 - a build without the kernel needs no Cython

    gc.disable()  # a third of the time goes into looking for garbage, of which there is next to none
    try:
        (module,) = cythonize(
            [Extension(f"{NAME}.interface", [source])], compiler_directives=DIRECTIVES
        )
    finally:
        gc.enable()
    target = Path(module.sources[0])
    text = target.read_text(encoding="utf-8")
    marked = CALLED_FROM_PYTHON.sub("UNOPTIMISED static ", text)
    target.write_text(UNOPTIMISED + marked, encoding="utf-8")
    return str(target)


class CleanBuild(build_py):
    """Collects the sources in an empty folder: what an earlier build left is not in the wheel."""

    def run(self) -> None:
        if not self.editable_mode:
            shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()


class KernelBuild(build_ext):
    """Puts the compiled file into the kernel's folder; without a compiler, leaves it out."""

    def get_ext_fullpath(self, ext_name: str) -> str:
        file = Path(self.get_ext_filename(ext_name)).name
        return str(Path(self.build_lib, "phaseplane", "suspension", "kernel", NAME, file))

    def copy_extensions_to_source(self) -> None:
        for old in KERNEL.glob("suspension_kernel_*"):
            shutil.rmtree(old)
        for ext in self.extensions:
            built = Path(self.get_ext_fullpath(ext.name))
            if built.exists():
                (KERNEL / NAME).mkdir()
                shutil.copy2(built, KERNEL / NAME / built.name)

    def get_output_mapping(self) -> dict[str, str]:
        return {}

    def run(self) -> None:
        source = staged()
        try:
            for ext in self.extensions:
                ext.sources = [translated(source)]
            super().run()
        except Exception as error:
            self._leave_uncompiled(error)

    def build_extensions(self) -> None:
        # Python's own linker flags name the folder of its library, which the kernel does not need: it
        # would stay in the file, and so in wheels and FMUs.
        linker = getattr(self.compiler, "linker_so", None)
        if linker is not None:
            self.compiler.linker_so = [flag for flag in linker if "-rpath" not in flag]
        super().build_extensions()

    def build_extension(self, ext: Extension) -> None:
        for flags in ATTEMPTS:
            try:
                self._compile(ext, flags)
                return
            except Exception as error:
                refusal = error
        self._leave_uncompiled(refusal)

    def _compile(self, ext: Extension, flags: list[str]) -> None:
        ext.extra_compile_args = ext.extra_link_args = flags
        super().build_extension(ext)

    def _leave_uncompiled(self, error: Exception) -> None:
        self.warn(f"the integrator stays uncompiled: the same results, only slower ({error})")


def packages() -> list[str]:
    """Every package there is under its installed name, so that a new one is never left out."""
    here = find_packages(include=["phaseplane", "phaseplane.*"])
    mapped = [*find_packages("fmu_src"), *find_packages(include=["scenarios", "scenarios.*"])]
    return [*here, *(f"phaseplane.{name}" for name in mapped)]


if __name__ == "__main__":
    kernel = Extension(
        f"{NAME}.interface",
        [],
        define_macros=MACROS,
        py_limited_api=STABLE_ABI,
        optional=True,
    )
    setup(
        packages=packages(),
        cmdclass={"build_py": CleanBuild, "build_ext": KernelBuild},
        ext_modules=[] if PURE else [kernel],
        options={"bdist_wheel": {"py_limited_api": "cp311"}} if STABLE_ABI else {},
    )
