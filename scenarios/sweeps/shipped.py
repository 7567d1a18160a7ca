"""The sweeps in the package."""

from __future__ import annotations

import tomllib

from ..scene.names import SWEEPS


def sweep_titles() -> dict[str, str]:
    """Return the names and titles of the sweeps in the package."""
    return {
        path.stem: str(tomllib.loads(path.read_text(encoding="utf-8")).get("title", ""))
        for path in sorted(SWEEPS.glob("*.toml"))
    }
