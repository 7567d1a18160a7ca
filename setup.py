"""Compile the integrator's kernel; everything else is declared in pyproject.toml.

With PHASEPLANE_PURE=1 in the environment nothing is compiled, and the wheel is for any platform.
"""

import ast
import gc
import os
import re
import shutil
import sys
import sysconfig
from graphlib import TopologicalSorter
from pathlib import Path

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "fmu_src"))
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
# What makes steps fast is that small functions are inlined and that others are compiled for the
# arguments they get. With these passes steps take less time at -O1 than at -O3, which takes twice as long
# to compile. Inlining may enlarge the code by 80 %, twice the default: steps take 3 to 7 % less time.
FLAGS_OF_GCC = [
    "-O1",
    "-finline-functions",
    "-finline-small-functions",
    "-findirect-inlining",
    "-fpartial-inlining",
    "-finline-limit=400",
    "--param=inline-unit-growth=80",
    "-fipa-cp",
    "-fipa-cp-clone",
    "-fipa-ra",
    "-fstrict-aliasing",
    "-fpeel-loops",
    "-fcaller-saves",
    "-fthread-jumps",
    "-freorder-blocks-algorithm=stc",
    "-fno-tree-dominator-opts",
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
# takes a tenth longer to make and steps as long as before; the kernel compiles in two thirds of the time.
CALLED_FROM_PYTHON = re.compile(r"^static (?=[^;{=\n]*\b__pyx_p[wf]_)", re.MULTILINE)
# Substeps are compiled at -O3, which unrolls their loops early: runs with curved forces take 10 to 20 %
# less time, and compiling 1 s more. The attribute resets the flags above, so it names them again.
INNERMOST = re.compile(
    r"^static (?=[^;{=\n]*\b__pyx_f_\w+_"
    r"(?:\d+(?:Columns|Inverses|Iteration|Balance|Bends|Laws|Modes)_|(?:multiply|resist)\b))",
    re.MULTILINE,
)
LEVELS = """\
#if defined(__GNUC__) && !defined(__clang__)
#define CALLED_FROM_PYTHON __attribute__((optimize("O0")))
#define INNERMOST __attribute__((optimize("O3", "fp-contract=off", "no-math-errno", \
    "no-wrapv", "no-tree-loop-vectorize", "no-tree-slp-vectorize")))
#else
#define CALLED_FROM_PYTHON
#define INNERMOST
#endif
"""
# Calls of methods by a class's table, the functions they may be, and the entries of such tables. The
# compiler can neither inline nor leave out what a table contains.
CALL = re.compile(
    r"\(\(struct __pyx_vtabstruct_\w+ \*\)[\w>.-]*__pyx_vtab\)->(?:__pyx_base\.)*(\w+)(?=\()"
)
METHOD = re.compile(r"^static [^;{=\n]*\b(__pyx_f_\w+_\d+[A-Za-z]+_(\w+))\(", re.MULTILINE)
ENTRY = re.compile(r"^  __pyx_vtable_\w+\.(?:__pyx_base\.)*(\w+) = \(.*;\n", re.MULTILINE)
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
CLASS = re.compile(r"^cdef class (\w+)", re.MULTILINE)
FUNCTIONS = re.compile(r"^    from math import (.+)$", re.MULTILINE)  # where uncompiled
ROUTINE = re.compile(r"( *)cdef (?!class )(?:inline )?[\w ]+?\**(\w+)\(.*")


def staged() -> str:
    """Write the kernel as one module under its hashed name, and say where.

    So the compiler sees it as a whole: from one module of Cython's to another it cannot carry
    anything over (they call each other by pointers found at run time, which optimisation at link time
    does not see through), and each brings half a megabyte with it. A module imports others only at its
    top; constants that several of them define must be the same in all, and functions and classes have
    names of their own.
    """
    shutil.rmtree(STAGE.parent, ignore_errors=True)
    STAGE.mkdir(parents=True)
    (STAGE / "__init__.py").touch()
    sources = modules()
    texts = [with_types_of_locals(path) for path in sources]
    target = STAGE / "integrator.py"
    source, constants = one_source(sources)
    target.write_text(source, encoding="utf-8")
    functions = {
        name
        for path in sources
        for names in FUNCTIONS.findall(path.read_text(encoding="utf-8"))
        for name in names.split(", ")
    }
    declared = one_set_of_types(texts, constants, functions)
    target.with_suffix(".pxd").write_text(declared, encoding="utf-8")
    return str(target)


def modules() -> list[Path]:
    """The modules of the kernel, each after those whose classes are among its types."""
    types = {path: declarations(path) for path in sorted(KERNEL.glob("[a-z]*.py"))}
    owners = {name: path for path, text in types.items() for name in CLASS.findall(text)}
    needed = {
        path: {owners[name] for name in re.findall(r"\w+", text) if name in owners} - {path}
        for path, text in types.items()
    }
    return list(TopologicalSorter(needed).static_order())


def declarations(path: Path) -> str:
    """The C types beside a module, if it has any."""
    types = path.with_suffix(".pxd")
    return types.read_text(encoding="utf-8") if types.exists() else ""


def one_source(paths: list[Path]) -> tuple[str, dict[str, int | float]]:
    """All modules one after the other, and their constants.

    Left out is what modules import from each other or uncompiled, and integers, which C has as constants.

    Raises
    ------
    ValueError : two modules define the same function or class, or different constants of one name; in
        one module, the later would take the place of the earlier. Or one statement defines integers
        and other constants.
    """
    imports: dict[str, None] = {}
    known: dict[str, str] = {}
    defined: dict[str, str] = {}
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
                    pairs = assigned(node)
                    for name, value in pairs:
                        if known.setdefault(name, value) != value:
                            raise ValueError(f"{path.name}: {name} = {value}, not {known[name]}")
                    kinds = {isinstance(number(value), int) for _, value in pairs}
                    if len(kinds) > 1:
                        raise ValueError(f"{path.name}: integers stand apart: {written}")
                    if kinds == {False}:
                        continue
                case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                    if name in defined:
                        raise ValueError(f"{path.name}: {name} is defined in {defined[name]}, too")
                    defined[name] = path.name
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
    constants = {name: x for name, value in known.items() if (x := number(value)) is not None}
    return "\n".join([*imports, *bodies]), constants


def number(text: str) -> int | float | None:
    """The value of an expression of numbers; None if it is another one."""
    try:
        value = eval(text, {"__builtins__": {}})
    except NameError:
        return None
    return value if type(value) in (int, float) else None


def assigned(node: ast.Assign) -> list[tuple[str, str]]:
    """The names that an assignment gives values, each with its own."""
    target, value = node.targets[0], node.value
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        pairs = zip(target.elts, value.elts, strict=True)
        return [(ast.unparse(name), ast.unparse(x)) for name, x in pairs]
    return [(ast.unparse(target), ast.unparse(value))]


def one_set_of_types(
    texts: list[str], constants: dict[str, int | float], functions: set[str]
) -> str:
    """All declarations of C types, and those of constants and mathematical functions."""
    doubles = ", ".join(name for name, x in constants.items() if isinstance(x, float))
    integers = [f"    {name} = {x}" for name, x in constants.items() if isinstance(x, int)]
    head = [
        "cimport cython",
        f"from libc.math cimport {', '.join(sorted(functions))}",
        f"cdef double {doubles}",
    ]
    bodies = [text.replace("cimport cython\n", "") for text in texts]
    return "\n".join([*head, "cdef enum:", *integers, *bodies])


def with_types_of_locals(path: Path) -> str:
    """The declarations of a module, with types for those local variables whose types Cython mistakes.

    It takes conditions for objects, and variables of loops for long integers, which cost time.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    owners = {"": tree} | {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    routines = {
        (owner, node.name): node
        for owner, place in owners.items()
        for node in place.body
        if isinstance(node, ast.FunctionDef)
    }
    owner, lines = "", []
    for line in declarations(path).splitlines():
        if line.startswith("cdef class "):
            owner = re.split(r"\W+", line)[2]
        if found := ROUTINE.fullmatch(line):
            indent, name = found[1], found[2]
            types = types_of_locals(routines[owner if indent else "", name])
            if types:
                given = ", ".join(f"{local}={kind}" for local, kind in types.items())
                lines.append(f"{indent}@cython.locals({given})")
        lines.append(line)
    return "\n".join(lines)


def types_of_locals(routine: ast.FunctionDef) -> dict[str, str]:
    """The variables of loops, and those that hold conditions, with their C types."""
    found = {}
    for node in ast.walk(routine):
        match node:
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"))):
                found[name] = "int"
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if is_condition(value):
                found[name] = "bint"
    return found


def is_condition(node: ast.expr) -> bool:
    """Whether an expression is true or false."""
    match node:
        case ast.Compare() | ast.UnaryOp(op=ast.Not()) | ast.Constant(value=bool()):
            return True
        case ast.BoolOp(values=values):
            return any(map(is_condition, values))
    return False


def translated(source: str) -> str:
    """Translate the kernel to C, and say where."""
    from Cython.Build import cythonize  # noqa: PLC0415 - a build without the kernel needs no Cython

    gc.disable()  # a third of the time goes into looking for garbage, of which there is next to none
    try:
        (module,) = cythonize(
            [Extension(f"{NAME}.integrator", [source])], compiler_directives=DIRECTIVES
        )
    finally:
        gc.enable()
    target = Path(module.sources[0])
    text = target.read_text(encoding="utf-8")
    marked = CALLED_FROM_PYTHON.sub("CALLED_FROM_PYTHON static ", called_by_name(text))
    marked = INNERMOST.sub("INNERMOST static ", marked)
    target.write_text(LEVELS + marked, encoding="utf-8")
    return str(target)


def called_by_name(text: str) -> str:
    """The C of the kernel with methods that one class alone defines called by their own names."""
    functions: dict[str, set[str]] = {}
    for function, method in METHOD.findall(text):
        functions.setdefault(method, set()).add(function)
    only = {method: min(found) for method, found in functions.items() if len(found) == 1}
    text = CALL.sub(lambda call: only.get(call[1], call[0]), text)
    called = set(re.findall(r"->(?:__pyx_base\.)*(\w+)", ENTRY.sub("", text)))
    return ENTRY.sub(lambda entry: entry[0] if entry[1] in called else "", text)


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
        f"{NAME}.integrator",
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
