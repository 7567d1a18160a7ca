"""What the commands do: a scene run into its folder, FMUs packed, a construction replayed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from suspension.variables import ParameterError, refuse_unknown

from .errors import (
    MOVING,
    PICTURES,
    DrawingError,
    InputError,
    RunError,
    SceneError,
    check_picture,
    one_line,
)
from .layers import find_scene
from .results import (
    Results,
    check_replaceable,
    read_results,
    read_summary,
    replaced_whole,
    write_results,
    write_summary,
)
from .tables import read_table

OUTPUT = Path("out")


def run_scene(
    reference: str,
    overrides: Sequence[str] = (),
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    viewer: str = "",
    save: Path | None = None,
    realtime: bool = False,
) -> tuple[dict[str, Any], Path]:
    """Run a scene and leave results, pictures and recording in a folder, which is replaced whole.

    Parameters
    ----------
    reference : name of a case, or path of a scene file
    overrides : `key=value` texts
    folder : None for `out/<scene>`
    viewer : address of a running viewer that shows the run while it goes on; whatever becomes of
        it, the run does not notice
    save : a recording (.rrd) that is written while the run goes on, and whole at its end
    realtime : whether the run waits for the clock

    Returns
    -------
    The summary as it was written, and the folder.

    Raises
    ------
    InputError : a scene that cannot be read or drawn, a folder that must not be replaced.
    RunError : the run could not begin.
    """
    from .constructions import constructed, drifting, told_of  # noqa: PLC0415
    from .live import shown_live  # noqa: PLC0415
    from .loading import load_scene  # noqa: PLC0415
    from .pictures import draw_all  # noqa: PLC0415
    from .planes import CONSTRUCTED  # noqa: PLC0415
    from .runner import run  # noqa: PLC0415

    _check_targets(save, None)
    scene = load_scene(reference, overrides)
    folder = folder or OUTPUT / scene.name
    check_replaceable(folder)
    problems: list[str] = []
    drawing, told = None, None
    known = scene.fmu.model in CONSTRUCTED
    if scene.show.figures_construction or (known and scene.show.records_construction):
        started = perf_counter()
        try:
            drawing = constructed(
                scene.fmu.model,
                scene.all_parameters,
                scene.construction.model_dump(),
                scene.construction_time,
            )
            drawing_time = perf_counter() - started
        except (ArithmeticError, DrawingError) as error:
            problems.append(f"the construction cannot be drawn: {one_line(error)}")
        except InputError:
            if scene.show.figures_construction:
                raise
            # a recording alone does without, as of any model that has no construction
    with shown_live(scene, drawing, viewer, save) as live:
        watch = live.watch if live is not None else None
        results = run(scene, progress=progress, watch=watch, realtime=realtime)
        if live is not None:
            problems += live.complete(results)
    if drawing is not None:
        drawing = drifting(drawing, results.columns)
        told = told_of(drawing, drawing_time)
    with replaced_whole(folder) as draft:
        problems += draw_all(scene, results, drawing, draft)
        results = Results(results.columns, {**results.summary, "drawn": told, "problems": problems})
        write_results(results, draft)
    return read_summary(folder) or {}, folder


def build_models(models: Sequence[str], folder: Path, ssp: bool = False) -> list[Path]:
    """Pack the FMUs of the models named, or of all, each with a reference result beside it.

    Parameters
    ----------
    ssp : whether each vehicle is packed on its road as a system, too

    Raises
    ------
    InputError : no such model, or a folder that cannot be written to.
    RunError : an FMU could not be packed.
    """
    from vehicle_fmus.build import SCRIPTS, build  # noqa: PLC0415  (heavy)

    try:
        refuse_unknown(models, SCRIPTS, "there is no FMU of")
        folder.mkdir(parents=True, exist_ok=True)
        chosen = list(dict.fromkeys(models)) or list(SCRIPTS)
        return build(chosen, folder, references=True, ssp=ssp)
    except ParameterError as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(one_line(f"cannot write {folder}: {error.strerror or error}")) from None
    except RuntimeError as error:
        raise RunError(one_line(error)) from error


def accuracy(
    references: Sequence[str],
    with_peers: bool,
    repeats: int,
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[dict[str, Any], str, Path]:
    """Compare error against run time, and leave data, tables and a picture in a folder.

    Parameters
    ----------
    references : names of problems or scenes; none for all problems
    repeats : how often each run is timed
    folder : replaced whole; None for `out/accuracy`

    Returns
    -------
    The data, the tables as text, and the folder.

    Raises
    ------
    InputError : no such problem or scene, or one that is no model of this project.
    """
    from phaseplane import figures  # noqa: PLC0415  (imports matplotlib)

    from .studies.accuracy import measure, solvers  # noqa: PLC0415
    from .studies.problems import PROBLEMS, find_problem  # noqa: PLC0415
    from .studies.telling import as_data, panels, table  # noqa: PLC0415

    folder = folder or OUTPUT / "accuracy"
    check_replaceable(folder)
    problems = [find_problem(name) for name in references or PROBLEMS]
    compared = solvers(with_peers=with_peers)
    points = []
    for k, problem in enumerate(problems):

        def part(done: float, k: int = k) -> None:
            if progress is not None:
                progress((k + done) / len(problems))

        points += measure(problem, compared, repeats, part)
    data = as_data(problems, points, repeats)
    tables = "\n\n".join(table(problem, points) for problem in problems)
    with replaced_whole(folder) as draft:
        figure = figures.work_precision(panels(problems, points), title="Error against run time")
        figures.save(figure, draft / "accuracy.png")
        (draft / "accuracy.txt").write_text(f"{tables}\n", encoding="utf-8")
        write_summary(data, draft)
    return data, tables, folder


def stability(
    references: Sequence[str],
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
    size: int = 32,
) -> tuple[dict[str, Any], str, Path]:
    """Find where steps grow, and leave data, a table and a picture in a folder.

    Parameters
    ----------
    references : names of problems or scenes; none for all problems with switches
    folder : replaced whole; None for `out/stability`
    size : points on a side of the maps

    Returns
    -------
    The data, the table as text, and the folder.

    Raises
    ------
    InputError : no such problem or scene, or one that is no model of this project.
    """
    from phaseplane import figures  # noqa: PLC0415  (imports matplotlib)
    from phaseplane.figures.stability import GrowthMap  # noqa: PLC0415

    from .studies import stability as study  # noqa: PLC0415
    from .studies.problems import PROBLEMS, find_problem  # noqa: PLC0415

    folder = folder or OUTPUT / "stability"
    check_replaceable(folder)
    problems = [find_problem(name) for name in references or PROBLEMS]
    if not references:
        problems = [problem for problem in problems if problem.kind == "non-smooth"]

    def part(first: float, width: float) -> Callable[[float], None]:
        return lambda done: progress(first + width * done) if progress is not None else None

    made = study.maps(size, part(0.0, 0.5))
    found = study.limits(problems, part(0.5, 0.3))
    happened = study.extremes(part(0.8, 0.2))
    data, table = study.as_data(made, found, happened), study.table(found, happened)
    figure = figures.stability_sheet(
        {name: (made.phases, curve) for name, curve in made.curves.items()},
        {"2√3": study.LINEAR, "order 8: 3.2": study.EIGHTH},
        [
            GrowthMap("Order 8, spectral radius of a step", made.grid, made.damping_ratios,
                      "damping ratio", made.damped, study.EIGHTH),
            GrowthMap("Linear acceleration, two masses: of a step", made.grid, made.ratios,
                      "ratio of the springs", made.coupled, study.LINEAR),
            GrowthMap("Linear acceleration between stops: energy", made.grid, made.ratios,
                      "stop over spring", made.bounced, study.LINEAR),
        ],
        [
            (one.problem, one.method, one.theory, one.measured)
            for one in found
            if one.theory is not None
        ],
    )  # fmt: skip
    with replaced_whole(folder) as draft:
        figures.save(figure, draft / "stability.png")
        (draft / "stability.txt").write_text(f"{table}\n", encoding="utf-8")
        write_summary(data, draft)
    return data, table, folder


def replay(
    what: str,
    overrides: Sequence[str],
    recording: Path | None,
    figure: Path | None,
    viewer: str = "",
    over: Path | None = None,
    *,
    kind: str = "phase_planes",
    dark: bool = False,
) -> dict[str, Any]:
    """Make the construction of a scene, or lay it over the results of a run, and write it down.

    Parameters
    ----------
    what : a scene, a results folder, or the table in one
    over : a table with the motion that the construction of the scene is laid over
    overrides : `key=value` texts; for results only those of `construction`
    recording, figure : files to be written
    viewer : address of a running viewer that is to show it
    kind : name of the figure; the rule that it shows is taken where overrides name none
    dark : whether the figure has a dark ground

    Raises
    ------
    InputError : a scene, folder or file name that is not fit.
    RunError : the construction leaves every sheet; the viewer does not take the recording.
    """
    from .constructions import constructed, laid_over, told_of  # noqa: PLC0415
    from .live import show_in  # noqa: PLC0415
    from .loading import construction_settings, load_scene  # noqa: PLC0415
    from .pictures import RULES_SHOWN, draw, record  # noqa: PLC0415
    from .replays import content, of_results, readings  # noqa: PLC0415
    from .sections import CONSTRUCTION_FIGURES  # noqa: PLC0415

    _check_targets(recording, figure)
    try:
        refuse_unknown([kind], CONSTRUCTION_FIGURES, "--kind: there is no figure")
    except ParameterError as error:
        raise InputError(str(error)) from None
    started = perf_counter()
    if figure is not None and kind in RULES_SHOWN:
        overrides = (f"construction.rule={RULES_SHOWN[kind]}", *overrides)
    folder = _results_folder(Path(what))
    if folder is not None and over is None:
        results = read_results(folder)
        run = results.summary
        settings = construction_settings(run["construction"], overrides)
        drawing = laid_over(results.columns, run["model"], run["parameters"], settings)
        shown = of_results(results, drawing, {})
    else:
        scene = load_scene(_scene_or_folder(what), overrides)
        settings = scene.construction.model_dump()
        model, parameters = scene.fmu.model, scene.all_parameters
        columns = read_table(over)[0] if over is not None else {}
        try:
            drawing = (
                laid_over(columns, model, parameters, settings)
                if over is not None
                else constructed(model, parameters, settings, scene.construction_time)
            )
        except ArithmeticError as error:
            raise RunError(f"the construction cannot be drawn: {one_line(error)}") from None
        shown = content(
            title=scene.title or scene.name,
            model=scene.fmu.model,
            parameters=scene.all_parameters,
            drawing=drawing,
            columns=columns or readings(drawing),
            units={},
            duration=scene.duration,
            shown={},
        )
    if recording is not None:
        record(shown, recording)
    if viewer:
        show_in(shown, viewer)
    if figure is not None:
        try:
            draw(kind, figure, drawing, title=shown.title, dark=dark)
        except ValueError as error:  # it has not got what the figure shows
            raise InputError(f"--kind {kind}: {one_line(error)}") from None
    files = [str(path) for path in (recording, figure) if path is not None]
    return {**told_of(drawing, perf_counter() - started), "files": files}


def _results_folder(path: Path) -> Path | None:
    """The results folder at this path, or that in which the table at this path lies."""
    if path.is_dir():
        return path
    return path.parent if path.is_file() and read_summary(path.parent) is not None else None


def _scene_or_folder(what: str) -> str:
    """The reference of a scene; refuses what is neither that nor a folder."""
    if Path(what).suffix in (".csv", ".parquet", ".h5"):
        raise InputError(
            one_line(
                f"{what} does not say what moved; lay it over a scene: replay SCENE --over {what}"
            )
        )
    try:
        find_scene(what)
    except SceneError as error:
        raise SceneError(f"{error}, or of a results folder") from None
    return what


def _check_targets(recording: Path | None, figure: Path | None) -> None:
    """Refuse names of files before anything is computed."""
    if recording is not None and recording.suffix != ".rrd":
        raise InputError(one_line(f"--save {recording}: the name must end in .rrd"))
    if figure is not None:
        check_picture(figure, PICTURES + MOVING)
    if recording is not None and not recording.parent.is_dir():
        raise InputError(one_line(f"{recording}: no folder {recording.parent}; make it first"))
