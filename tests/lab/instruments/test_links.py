"""Links: a pty, sockets and a file that grows, with what real ones do; numbers come out as they were sent."""

from __future__ import annotations

import importlib
import os
import socket
import sys
import threading
import tomllib
from pathlib import Path

import numpy as np
import pytest
from lab_devices import PACKETS, SAMPLES, device, line_dialect, packets, serving

from inertialcal.core.errors import InstrumentError
from inertialcal.core.remarks import Remark
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.dialect import Dialect
from inertialcal.lab.instruments.links import LINKS
from inertialcal.lab.instruments.links.growing import FileLink
from inertialcal.lab.instruments.links.link import LinkEntry, LinkLostError
from inertialcal.lab.instruments.links.network import SocketLink, host_and_port
from inertialcal.lab.instruments.links.serial import SerialLink
from inertialcal.lab.instruments.served import Served, with_faults

FAST = {"serial": 20, "tcp": 20, "udp": 4}  # of the clock; nothing holds datagrams back where a reader is slow
RATE = 1000.0


def stream_of(over: str, **given: object) -> tuple[np.ndarray[tuple[int], np.dtype[np.void]], list[Remark], object]:
    """Return the rows that came of a device of 12 channels at 1 kHz, and the remarks."""
    fast = 4 if "unplugged" in given else FAST[over]  # a busy machine takes its time to connect again
    clock, remarks = Clock(fast), list[Remark]()
    sent, _ = packets()
    timed = with_faults([(i / RATE, one) for i, one in enumerate(sent)], given.pop("faults", ()), 1)  # type: ignore[arg-type]
    served = Served(timed, clock, over, **given)  # type: ignore[arg-type]
    link = (
        SerialLink(served.address, 921_600, clock)
        if over == "serial"
        else SocketLink(served.address, over == "udp", clock)
    )
    dialect = Dialect.model_validate(tomllib.loads(PACKETS))
    with serving(served):
        one = device("imu", link, dialect, clock, say=remarks.append)
        one.open()
        served.ready()
        stop, lots = threading.Event(), []

        def end() -> None:
            served.done.wait(20.0)
            clock.wait(0.3 * fast, stop)
            stop.set()

        threading.Thread(target=end, daemon=True).start()
        for batch in one.stream(stop):
            lots.append(batch.rows)
        one.close()
    return np.concatenate(lots), remarks, one


def readings(rows: np.ndarray[tuple[int], np.dtype[np.void]]) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    assert rows.dtype.names is not None
    return np.column_stack([rows[name] for name in rows.dtype.names[1:]])


@pytest.mark.parametrize("over", ["serial", "tcp", "udp"])
def test_all_that_is_sent_comes_in_order(over: str) -> None:
    if over == "serial" and sys.platform == "win32":
        pytest.skip("no ptys")
    rows, remarks, one = stream_of(over)
    np.testing.assert_array_equal(readings(rows), packets()[1][rows["counter"]])
    assert remarks == []
    missing = int(rows["counter"][-1]) + 1 - len(rows)
    assert (one.counts.damaged, one.counts.lost) == (0, missing)  # type: ignore[attr-defined]
    assert len(rows) == SAMPLES or (over == "udp" and len(rows) > 0.5 * SAMPLES)  # a busy machine drops datagrams


@pytest.mark.parametrize("over", ["serial", "udp"])
def test_faults_are_counted_and_no_wrong_number_comes(over: str) -> None:
    rows, _, one = stream_of(over, faults=("late", "torn", "doubled", "lost"))
    counts = one.counts  # type: ignore[attr-defined]
    truth = packets()[1]
    np.testing.assert_array_equal(readings(rows), truth[rows["counter"]])
    assert np.all(np.diff(rows["counter"].astype(int)) > 0)
    assert counts.doubled > 0
    assert counts.damaged > 0
    missing = int(rows["counter"][-1]) + 1 - len(rows)  # what is missing at the end nobody can know
    assert counts.lost == missing, "each row that is missing is counted, once"


@pytest.mark.parametrize("over", ["serial", "tcp"])
def test_what_is_unplugged_is_said_and_connected_again(over: str) -> None:
    rows, remarks, _ = stream_of(over, unplugged=True)
    assert [one.code for one in remarks] == ["unplugged", "connected_again"]
    np.testing.assert_array_equal(readings(rows), packets()[1][rows["counter"]])
    assert rows["counter"][-1] == SAMPLES - 1
    assert 0.4 * SAMPLES < len(rows) < SAMPLES


def test_a_file_that_grows_is_read_as_it_grows(tmp_path: Path) -> None:
    path, clock, remarks = tmp_path / "log.csv", Clock(), list[Remark]()
    path.write_bytes(b"# header\n0,0.0,1,20.0\n1,0.1,2,20")
    one = device("log", FileLink(path, clock), line_dialect(), clock, say=remarks.append)
    one.open()
    stop = threading.Event()
    found = []
    for batch in one.stream(stop):
        found += batch.rows["gyro_x"].tolist()
        if found == [1]:
            with path.open("ab") as more:
                more.write(b".5\n2,0.2,3,20.0\n")
        elif found == [1, 2, 3]:
            path.write_bytes(b"0,0.0,7,20.0\n")  # begun anew
        elif found[-1] == 7:
            stop.set()
    one.close()
    assert found == [1, 2, 3, 7]
    assert "cut off or replaced" in remarks[0].what


def test_what_cannot_be_reached_is_said(tmp_path: Path) -> None:
    clock = Clock()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    for link in (
        SocketLink(f"127.0.0.1:{port}", False, clock),
        SerialLink(str(tmp_path / "none"), 9600, clock),
        FileLink(tmp_path / "none", clock),
    ):
        with pytest.raises(InstrumentError) as refused:
            device("one", link, line_dialect(), clock).open()
        assert refused.value.problems[0].code == "unreachable"
        assert "one: cannot be reached" in refused.value.problems[0].what
        with pytest.raises(LinkLostError):
            link.write(b"x")


@pytest.mark.parametrize("address", ["", "localhost", "localhost:", "localhost:x", "a:70000"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    with pytest.raises(InstrumentError) as refused:
        host_and_port(address)
    assert refused.value.problems[0].code == "wrong_value"


def test_a_missing_package_is_named_with_what_to_type(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ImportError(name)

    said = (("serial", LinkEntry(address="/dev/x")), ("visa", LinkEntry(address="GPIB::1")))
    links = [LINKS[kind].make(entry, Path(), Clock()) for kind, entry in said]
    monkeypatch.setattr(importlib, "import_module", absent)
    for link in links:
        with pytest.raises(InstrumentError) as refused:
            link.open()
        assert refused.value.problems[0].do == "Type: pip install 'inertialcal[lab]'"
        assert refused.value.problems[0].code == "missing_extra"


def test_no_package_of_the_extra_is_loaded_with_the_links() -> None:
    import subprocess

    code = (
        "import sys, inertialcal.lab.acquisition.lab_file as f; [f.LINKS[n] for n in f.LINKS];"
        "print(sorted({'serial', 'pyvisa', 'pyvisa_py'} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=os.environ)
    assert said.stdout == "[]\n"
