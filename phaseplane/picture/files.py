"""Files that are written completely or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from errno import EISDIR
from pathlib import Path
from secrets import token_hex


@contextmanager
def replace_file(target: Path) -> Iterator[Path]:
    """Yield a temporary file beside the target, which it replaces if there is no error.

    Raises
    ------
    OSError : if the folder does not exist, or the file cannot be written, for the reason that is its
        cause; the target is as it was.
    """
    if not target.parent.is_dir():
        folder = target.parent
        raise FileNotFoundError(f"{target}: the folder {folder} does not exist; create it first")
    temporary = target.with_name(f".{token_hex(8)}{target.suffix}")
    try:
        temporary.touch(exist_ok=False)
        if target.is_dir():
            raise IsADirectoryError(EISDIR, "it is a folder; give the name of a file in it")
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise type(error)(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)
