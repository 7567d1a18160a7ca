"""Recordings served to a browser by rerun's server and web viewer, in a separate process."""

from __future__ import annotations

import os
import socket
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote, urlsplit

LOOPBACK = "127.0.0.1"
_PORTS = (9876, 9090)  # of rerun, for recordings and for the page
_SERVES = b"Hosting a web-viewer at"  # what the server says when both ports are its own
_TRIES = 3
_ANSWER = 120.0  # s within which a server that lives must answer, on a busy machine, too


@dataclass(frozen=True, slots=True)
class Server:
    """A running server."""

    page: str  # address of the page that shows the recordings
    url: str  # address to which recordings are sent, and from which they are read
    process: subprocess.Popen[bytes]

    def wait(self) -> None:
        """Wait until the server ends, or for an interrupt."""
        while self.process.poll() is None:
            time.sleep(0.2)


@contextmanager
def serving(
    files: Sequence[str | os.PathLike[str]] = (), address: str = LOOPBACK
) -> Iterator[Server]:
    """Serve recordings from files and those sent to the server, until the end of the block.

    Parameters
    ----------
    files : recordings to serve from the start
    address : of this machine, to listen at; only the loopback address is closed to other machines

    Raises
    ------
    OSError : if the server cannot listen at the address, or a file is not a recording.
    """
    host = socket.gethostname() if address in ("0.0.0.0", "::") else address
    host = f"[{host}]" if ":" in host else host
    address = _numeric(address)
    with TemporaryDirectory() as folder:
        for _ in range(_TRIES):
            data, page = free_port(address, _PORTS[0]), free_port(address, _PORTS[1])
            origin, url = f"http://{host}:{page}", f"rerun+http://{host}:{data}/proxy"
            with Path(folder, "said").open("wb") as said:
                process = subprocess.Popen(
                    [
                        viewer_program(), "--serve-web", "--bind", address, "--port", str(data),
                        "--web-viewer-port", str(page), "--server-memory-limit", "50%",
                        "--cors-allow-origin", origin,
                    ],
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said,
                    env={**os.environ, "RERUN_APP_ONLY": "true", "RUST_LOG": "info"},
                    start_new_session=True,
                )  # fmt: skip
            try:
                if not _serves(process, Path(said.name)):
                    continue  # at other ports: another process was the first to take these
                for number, (file, name) in enumerate(named(files)):
                    # the list of recordings is open if there are several
                    copy = Path(folder, f"{number}.rrd") if len(files) > 1 else None
                    send(file, url, copy, name)
                yield Server(f"{origin}/?url={quote(url, safe='')}", url, process)
                return
            finally:
                process.terminate()
                with suppress(subprocess.TimeoutExpired):
                    process.wait(5.0)
                process.kill()
                process.wait()
    raise OSError(f"the server at {address} did not start")


def _serves(process: subprocess.Popen[bytes], said: Path) -> bool:
    """Return whether a server says that it serves before it ends; what answers may be another.

    Raises
    ------
    OSError : if it neither says so nor ends.
    """
    end = time.monotonic() + _ANSWER
    while process.poll() is None:
        if _SERVES in said.read_bytes():
            return True
        if time.monotonic() > end:
            raise OSError(f"the server did not start within {_ANSWER:g} s")
        time.sleep(0.05)
    return False


def named(files: Sequence[str | os.PathLike[str]]) -> list[tuple[Path, str]]:
    """Return files with their paths from the folder that they share: their titles may be the same."""
    paths = [Path(file) for file in files]
    shared = os.path.commonpath([path.absolute().parent for path in paths]) if paths else ""
    return [(path, path.absolute().relative_to(shared).as_posix()) for path in paths]


def send(file: Path, url: str, copy: Path | None, name: str) -> None:
    """Send a recording, or first copy it with the list, in which it then has a name of its own.

    Reading the file would keep the server busy.

    Raises
    ------
    OSError : if the file is not a recording, or the server does not take it.
    """
    import rerun as rr  # noqa: PLC0415  (not needed for a run that is watched)
    from rerun.chunk import RrdReader  # noqa: PLC0415

    from .canvas import legible  # noqa: PLC0415

    try:
        entry = RrdReader(file).recordings()[0]
    except (RuntimeError, IndexError):
        raise OSError(f"{file} is not a recording of this version of rerun") from None
    if copy is not None:
        with_list(file, copy)
    # of the same name and number, so that the file's own recording is the only one in the list
    sending = rr.RecordingStream(
        entry.application_id, recording_id=entry.recording_id, send_properties=False
    )
    sending.connect_grpc(url)
    sending.log_file_from_path(copy or file)
    if copy is not None:
        sending.send_recording_name(legible(name))
    try:
        sending.flush(timeout_sec=_ANSWER)
    except RuntimeError:
        raise OSError(f"the server did not take {file} within {_ANSWER:g} s") from None
    sending.disconnect()


def with_list(file: Path, copy: Path) -> None:
    """Copy a recording, but let the viewer show the list of recordings, as it does by default."""
    subprocess.run(
        [viewer_program(), "rrd", "filter", "--drop-entity", "/blueprint_panel", file, "-o", copy],
        env={**os.environ, "RERUN_APP_ONLY": "true"}, capture_output=True, check=True,
    )  # fmt: skip


def viewer_program() -> str:
    """Return the program of rerun's viewer and server; the command `rerun` is a wrapper around it."""
    import rerun_cli  # noqa: PLC0415  (not needed to write files)

    program = "rerun.exe" if os.name == "nt" else "rerun"
    return os.environ.get("RERUN_CLI_PATH") or str(Path(rerun_cli.__file__).with_name(program))


def is_loopback(address: str) -> bool:
    """Return whether only this machine can reach an address."""
    if address == "localhost":
        return True
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return False


def listens(url: str) -> bool:
    """Return whether a process listens at the address of a viewer.

    Raises
    ------
    ValueError : if `url` is not the address of a viewer.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    schemes = ("rerun", "rerun+http", "rerun+https")
    if not host or not port or parts.scheme not in schemes or parts.path != "/proxy":
        raise ValueError(
            f"{url} is not the address of a viewer; write it as rerun+http://127.0.0.1:9876/proxy"
        )
    try:
        socket.create_connection((host, port), 1.0).close()
    except (OSError, UnicodeError):  # the latter of a host that cannot be a name
        return False
    return True


def _numeric(address: str) -> str:
    """Return an address in numbers, the only ones that rerun listens at."""
    try:
        return str(socket.getaddrinfo(address, None, _family(address))[0][4][0])
    except UnicodeError:
        raise OSError(f"cannot listen at {address}: no host can have this name") from None
    except OSError as error:
        raise OSError(f"cannot listen at {address}: {error.strerror}") from None


def _family(address: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in address else socket.AF_INET


def free_port(address: str, wanted: int) -> int:
    """Return the wanted port if it is free, else another one."""
    for port in (wanted, 0):
        with socket.socket(_family(address), socket.SOCK_STREAM) as trial:
            try:
                trial.bind((address, port))
                return int(trial.getsockname()[1])
            except OSError as error:
                why = error.strerror
    raise OSError(f"cannot listen at {address}: {why}")
