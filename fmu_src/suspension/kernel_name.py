"""The name under which the integrator's kernel is imported."""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path

KERNEL = Path(__file__).parent / "kernel"


@cache
def kernel_name(folder: Path = KERNEL) -> str:
    """Return the name under which the kernel is imported; it changes with any of its sources.

    They are read once in a process, which has loaded them, too.
    """
    digest = sha256()
    for path in sorted(folder.rglob("*.py")):
        name = path.relative_to(folder).as_posix()
        digest.update(name.encode() + b"\0" + path.read_bytes())
    return f"suspension_kernel_{digest.hexdigest()[:12]}"
