"""What is built and installed: the kernel as one module, and what is in the wheel."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest

setuptools = pytest.importorskip("setuptools", minversion="77")
ROOT = Path(__file__).parents[1]
INSTALLED_AS = {  # where the packages lie in the tree
    "phaseplane": "phaseplane",
    "fmu_src/suspension": "phaseplane/suspension",
    "fmu_src/vehicle_fmus": "phaseplane/vehicle_fmus",
    "scenarios": "phaseplane/scenarios",
}


def module_at(path: Path) -> Any:
    """A module that lies beside the packages; setup.py sets up nothing when it is imported."""
    spec = spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    before = list(sys.path)
    spec.loader.exec_module(module)
    sys.path[:] = before
    return module


@pytest.fixture(scope="module")
def installer() -> Any:
    return module_at(ROOT / "setup.py")


@pytest.fixture(scope="module")
def kernel_source(installer: Any) -> Any:
    return sys.modules[installer.joined.__module__]


def joined(kernel_source: Any, folder: Path, *texts: str) -> tuple[list[str], list[str]]:
    """The source and the types of a kernel of modules with these texts, line by line."""
    for number, text in enumerate(texts):
        folder.joinpath(f"part{number}.py").write_text(text)
    source, types = kernel_source.joined(folder)
    return [line for line in source.splitlines() if line.strip()], types.splitlines()


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("def _same(): return 1", "def _same(): return -1"),
        ("class _Same: pass", "class _Same: pass"),
        ("def _same(): return 1", "class _same: pass"),
        ("_SAME = 1", "_SAME, _OTHER = 2, 3"),
    ],
)
def test_two_meanings_of_one_name_are_refused(
    kernel_source: Any, tmp_path: Path, first: str, second: str
) -> None:
    with pytest.raises(ValueError, match=r"part1\.py: _(same|Same|SAME) "):
        joined(kernel_source, tmp_path, first, second)


@pytest.mark.parametrize("text", ["_N, _X = 2, (0.5,)", "_N: int = 2", "for _n in range(2): pass"])
def test_what_cannot_stand_at_the_top_of_a_module_is_refused(
    kernel_source: Any, tmp_path: Path, text: str
) -> None:
    with pytest.raises(ValueError, match=r"part0\.py: (numbers stand apart|not at the top)"):
        joined(kernel_source, tmp_path, text)


def test_modules_follow_one_another(kernel_source: Any, tmp_path: Path) -> None:
    source, _ = joined(
        kernel_source,
        tmp_path,
        "from itertools import count\n_N = (2.0,)\ndef root(): return next(count(_N[0])) ** 0.5",
        "from .part0 import root\n_N = (2.0,)\ndef twice(): return 2.0 * root()",
    )
    found: dict[str, Any] = {}
    exec("\n".join(source), found)
    assert found["twice"]() == pytest.approx(2.0 * 2.0**0.5)


def test_numbers_of_the_kernel_are_constants_of_c(kernel_source: Any, tmp_path: Path) -> None:
    source, types = joined(
        kernel_source,
        tmp_path,
        "_N, _M = 2, 3\n_X, _Y = 0.5, 1e9",
        "from math import sin, cos\n_N = 2",
    )
    assert source == []
    at = types.index("from libc.math cimport cos, sin")
    assert types[at + 1 :] == [
        "cdef extern from *:",
        '    """',
        "    static const double kernel__X = 0.5;",
        "    static const double kernel__Y = 1000000000.0;",
        '    """',
        '    double _X "kernel__X"',
        '    double _Y "kernel__Y"',
        "cdef enum:",
        "    _N = 2",
        "    _M = 3",
    ]


def test_types_for_cython(kernel_source: Any, tmp_path: Path) -> None:
    source, types = joined(
        kernel_source,
        tmp_path,
        """
class Sum:
    open: bool

    def __init__(self, blocks):
        self.blocks: list = blocks

    @open_to_python
    @uses_python
    def add(self, n: int, twice: bool = False) -> float:
        x = 0.0
        some = n > 1 and self.open
        for i in range(n):
            x += i
        for block in self.blocks:
            x += block
        return x if some else 0.0
""",
    )
    assert types[-6:] == [
        "@cython.final",
        "cdef class Sum:",
        "    cdef public bint open",
        "    cdef list blocks",
        "    @cython.locals(some=bint, i=int)",
        "    cpdef double add(self, int n, bint twice=*)",
    ]
    assert source[:4] == [
        "class Sum:",
        "    def __init__(self, blocks):",
        "        self.blocks = blocks",
        "    def add(self, n, twice=False):",
    ]


def test_every_module_of_the_kernel_is_compiled(installer: Any, kernel_source: Any) -> None:
    there = {path.stem for path in installer.KERNEL.rglob("*.py")}
    order = [module.path.stem for module in kernel_source.modules(installer.KERNEL)]
    assert set(order) == there - {"__init__", "language"}
    assert order.index("method") < order.index("extrapolated") < order.index("increments")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt" or not shutil.which("cc"), reason="no such compiler")
def test_a_compiler_that_refuses_flags_of_gcc_compiles_without_them(
    installer: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As Clang does, the compiler of macOS."""
    compiler, source = tmp_path / "compiler", tmp_path / "small.c"
    compiler.write_text(
        "#!/bin/sh\n"
        'for given in "$@"; do case "$given" in -fipa-*|-fno-tree-*) exit 1 ;; esac; done\n'
        'exec cc "$@"\n'
    )
    compiler.chmod(0o755)
    source.write_text("int small;\n")
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setenv("LDSHARED", f"{compiler} -shared")
    extension = setuptools.Extension("small", [str(source)])
    build = installer.KernelBuild(
        setuptools.Distribution({"name": "small", "ext_modules": [extension]})
    )
    build.build_lib, build.build_temp = str(tmp_path / "lib"), str(tmp_path / "temp")
    build.ensure_finalized()
    super(installer.KernelBuild, build).run()  # not from the sources of the kernel
    assert Path(build.get_ext_fullpath("small")).exists()


def carried() -> set[str]:
    """What lies in the packages of the tree, by the names it is installed under."""
    found = set()
    for folder, name in INSTALLED_AS.items():
        for path in (ROOT / folder).rglob("*"):
            below = path.relative_to(ROOT / folder)
            made = {"__pycache__"} & set(below.parts) or path.suffix in (".so", ".pyd")
            if path.is_file() and not made:
                found.add(f"{name}/{below.as_posix()}")
    return found


@pytest.fixture(scope="module")
def pure_wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from a copy of the tree that an older build, of other sources, has left things in."""
    tree = tmp_path_factory.mktemp("tree")
    for folder in INSTALLED_AS:
        shutil.copytree(ROOT / folder, tree / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "setup.py", "fmu_src/kernel_source.py", "README.md", "LICENSE"):
        shutil.copy2(ROOT / file, tree / file)
    left = tree / "build" / "lib" / "phaseplane" / "of_before.py"
    left.parent.mkdir(parents=True)
    left.touch()
    command = (
        "from setuptools import build_meta; import sys; print(build_meta.build_wheel(sys.argv[1]))"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", command, str(tree / "dist")],
        cwd=tree, env={**os.environ, "PHASEPLANE_PURE": "1"}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (wheel,) = (tree / "dist").iterdir()
    return wheel


@pytest.mark.slow
def test_the_pure_wheel_is_for_any_platform(pure_wheel: Path) -> None:
    assert pure_wheel.name.endswith("-py3-none-any.whl")


@pytest.mark.slow
def test_all_that_lies_in_the_packages_is_in_the_wheel(pure_wheel: Path) -> None:
    with zipfile.ZipFile(pure_wheel) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
    own = {name for name in names if name.startswith("phaseplane/")}
    assert own == carried()
    assert {name.split("/")[0].split("-")[0] for name in names} == {"phaseplane"}
    assert {name.split("/")[0].split(".")[-1] for name in names - own} == {"dist-info"}
