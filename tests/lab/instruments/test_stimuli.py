"""What moves: nothing beyond its limits, nothing with an open interlock, and the safe state after any fault."""

from __future__ import annotations

import threading
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lab_devices import Table, serving

from inertialcal.core.errors import InertialcalError, InstrumentError
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.device import Device
from inertialcal.lab.instruments.dialect import Dialect, built_in, built_in_text, filled
from inertialcal.lab.instruments.links.link import LinkEntry, LinkLostError
from inertialcal.lab.instruments.links.network import SocketLink
from inertialcal.lab.instruments.links.visa import KIND as VISA
from inertialcal.lab.instruments.served import Served

LIMITS = {"rate": (-100.0, 50.0)}
SAFE = [":mode:rate 1", ":dem:rate 1,0", ":int:open 1"]


def dialect(name: str, **changes: object) -> Dialect:
    found = Dialect.model_validate(tomllib.loads(built_in_text(name).decode()))
    return found.model_copy(update={"pause": 0.0, "timeout": 1.0, **changes})


class Wire:
    """A link to a `Table` without a line: what is written is answered; it can be cut."""

    whole = False
    begins_whole = True

    def __init__(self, table: Table) -> None:
        self.table, self.answers, self.cut = table, list[bytes](), False

    def open(self) -> None:
        pass

    def read(self, wait: float) -> list[bytes]:
        if self.cut:
            raise LinkLostError("pulled")
        found, self.answers = self.answers, []
        return found

    def write(self, data: bytes) -> None:
        if self.cut:
            raise LinkLostError("pulled")
        for line in data.decode().splitlines():
            said = self.table.answer(line)
            if said is not None:
                self.answers.append(said.encode() + b"\n")

    def close(self, again: bool = False) -> None:
        pass


def table_on_wire(**given: object) -> tuple[Device, Table, Wire]:
    table = Table()
    wire = Wire(table)
    one = Device("table", wire, dialect("acutrol", **given), Clock(), limits=LIMITS, parameters={"axis": "1"})
    one.open()
    return one, table, wire


def test_a_rate_within_its_limits_is_set_and_read() -> None:
    one, table, _ = table_on_wire()
    assert one.identify() == "ACUTRONIC,ACT3000,1,1"
    one.configure()
    assert ":lim:rate rate,1,100.000000" in table.told
    one.set("rate", 10.0)
    assert (table.rate, one.read("rate"), one.read("position")) == (10.0, 10.0, 12.5)
    one.safe()
    assert table.told[-3:] == SAFE
    assert table.rate == 0.0


@given(st.floats(allow_nan=True, allow_infinity=True))
def test_nothing_is_sent_beyond_the_limits(value: float) -> None:
    one, table, _ = table_on_wire()
    low, high = LIMITS["rate"]
    if low <= value <= high:
        one.set("rate", value)
        assert table.rate == pytest.approx(value, abs=1e-6)
        return
    with pytest.raises(InstrumentError) as refused:
        one.set("rate", value)
    assert refused.value.problems[0].code == "beyond_limits"
    assert table.told == SAFE
    assert table.fastest == 0.0


def test_what_has_no_limits_is_never_set() -> None:
    one, table, _ = table_on_wire()
    assert one.check("position", 0.0).startswith("no limits are stated")
    with pytest.raises(InstrumentError):
        one.set("position", 0.0)
    assert table.told == SAFE


def test_an_open_interlock_lets_nothing_move() -> None:
    one, table, _ = table_on_wire()
    one.set("rate", 20.0)
    table.interlock = "Fault"
    with pytest.raises(InstrumentError) as refused:
        one.set("rate", 30.0)
    assert refused.value.problems[0].code in ("interlock_open", "instrument_error")
    assert table.rate == 0.0
    assert table.told[-3:] == SAFE


def test_an_error_that_it_says_unasked_is_a_fault_and_no_answer() -> None:
    one, table, wire = table_on_wire()
    one.set("rate", 20.0)
    wire.answers.append(b"ERROR 12\n")
    with pytest.raises(InstrumentError) as refused:
        one.set("rate", 30.0)
    assert refused.value.problems[0].code == "instrument_error"
    assert (table.rate, table.fastest) == (0.0, 20.0)


def test_an_interlock_that_does_not_answer_lets_nothing_move() -> None:
    one, table, _ = table_on_wire(timeout=0.05)
    table.answer = table.told.append  # type: ignore[method-assign, assignment]
    with pytest.raises(InstrumentError) as refused:
        one.set("rate", 30.0)
    assert refused.value.problems[0].code == "no_answer"
    assert table.told[-3:] == SAFE


def test_a_lost_link_is_a_fault() -> None:
    one, table, wire = table_on_wire()
    one.set("rate", 20.0)
    wire.cut = True
    for call in (lambda: one.set("rate", 1.0), lambda: one.read("rate"), one.safe):
        with pytest.raises(InstrumentError) as refused:
            call()
        assert refused.value.problems[0].code == "unreachable"
    assert table.rate == 20.0  # nobody could tell it: the acquisition says so


def test_all_commands_of_the_safe_state_are_tried_whatever_becomes_of_one() -> None:
    one, table, wire = table_on_wire()
    write = wire.write

    def failing(data: bytes) -> None:
        if data.startswith(b":mode"):
            raise LinkLostError("once")
        write(data)

    wire.write = failing  # type: ignore[method-assign]
    with pytest.raises(InstrumentError):
        one.safe()
    assert table.told[-2:] == SAFE[1:]


def test_answers_are_a_stream_over_tcp() -> None:
    table, clock = Table(), Clock(10)
    served = Served([], clock, "tcp", answer=table.answer)
    with serving(served):
        one = Device("table", SocketLink(served.address, False, clock), dialect("acutrol"), clock, limits=LIMITS,
                     parameters={"axis": "1"})  # fmt: skip
        one.open()
        one.configure()
        stop = threading.Event()
        found = []
        for batch in one.stream(stop):
            found.append(batch.rows[0].item())
            if len(found) == 2:
                one.set("rate", -7.5)
            if len(found) == 4:
                stop.set()
        assert found == [(12.5, 0.0), (12.5, 0.0), (12.5, -7.5), (12.5, -7.5)]
        one.close()


SIM = """
spec: "1.0"
devices:
  table:
    eom:
      GPIB INSTR:
        q: "\\n"
        r: "\\n"
    error: ERROR
    dialogues:
      - q: "*IDN?"
        r: "ACUTRONIC,ACT3000"
      - q: ":interlock? 1"
        r: "Closed"
      - q: ":mode:rate 1"
      - q: ":mode:off 1"
      - q: ":int:close 1"
      - q: ":int:open 1"
      - q: ":Interlock:Reset"
      - q: ":lim:rate rate,1,100.000000"
    properties:
      rate:
        default: 0
        getter:
          q: ":read:rate? 1"
          r: "{:.4f}"
        setter:
          q: ":dem:rate 1,{}"
        specs:
          min: -200
          max: 200
          type: float
      position:
        default: 30
        getter:
          q: ":read:pos? 1"
          r: "{:.4f}"
        specs:
          type: float
  chamber:
    eom:
      TCPIP SOCKET:
        q: "\\n"
        r: "\\n"
    error: ERROR
    dialogues:
      - q: "*IDN?"
        r: "WATLOW,F4T"
      - q: ":OUTPUT1:STATE ON"
      - q: ":OUTPUT1:STATE OFF"
    properties:
      set_point:
        default: 21
        getter:
          q: ":SOURCE:CLOOP1:SPOINT?"
          r: "{:.2f}"
        setter:
          q: ":SOURCE:CLOOP1:SPOINT {}"
        specs:
          type: float
      value:
        default: 20.5
        getter:
          q: ":SOURCE:CLOOP1:PVALUE?"
          r: "{:.2f}"
        specs:
          type: float
resources:
  GPIB0::1::INSTR:
    device: table
  TCPIP0::localhost::5025::SOCKET:
    device: chamber
"""


def simulated(
    folder: Path, address: str, name: str, limits: dict[str, tuple[float, float]], **parameters: str
) -> Device:
    """Return a device on pyvisa-sim."""
    pytest.importorskip("pyvisa_sim")
    (folder / "sim.yaml").write_text(SIM)
    link = VISA.make(LinkEntry(address=address, library="sim.yaml@sim"), folder, Clock())
    one = Device("one", link, dialect(name), Clock(), limits=limits, parameters=parameters)
    one.open()
    return one


def test_acutrol_on_pyvisa_sim(tmp_path: Path) -> None:
    one = simulated(tmp_path, "GPIB0::1::INSTR", "acutrol", LIMITS, axis="1")
    assert one.identify() == "ACUTRONIC,ACT3000"
    one.configure()
    one.set("rate", -99.5)
    assert one.read("rate") == -99.5
    with pytest.raises(InstrumentError):
        one.set("rate", -100.5)
    assert one.read("rate") == 0.0  # the safe state
    assert one.read("position") == 30.0
    one.close()


def test_watlow_on_pyvisa_sim(tmp_path: Path) -> None:
    limits = {"temperature": (-40.0, 70.0)}
    one = simulated(tmp_path, "TCPIP0::localhost::5025::SOCKET", "watlow_f4t", limits, safe_temperature="23")
    assert one.identify() == "WATLOW,F4T"
    one.configure()
    one.set("temperature", -30.0)
    assert one._number(":SOURCE:CLOOP1:SPOINT?") == -30.0
    assert one.read("temperature") == 20.5
    with pytest.raises(InstrumentError):
        one.set("temperature", 71.0)
    assert one._number(":SOURCE:CLOOP1:SPOINT?") == 23.0
    one.close()


def test_aerosmith_says_the_words_of_its_drivers() -> None:
    table = Table()
    wire = Wire(table)
    one = Device("table", wire, dialect("aerosmith"), Clock(), limits=LIMITS, parameters={"acceleration": "20"})
    one.open()
    one.configure()
    one.set("rate", 5.0)
    with pytest.raises(InstrumentError):
        one.set("rate", 51.0)
    one.close()
    assert table.told == ["SRV 1", "ACL 20", "JOG 5.000000", "STO", "SRV 0", "STO"]


def test_every_dialect_names_its_source_and_a_safe_state() -> None:
    for name in built_in():
        one = dialect(name)
        assert one.source
        assert one.title
        assert one.commands.safe


WRONG = [
    ('[frame]\nkind = "lines"\n', "frame and fields belong together"),
    ('[[fields]]\nname = "a"\n', "frame and fields belong together"),
    ('[frame]\nkind = "lines"\n[[fields]]\nname = "a"\n[[fields]]\nname = "a"\n', "stands twice"),
    ('[frame]\nkind = "lines"\n[[fields]]\nname = "a"\nrole = "counter"\n', "whole number"),
    ('[frame]\nkind = "lines"\n[[fields]]\nname = "a"\nrole = "time"\n', "needs its unit"),
    ('[frame]\nkind = "lines"\n[[fields]]\nname = "a"\n[[fields]]\ntype = "pad"\n', "only packets have pads"),
    ('[frame]\nkind = "answers"\n[[fields]]\nname = "a"\n', "needs its question"),
    ('answer = "("\n', "not a regular expression"),
    ('[settings.rate]\nunit = "deg/s"\nset = ["R {value}"]\n', "needs a safe state"),
    ('[frame]\nkind = "lines"\n[[fields]]\nname = "a"\n[interlock]\nask = "?"\nclosed = "1"\n', "cannot be asked"),
]


@pytest.mark.parametrize(("text", "what"), WRONG)
def test_a_dialect_that_contradicts_itself_is_refused(text: str, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        Dialect.model_validate(tomllib.loads(text))


def test_a_command_is_filled_with_all_its_digits() -> None:
    assert filled(":dem:rate {axis},{value:.3f}", {"axis": "2", "value": 1.0 / 3.0}) == ":dem:rate 2,0.333"
    assert filled("R {value}", {"value": 0.1}) == "R 0.1"
    with pytest.raises(KeyError):
        filled("{missing}", {})


def test_errors_of_instruments_are_ours() -> None:
    assert issubclass(InstrumentError, InertialcalError)
    assert InstrumentError.exit_status == 3
