"""How Sphinx builds the site from README, CONTRIBUTING, CHANGELOG and these pages: see `.ci/pages`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from importlib.metadata import metadata
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

from phaseplane.suspension.models import ALL

import phaseplane

project = "phaseplane"
version = release = version_of("phaseplane")
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinxcontrib.programoutput",
    "sphinx_copybutton",
]

# the source folder is that of the project, so that links between README and pages hold everywhere
root_doc = "README"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "benchmarks/results.md",
    "docs/*.md",
    "docs/*/*.md",
]
templates_path = ["_templates"]

# what the front page's column shows; GitHub shows the README without it
CONTENTS = {
    "Begin": ("start", "installation", "terms", "messages"),
    "Guides": (
        "models",
        "gallery",
        "scenes",
        "comfort",
        "sweeps",
        "design",
        "systems",
        "controllers",
        "fmus",
        "guides/omsimulator",
        "guides/simulink",
        "python",
        "constructions",
        "figures",
        "recordings",
    ),
    "How it works": ("how_it_works", "kernel", "translator"),
    "How well it works": ("validation", "accuracy", "hosts"),
    "Reference": ("reference/commands", "reference/scenes", "reference/models", "reference/python"),
}
PROJECT = ("benchmarks/results", "CONTRIBUTING", "CHANGELOG")

html_theme = "furo"
html_title = "phaseplane"
html_additional_pages = {"index": "index.html"}  # leads to the front page
html_copy_source = False
html_static_path = ["_static"]
_URLS = dict(url.split(", ", 1) for url in metadata("phaseplane").get_all("Project-URL", []))
html_js_files = [
    (
        "recordings.js",
        {
            "data-viewer": f"https://app.rerun.io/version/{version_of('rerun-sdk')}/",
            "data-site": _URLS.get("Documentation", ""),
        },
    )
]
html_show_sphinx = False
html_show_copyright = False

myst_heading_anchors = 3

smartquotes = False  # they would make apostrophes of the primes of y''

# names in backticks are code; they are links only where a page says so
default_role = "code"
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_param = False

copybutton_prompt_text = "$ "


def _add_contents(_app: Any, page: str, source: list[str]) -> None:
    if page == root_doc:
        columns = {
            **{title: [f"docs/{name}" for name in names] for title, names in CONTENTS.items()},
            "Project": PROJECT,
        }
        for title, names in columns.items():
            entries = "\n".join(names)
            source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n{entries}\n```\n"


def _add_pages_of_models(_app: Any, page: str, source: list[str]) -> None:
    """Replace the short text on each model by the page inside its FMU: equations and symbols."""
    if page == "docs/models":
        for name, model in ALL.items():
            text, marker = f"!\\[{name}\\]\\(\\S+\\)\n", f"<!-- page: {name} -->"
            html = f"\n```{{raw}} html\n{model.page}\n```\n"
            source[0] = re.sub(
                f"(?s)({text}).*?{marker}", lambda found, html=html: found[1] + html, source[0]
            )


def _add_gallery(app: Any, page: str, source: list[str]) -> None:
    """Add the time histories of built-in scenes, drawn now."""
    if page == "docs/gallery":
        folder = Path(app.srcdir, "build", "gallery")
        folder.mkdir(parents=True, exist_ok=True)
        for name in re.findall(r"<!-- picture: (\w+) -->", source[0]):
            phaseplane.run(name).figure().save(folder / f"{name}.png")
        source[0] = re.sub(
            r"<!-- picture: (\w+) -->",
            r"![Time histories of \1](../build/gallery/\1.png)",
            source[0],
        )


def _without_types(lines: Iterable[str]) -> Iterator[str]:
    """Put what follows `name : ` below it: it is a description, where Sphinx expects a type."""
    previous, listed = "", False
    for line in lines:
        if set(line) == {"-"}:
            listed = previous in ("Parameters", "Raises", "Returns", "Yields", "Attributes")
        name, colon, text = line.partition(" : ")
        if listed and colon and not line.startswith(" "):
            yield name
            yield f"    {text}"
        else:
            yield line
        previous = line


def _rewrite(
    _app: Any, _what: str, _name: str, _thing: Any, _options: Any, lines: list[str]
) -> None:
    lines[:] = _without_types(list(lines))


def _shorten(
    _app: Any,
    _what: str,
    _name: str,
    _thing: Any,
    _options: Any,
    signature: str | None,
    back: str | None,
) -> tuple[str | None, str | None]:
    """Leave out defaults that are whole characteristics."""
    return re.sub(r"= Characteristic\(.*?\),\)\)", "= ...", signature or "") or None, back


def _leave_out(
    _app: Any, _what: str, _name: str, thing: Any, _skip: bool, _options: Any
) -> bool | None:
    """Leave out the method that matplotlib writes into every class of its artists."""
    return getattr(thing, "_autogenerated_signature", False) or None


def setup(app: Any) -> None:
    """Connect the rewriting of sources."""
    app.connect("source-read", _add_contents)
    app.connect("source-read", _add_pages_of_models)
    app.connect("source-read", _add_gallery)
    app.connect("autodoc-process-docstring", _rewrite, priority=1)  # before napoleon
    app.connect("autodoc-process-signature", _shorten)
    app.connect("autodoc-skip-member", _leave_out)
