"""The sweeps that come with the package."""

from __future__ import annotations

import tomllib

from ..scene.names import SWEEPS


def sweep_titles() -> dict[str, str]:
    """Name and title of the sweeps that come with the package."""
    return {
        path.stem: str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        for path in sorted(SWEEPS.glob("*.toml"))
    }
