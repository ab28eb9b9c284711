"""Bytes to rows: whole ones only, and what was not taken counted."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lab_devices import PACKETS, line_dialect, packet, packets

from inertialcal.core.errors import DataError
from inertialcal.lab.instruments.decoder import SUMS, Decoder, number_in
from inertialcal.lab.instruments.dialect import Dialect
from inertialcal.lab.instruments.frames import frames

CHECK = b"123456789"  # what catalogues of checksums give the value of


@pytest.mark.parametrize(
    ("kind", "value"),
    [("crc16_ccitt", 0x29B1), ("crc16_modbus", 0x4B37), ("crc32", 0xCBF43926), ("xor8", 0x31), ("sum8", 0xDD)],
)
def test_checksums_are_those_of_the_catalogues(kind: str, value: int) -> None:
    assert SUMS[kind](CHECK) == value


def packet_decoder() -> Decoder:
    import tomllib

    return Decoder(Dialect.model_validate(tomllib.loads(PACKETS)), begins_whole=False)


@given(cuts=st.lists(st.integers(0, 20 * 56), max_size=12), junk=st.binary(max_size=40))
def test_packets_come_out_however_they_are_cut(cuts: list[int], junk: bytes) -> None:
    sent, values = packets(20)
    data = junk + b"".join(sent)
    decoder = packet_decoder()
    edges = [0, *sorted(cuts), len(data)]
    lots = [decoder.feed(data[a:b]) for a, b in pairwise(edges)]
    rows = np.concatenate(lots)
    table = np.column_stack([rows[one.name] for one in decoder.layout.channels[1:]])
    np.testing.assert_array_equal(table, values)
    assert decoder.counts.lost == 0


def test_a_packet_with_a_flipped_bit_is_left_out_and_counted() -> None:
    sent, values = packets(50)
    for at in (1, 7, 20, 55):
        decoder = packet_decoder()
        bad = bytearray(sent[10])
        bad[at] ^= 4
        rows = decoder.feed(b"".join([*sent[:10], bytes(bad), *sent[11:]]))
        assert len(rows) == 49
        np.testing.assert_array_equal(rows["gyro_x"], np.delete(values[:, 0], 10))
        assert decoder.counts.lost == 1


def test_lost_doubled_and_late_packets_are_told_apart_also_over_the_end_of_the_counter() -> None:
    values = np.zeros(12, dtype=np.int64)
    numbers = [65533, 65534, 65535, 0, 0, 2, 1, 5, 6]  # 0 twice; 1 late, in the same lot; 3 and 4 lost
    decoder = packet_decoder()
    rows = decoder.feed(b"".join(packet(i, values) for i in numbers))
    assert rows["counter"].tolist() == [65533, 65534, 65535, 0, 1, 2, 5, 6]
    assert (decoder.counts.doubled, decoder.counts.late, decoder.counts.lost) == (1, 0, 2)
    assert len(decoder.feed(packet(4, values))) == 0
    assert decoder.counts.late == 1


@pytest.mark.parametrize("cut", range(1, 9))
def test_a_row_that_came_twice_is_told_where_a_late_one_comes_between(cut: int) -> None:
    values = np.zeros(12, dtype=np.int64)
    sent = [packet(i, values) for i in [827, 828, 829, 831, 830, 831, 833, 834, 833]]
    decoder = packet_decoder()
    rows = np.concatenate([decoder.feed(b"".join(sent[:cut])), decoder.feed(b"".join(sent[cut:]))])["counter"].tolist()
    assert rows == sorted(set(rows))
    assert decoder.counts.lost == 834 + 1 - 827 - len(rows)
    assert decoder.counts.doubled + decoder.counts.late == len(sent) - len(rows)


@pytest.mark.parametrize("checksum", ["none", "xor8", "crc16_ccitt"])
def test_lines_come_out_as_they_were_sent(checksum: str) -> None:
    dialect = line_dialect(checksum=checksum, prefix="$IMU,")
    layout = dialect.layout
    assert layout is not None
    rows = np.array([(i, 0.1 * i, i - 5, 20.0 + 1 / 3) for i in range(30)], layout.dtype)
    decoder = Decoder(dialect, begins_whole=True)
    found = decoder.feed(b"".join(frames(rows, dialect)) + b"$OTHER,1\n# words\n\n")
    assert found.tolist() == rows.tolist()
    assert decoder.counts.damaged == 0


def test_the_first_line_is_passed_over_where_it_may_have_begun_before() -> None:
    decoder = Decoder(line_dialect(), begins_whole=False)
    rows = decoder.feed(b"123,0.1,5,20.0\n124,0.2,6,20.0\n")  # was it 9123?
    assert rows["counter"].tolist() == [124]
    decoder.reset()
    assert decoder.feed(b",7,20.0\n126,0.4,8,20.0\n")["counter"].tolist() == [126]


@pytest.mark.parametrize(
    "line", [b"1,2,3", b"1,2,3,4,5", b"1,x,3,4", b"1.5,0.1,3,4", b"99999999999,0.1,3,4", b"\xff\xfe,1,2,3", b"1,,3,4"]
)
def test_a_line_that_is_none_is_left_out_and_counted(line: bytes) -> None:
    decoder = Decoder(line_dialect(), begins_whole=True)
    rows = decoder.feed(b"1,0.1,5,20.0\n" + line + b"\n2,0.2,5,20.0\n")
    assert rows["counter"].tolist() == [1, 2]
    assert decoder.counts.damaged == 1


def test_a_torn_datagram_does_not_join_the_next() -> None:
    decoder = Decoder(line_dialect(), begins_whole=True)
    assert len(decoder.feed(b"1,0.1,5,20.0", whole=True)) == 1
    assert len(decoder.feed(b"2,0.2", whole=True)) == 0
    assert decoder.feed(b"3,0.3,5,20.0\n", whole=True)["counter"].tolist() == [3]
    assert (decoder.counts.damaged, decoder.counts.lost) == (1, 1)


def test_an_instrument_that_begins_anew_is_not_taken_for_late() -> None:
    decoder = Decoder(line_dialect(), begins_whole=True)
    decoder.feed(b"500000,50.0,5,20.0\n500001,50.1,5,20.0\n")
    assert decoder.feed(b"0,0.0,5,20.0\n1,0.1,5,20.0\n")["counter"].tolist() == [0, 1]
    assert (decoder.counts.restarted, decoder.counts.late, decoder.counts.lost) == (1, 0, 0)


def timed(*fields: str) -> Decoder:
    dialect = line_dialect()
    return Decoder(dialect.model_copy(update={"fields": dialect.fields[1:]}), begins_whole=True)


def test_without_a_counter_only_the_same_row_came_twice() -> None:
    decoder = timed()
    rows = decoder.feed(b"1.0,5,20.0\n1.1,5,20.0\n1.1,5,20.0\n1.2,6,20.0\n")
    assert rows["t"].tolist() == [1.0, 1.1, 1.2]
    assert decoder.counts.doubled == 1


def test_a_coarse_time_drops_nothing() -> None:
    decoder = timed()  # ten rows a second, stamps in whole seconds, readings that stand still
    sent = [f"{i // 10}.0,5,20.0\n".encode() for i in range(100)]
    assert sum(len(decoder.feed(one)) for one in sent) == 100
    assert decoder.counts.doubled == 0


def test_a_number_is_found_in_an_answer() -> None:
    assert number_in("1,-12.5 deg/s", r"[-+]?\d+\.?\d*") == -12.5
    with pytest.raises(DataError) as refused:
        number_in("Fault", r"\d+")
    assert refused.value.problems[0].code == "no_number"
