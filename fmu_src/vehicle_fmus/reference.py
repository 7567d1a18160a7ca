"""Reference results of an FMU: the files of the FMI cross-check, and their declaration inside it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement, register_namespace

from phaseplane.suspension.models import FILES, inputs, outputs
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import SOLVER_OUTPUTS, SOURCES, Value, refuse_unknown

from .model_description import written

STOP_TIME, STEP = 1.0, 0.005  # s
TOLERANCE = 1e-12
RELATIVE_TOLERANCE = 1e-6  # of a run with the FMU's start values

# Inputs are level up to the sample before this instant, then step. Read at the start of each
# communication step and held, they are the same in every tool.
_CHANGE = 0.5  # s
_STEPS = {"body_force": 200.0, "force": 2.0}  # N

_README = """\
Reference result of {model}.fmu with its start values.

{model}_ref.csv
    Outputs every {step:g} s, computed without the FMU by the same equations and the same method at a
    tolerance of {tolerance:g}. The independent solutions with which the method is compared are in
    tests/reference of the sources.
{model}_in.csv (where there are inputs)
    Inputs, to be read at the start of each communication step and held during it.
{model}_ref.opt
    Start, stop, communication step, and the largest allowed difference relative to the peak.
"""


# The layered standard FMI-LS-REF 1.0.0-alpha.1: what files there are in an FMU beside its own, and why
_LAYER = "extra/org.fmi-standard.fmi-ls-ref"
_MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
_ABOUT = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}
_PAGE = "documentation/fmi-ls-ref.txt"
_RELATED = {  # by the end of the name: MIME type, role, description
    "_ref.csv": ("text/csv", "result", "Outputs of a run with the start values, to high accuracy"),
    "_in.csv": ("text/csv", "testcase", "Inputs of that run, held during each communication step"),
    "_ref.opt": (
        "text/csv",
        "testcase",
        "Start, stop, communication step and tolerance of that run",
    ),
}


def declared_inside(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the reference result inside an FMU: the files, their declaration and a page.

    Parameters
    ----------
    files : from `reference_files`
    """
    register_namespace("fmi-ls", _MANIFEST)
    root = Element("fmiReferences", {f"{{{_MANIFEST}}}{key}": text for key, text in _ABOUT.items()})
    members = {}
    for name, content in files.items():
        for end, (kind, role, about) in _RELATED.items():
            if name.endswith(end):
                SubElement(root, "Related", type=kind, source=name, role=role, description=about)
                members[f"{_LAYER}/{name}"] = content
        if name.endswith("_readme.txt"):
            members[_PAGE] = content
    SubElement(
        root, "Related", type="text/plain", source=f"../../{_PAGE}", role="document",
        description="What the files are",
    )  # fmt: skip
    members[f"{_LAYER}/fmi-ls-manifest.xml"] = written(root)
    return members


def accepted_parameters(
    models: Sequence[str],
    parameters: Mapping[str, Mapping[str, object]],
    own: Collection[str],
) -> Iterator[tuple[str, dict[str, Value], Mapping[str, Value]]]:
    """Yield each model to pack with its start values, checked, and with all its parameters.

    Parameters
    ----------
    parameters : the start values by model; texts of tables are read
    own : names of user-defined systems that have been loaded

    Raises
    ------
    ParameterError : unknown model or parameter, or a value that is refused.
    """
    refuse_unknown(models, (*FILES, *own), f"FMUs exist for {', '.join(FILES)}, not for")
    refuse_unknown(parameters, models, "start values given for a model that is not built:")
    for model in models:
        given = parameters.get(model, {})
        accepted = Session(model, given).parameters  # reads the tables, too
        yield model, {name: accepted[name] for name in given}, accepted


def reference_files(model: str, start: Mapping[str, Value]) -> dict[str, bytes]:
    """Return reference result, inputs and options of an FMU, by file name.

    Parameters
    ----------
    model : name of an FMU
    start : parameters whose start values are not the defaults
    """
    strict = {"solver.tolerance": TOLERANCE} if model not in SOURCES else {}
    session = Session(model, {**start, **strict})
    kept = session.parameters.get("solver.energy", True)
    of_solver = {v.name for v in SOLVER_OUTPUTS}
    shown = [
        name
        for name, v in outputs(model).items()
        if isinstance(v.start, float) and name not in of_solver and (kept or not needs_ledger(name))
    ]
    driven = inputs(model)
    steps = {name: _STEPS[name] for name in driven if name in _STEPS}
    rows = []
    for k in range(round(STOP_TIME / STEP) + 1):
        time = k * STEP
        session.advance(time)
        rows.append([time, *(session.value(name) for name in shown)])
        if time >= _CHANGE:
            for name, value in steps.items():
                session.set_input(name, value)
    changes = [[t, *(steps.get(name, 0.0) * (t >= _CHANGE) for name in driven)]
               for t in (0.0, _CHANGE - STEP, _CHANGE, STOP_TIME)]  # fmt: skip
    options = {"StartTime": 0.0, "StopTime": STOP_TIME, "StepSize": STEP,
               "RelTol": RELATIVE_TOLERANCE}  # fmt: skip
    files = {
        f"{model}_ref.csv": _csv(["time", *shown], rows),
        f"{model}_ref.opt": "".join(f"{key}, {value!r}\n" for key, value in options.items()),
        f"{model}_readme.txt": _README.format(model=model, step=STEP, tolerance=TOLERANCE),
    }
    if driven:
        files[f"{model}_in.csv"] = _csv(["time", *driven], changes)
    return {name: text.encode() for name, text in files.items()}


def _csv(header: Sequence[str], rows: Iterable[Sequence[Value]]) -> str:
    lines = [",".join(f'"{name}"' for name in header)]
    lines.extend(",".join(f"{value:.15g}" for value in row) for row in rows)
    return "\n".join(lines) + "\n"
