"""Make the page for the class: static files that any web server can serve.

npm pack pyodide@314.0.7 && tar xzf pyodide-314.0.7.tgz
PHASEPLANE_PURE=1 python -m pip wheel --no-deps -w dist .
python docs/classroom/make.py site --pyodide package --wheel dist/phaseplane-*.whl
python -m http.server -d site
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from phaseplane.scenarios.draw.classroom import answered

from phaseplane.exercises.pages import asset

HERE = Path(__file__).parent
FIRST = "van_der_pol"
RUNTIME = (
    "pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip",
    "pyodide-lock.json",
)  # fmt: skip
NOT_NEEDED = ("/recording/", "/figures/", "/portrait/", "/vehicle_fmus/documentation/")


def main() -> None:
    """Read the options and make the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="where to")
    parser.add_argument("--pyodide", type=Path, required=True, help="the unpacked npm package")
    parser.add_argument("--wheel", type=Path, required=True, help="the pure wheel of phaseplane")
    given = parser.parse_args()
    make(given.folder, given.pyodide, given.wheel)


def make(folder: Path, pyodide: Path, wheel: Path) -> None:
    """Write the page into a folder, with a snapshot of Python's memory, which Node.js takes."""
    (folder / "pyodide").mkdir(parents=True, exist_ok=True)
    for name in RUNTIME:
        if (pyodide / name).is_file():
            shutil.copy(pyodide / name, folder / "pyodide" / name)
    for name in ("index.html", "classroom.js"):
        shutil.copy(HERE / name, folder / name)
    for name in ("player.js", "player.css"):
        (folder / name).write_text(asset(name), encoding="utf-8")
    (folder / "first.json").write_text(first(), encoding="utf-8")
    loader = find_spec("lazy_loader")
    assert loader is not None
    assert loader.origin is not None
    with ZipFile(wheel) as whole, ZipFile(folder / "phaseplane.zip", "w", ZIP_DEFLATED) as needed:
        for name in whole.namelist():
            if not any(part in f"/{name}" for part in NOT_NEEDED):
                needed.writestr(name, whole.read(name))
        needed.write(loader.origin, "lazy_loader/__init__.py")
    subprocess.run(["node", str(HERE / "snapshot.mjs"), str(folder)], check=True)


def first() -> str:
    """Return the sheet that the page shows before Python is there."""
    fields = json.loads(answered(json.dumps({"what": "scene", "scene": FIRST})))
    asked = {"what": "sheet", "scene": FIRST, **fields}
    data = {
        "scene": FIRST,
        "fields": fields,
        "catalogue": json.loads(answered(json.dumps({"what": "catalogue"}))),
        "sheet": json.loads(answered(json.dumps(asked))),
    }
    return json.dumps(data, ensure_ascii=False)


if __name__ == "__main__":
    main()
