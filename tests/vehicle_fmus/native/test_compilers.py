"""Compilers that are missing or fail are named, and nothing is written."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from phaseplane.vehicle_fmus.native import compilers, pack


def compiler(folder: Path, script: str) -> str:
    """The path of a program that is called as a compiler is."""
    program = folder / "compiler"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    return str(program)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "why"),
    [("echo no such thing >&2; exit 1", "no such thing"), ("exit 0", "it wrote no library")],
)
def test_a_compiler_that_fails_is_named(
    script: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    named = compiler(tmp_path, script)
    monkeypatch.setenv("CC", named)
    here = compilers.this_platform()
    with pytest.raises(RuntimeError, match=f"compiler could not compile for {here}:\n{why}"):
        pack.build(["Road"], tmp_path / "out", platforms=[here])
    assert not (tmp_path / "out").exists()


def test_a_compiler_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another one, zig's for instance, does not take its place."""
    monkeypatch.setenv("CC", "/no/such/compiler -O1")
    with pytest.raises(ValueError, match="CC = '/no/such/compiler -O1': there is no such compiler"):
        compilers.chosen([compilers.this_platform()])


def test_without_any_compiler_both_ways_to_get_one_are_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(compilers, "has_zig", lambda: False)
    with pytest.raises(ValueError, match=r"set CC, or pip install '.\[native\]' in a clone"):
        compilers.chosen([])
