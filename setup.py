"""Compile the integrator's kernel; everything else is declared in pyproject.toml."""

import ast
import re
import shutil
import sys
from pathlib import Path

from Cython.Build import cythonize
from setuptools import Extension, find_packages, setup
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
        "-finline-limit=200",
        "-fno-tree-loop-vectorize",
        "-fno-tree-loop-distribution",
        "-fno-tree-loop-distribute-patterns",
    ]
)
# in the order in which they need each other
MODULES = (
    "arrays", "linear", "bernstein", "signals", "laws", "elements", "network", "dense", "exact",
    "iteration", "lanes", "stepper", "switches", "cruise", "ledger", "watch", "march", "integrator",
)  # fmt: skip


def staged() -> str:
    """Write the kernel as one module under its hashed name, and say where.

    So the compiler sees it as a whole: from one module of Cython's to another it cannot carry
    anything over, and each brings half a megabyte with it. A module imports others only at its top,
    and what several of them define must be the same in all.
    """
    shutil.rmtree(STAGE, ignore_errors=True)
    STAGE.mkdir(parents=True)
    (STAGE / "__init__.py").touch()
    sources = [KERNEL / f"{module}.py" for module in MODULES]
    target = STAGE / "integrator.py"
    target.write_text(one_source(sources), encoding="utf-8")
    types = [path.with_suffix(".pxd") for path in sources]
    target.with_suffix(".pxd").write_text(one_set_of_types(types), encoding="utf-8")
    return str(target)


def one_source(paths: list[Path]) -> str:
    """All modules one after the other, without what they import from each other or uncompiled."""
    imports: dict[str, None] = {}
    known: dict[str, str] = {}
    bodies = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for node in ast.parse(text).body:
            written = ast.unparse(node)
            match node:
                case ast.Import() | ast.ImportFrom(level=0):
                    imports[written] = None
                case ast.Assign():
                    for name, value in assigned(node):
                        if known.setdefault(name, value) != value:
                            raise ValueError(f"{path.name}: {name} = {value}, not {known[name]}")
                    continue
                case ast.ImportFrom():
                    pass
                case ast.If() if "cython.compiled" in written:
                    pass
                case _:
                    continue
            for line in range(node.lineno - 1, node.end_lineno):
                lines[line] = ""
        bodies.append("\n".join(lines))
    return "\n".join([*imports, *bodies])


def assigned(node: ast.Assign) -> list[tuple[str, str]]:
    """The names that an assignment gives values, each with its own."""
    target, value = node.targets[0], node.value
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        pairs = zip(target.elts, value.elts, strict=True)
        return [(ast.unparse(name), ast.unparse(x)) for name, x in pairs]
    return [(ast.unparse(target), ast.unparse(value))]


def one_set_of_types(paths: list[Path]) -> str:
    """All declarations of C types, those of constants once each."""
    taken: dict[str, set[str]] = {}
    bodies = []
    for path in paths:
        if not path.exists():
            continue
        text = path.read_text(encoding="utf-8")
        for source, names in re.findall(r"^from (\S+) cimport (.+)$", text, re.MULTILINE):
            if not source.startswith("."):
                taken.setdefault(f"from {source} cimport", set()).update(names.split(", "))
        for kind, names in re.findall(r"^cdef (int|double) ([_A-Z0-9, ]+)$", text, re.MULTILINE):
            taken.setdefault(f"cdef {kind}", set()).update(names.split(", "))
        once = r"^(from \S+ cimport .+|cimport cython|cdef (int|double) [_A-Z0-9, ]+)$"
        bodies.append(re.sub(once, "", text, flags=re.MULTILINE))
    head = [f"{what} {', '.join(sorted(names))}" for what, names in taken.items()]
    return "\n".join(["cimport cython", *head, *bodies])


class KernelBuild(build_ext):
    """Puts the compiled files into the kernel's folder; without a compiler, leaves them out."""

    def get_ext_fullpath(self, ext_name: str) -> str:
        file = Path(self.get_ext_filename(ext_name)).name
        return str(Path(self.build_lib, "phaseplane", "suspension", "kernel", NAME, file))

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


def packages() -> list[str]:
    """Every package there is under its installed name, so that a new one is never left out."""
    here = find_packages(include=["phaseplane", "phaseplane.*"])
    mapped = [*find_packages("fmu_src"), *find_packages(include=["scenarios", "scenarios.*"])]
    return [*here, *(f"phaseplane.{name}" for name in mapped)]


setup(
    packages=packages(),
    cmdclass={"build_ext": KernelBuild},
    ext_modules=cythonize(
        [Extension(f"{NAME}.integrator", [staged()], extra_compile_args=FLAGS, optional=True)],
        compiler_directives={
            "language_level": 3,
            "boundscheck": False,
            "wraparound": False,
            "cdivision": True,
            "initializedcheck": False,
        },
    ),
)
