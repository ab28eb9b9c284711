"""A server of PostgreSQL for tests: made by initdb, on a Unix socket in a short folder, ended with the tests.

It does not run as root: under root it runs as the user ``postgres``, or as ``nobody``.
"""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

USER = "archivist"
SECONDS = 30.0


def _owner() -> str | None:
    """Return the user that it runs as; None for the one who tests."""
    if os.getuid():
        return None
    known = {one.pw_name for one in pwd.getpwall()}
    return "postgres" if "postgres" in known else "nobody"


@contextmanager
def served(initdb: str, server: str) -> Iterator[Callable[[], str]]:
    """Yield what makes a new database and returns its address."""
    owner = _owner()
    folder = Path(tempfile.mkdtemp(prefix="ic-pg-", dir="/tmp"))  # a socket has a short path
    if owner:
        shutil.chown(folder, owner)
    data = folder / "data"
    programs = [os.path.realpath(one) for one in (initdb, server)]
    made = [programs[0], "-D", str(data), "-U", USER, "-A", "trust", "-E", "UTF8", "--no-sync", "--locale=C"]
    subprocess.run(made, check=True, capture_output=True, user=owner, group=None, cwd=folder)
    options = [f"-k{folder}", "-clisten_addresses=", "-cfsync=off", "-cmax_connections=30"]
    started = subprocess.Popen(
        [programs[1], "-D", str(data), *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        user=owner,
        cwd=folder,
    )
    count = iter(range(10_000))

    def new() -> str:
        import psycopg

        name = f"archive_{next(count)}"
        with psycopg.connect(host=str(folder), user=USER, dbname="postgres", autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}".encode())
        return f"postgresql://{USER}@/{name}?host={folder}"

    try:
        _wait(folder, started)
        yield new
    finally:
        started.send_signal(signal.SIGINT)  # clients that are left do not hold it up
        started.wait(SECONDS)
        shutil.rmtree(folder, ignore_errors=True)


def _wait(folder: Path, started: subprocess.Popen[bytes]) -> None:
    import psycopg

    end = time.monotonic() + SECONDS
    while True:
        try:
            psycopg.connect(host=str(folder), user=USER, dbname="postgres").close()
        except psycopg.OperationalError:
            if started.poll() is not None or time.monotonic() > end:
                raise
            time.sleep(0.05)
        else:
            return
