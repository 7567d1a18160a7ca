"""FMUs that are packed once and kept."""

from __future__ import annotations

import os
from pathlib import Path

import phaseplane.vehicle_fmus.build as builder
import pytest
from phaseplane.scenarios.errors import RunError
from phaseplane.scenarios.simulate.fmu_cache import FOLDER_VARIABLE, cached_fmu
from phaseplane.vehicle_fmus import content
from phaseplane.vehicle_fmus.archives import zipped


@pytest.fixture(autouse=True)
def _of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "cache"))


def counting(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Packing that writes a small archive and notes where."""
    built: list[Path] = []

    def build(models: list[str], folder: Path) -> list[Path]:
        path = Path(folder, f"{models[0]}.fmu")
        path.write_bytes(zipped({"modelDescription.xml": b"description"}))
        built.append(path)
        return [path]

    monkeypatch.setattr(builder, "build", build)
    return built


def test_equal_content_is_packed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built = counting(monkeypatch)
    first, took = cached_fmu("QuarterCar", tmp_path)
    again, not_again = cached_fmu("QuarterCar", tmp_path)
    assert first == again
    assert (len(built), not_again) == (1, 0.0)
    assert took > 0.0
    assert (first / "modelDescription.xml").read_bytes() == b"description"
    assert [path.name for path in first.parent.iterdir()] == ["QuarterCar"]
    assert cached_fmu("OneDof", tmp_path)[0] != first
    monkeypatch.setattr(content, "installed", lambda _name: "another version of pythonfmu")
    assert cached_fmu("QuarterCar", tmp_path)[0].parent != first.parent
    assert [path.name for path in first.parent.parent.glob(".draft*")] == []


def test_the_content_is_hashed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    hashed: list[object] = []
    digest_of = content.digest_of
    monkeypatch.setattr(content, "digest_of", lambda files: (hashed.append(1), digest_of(files))[1])
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1234567890")  # under which no other test has asked
    keys = {content.content_key("QuarterCar") for _ in range(3)}
    assert (len(keys), len(hashed)) == (1, 1)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1234567891")
    assert content.content_key("QuarterCar") not in keys


def test_only_the_last_used_are_kept_and_nothing_else_is_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counting(monkeypatch)
    cache = tmp_path / "cache"
    for k in range(20):
        folder = cache / f"{k:024x}"
        folder.mkdir(parents=True)
        os.utime(folder, (k, k))
    (cache / "somebody elses").mkdir()
    path, _ = cached_fmu("QuarterCar", tmp_path)
    left = {entry.name for entry in cache.iterdir()}
    assert left == {path.parent.name, "somebody elses", *(f"{k:024x}" for k in range(5, 20))}


def test_where_nothing_can_be_kept_it_is_packed_for_this_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counting(monkeypatch)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "file" / "cache"))
    (tmp_path / "spare").mkdir()
    assert cached_fmu("QuarterCar", tmp_path / "spare")[0].parent == tmp_path / "spare"


def test_a_failed_build_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("pythonfmu said:\nno")

    monkeypatch.setattr(builder, "build", fail)
    with pytest.raises(RunError, match="cannot pack QuarterCar: pythonfmu said: no"):
        cached_fmu("QuarterCar", tmp_path)
    assert not any((tmp_path / "cache").iterdir())


def test_what_is_kept_under_a_name_that_no_fmu_can_be_loaded_from_is_copied(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built = counting(monkeypatch)
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "50 %"))
    for spare in (tmp_path / "one", tmp_path / "two"):
        spare.mkdir()
        folder, _ = cached_fmu("QuarterCar", spare)
        assert folder == spare / "QuarterCar"
        assert (folder / "modelDescription.xml").exists()
    assert len(built) == 1
