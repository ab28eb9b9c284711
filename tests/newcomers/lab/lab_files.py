"""Files of a test laboratory, written line by line as its instruments and programs write them.

Nothing of the package: a gyro in a chamber behind a voltmeter, and a board at rest or laid on its faces.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from datetime import datetime, timedelta

import numpy as np
from newcomer_boards import Board, G
from newcomer_truths import Log
from numpy.typing import NDArray

START = datetime(2026, 11, 30, 9, 15)
DEG = 180.0 / np.pi
AXES = "xyz"


def lines(rows: Iterable[str], end: str = "\r\n") -> str:
    """Return rows of a file."""
    return "".join(row + end for row in rows)


def instants(times: NDArray[np.float64]) -> list[datetime]:
    """Return the instants of samples."""
    return [START + timedelta(seconds=float(t)) for t in times]


def keysight(log: Log, unit: str, scale: float = 1.0, temperature: str = "C") -> str:
    """BenchLink of a 34972A: a list of its channels, then a scan a row, an alarm beside each reading."""
    names = [f"gyro_{axis}" for axis in AXES]
    head = ["Name:,soak", "Acquisition Date:,11/30/2026 9:15:00 AM", "", "Instrument:,34972A", "",
            "Channel,Name,Function,Range,Resolution,Scale,Label",
            *(f"10{i},{name},DC voltage,AUTO,5.5,1,{unit}" for i, name in enumerate(names, 1)), "Scan Control:",
            "Start Action:,Immediate", ""]  # fmt: skip
    cells = ["Scan", "Time"]
    for i, name in enumerate(names, 1):
        cells += [f"10{i} <{name}> ({unit})", f"Alarm 10{i}"]
    rows = [",".join([*cells, f"109 <temperature> ({temperature})", "Alarm 109"])]
    volts = log.volts()
    for k, at in enumerate(instants(log.time)):
        cells = [str(k + 1), f"{at:%m/%d/%Y %H:%M:%S}:{at.microsecond // 1000:03d}"]
        for axis in AXES:
            cells += [f"{scale * volts[axis][k]:.7E}", "0"]
        rows.append(",".join([*cells, f"{log.temperature[k]:.2f}", "0"]))
    return lines([*head, *rows])


def volts_beside(log: Log) -> str:
    """A unit behind each value."""
    volts = log.volts()
    rows = (f"{t:.1f}," + ",".join(f"{volts[axis][i]:.6f} VDC" for axis in AXES) + f",{log.temperature[i]:.2f}"
            for i, t in enumerate(log.time))  # fmt: skip
    return lines(["time [s],x,y,z,temp [degC]", *rows], "\n")


def keithley(log: Log) -> str:
    """A multimeter of the 2000 series, read out of its buffer: no header."""
    volts = log.volts()["x"]
    return lines(f"{volts[i]:+.8E}VDC,{t:+.6f}SECS,{i + 1:+05d}RDNG#" for i, t in enumerate(log.time))


def kickstart(log: Log) -> str:
    """KickStart of Keithley: a count of readings, which is no reading."""
    volts = log.volts()
    head = ["Keithley KickStart export", "Instrument:,DAQ6510", "",
            "Reading Number,Relative Time (s),Channel 101 gyro_x (V),Channel 102 gyro_y (V),Channel 103 gyro_z (V),"
            "Channel 110 temperature (°C)"]  # fmt: skip
    rows = (",".join([str(i + 1), f"{t:.6f}", *(f"{volts[axis][i]:.6f}" for axis in AXES), f"{log.temperature[i]:.3f}"])
            for i, t in enumerate(log.time))  # fmt: skip
    return lines([*head, *rows])


def hobo(log: Log, zone: str, start: datetime, event: bool = False) -> bytes:
    """HOBOware: an offset from GMT in the header, serial numbers, columns and rows of events."""
    about = "(LGR S/N: 20123456, SEN S/N: 20123456, LBL: gyro)"
    names = ["#", f"Date Time, {zone}", *(f"Gyro {axis.upper()}, deg/s {about}" for axis in AXES),
             f"Temp, °C {about}", *(f"{what} (LGR S/N: 20123456)" for what in
             ("Coupler Detached", "Coupler Attached", "Stopped", "End Of File"))]  # fmt: skip
    rows = []
    for i, t in enumerate(log.time):
        at = f"{start + timedelta(seconds=float(t)):%m/%d/%y %I:%M:%S %p}"
        if i == 0 and event:
            rows.append([at, "", "", "", "", "Logged", "", "", ""])
        readings = [*(f"{log.readings[axis][i]:.5f}" for axis in AXES), f"{log.temperature[i]:.2f}"]
        ended = ["Logged", "Logged"] if i == len(log.time) - 1 else ["", ""]
        rows.append([at, *readings, "", "", *ended])
    body = (",".join([str(k), *row]) for k, row in enumerate(rows, 1))
    return lines(['"Plot Title: soak"', ",".join(f'"{name}"' for name in names), *body]).encode("utf-8-sig")


def xsens(board: Board, separator: str = "\t", first: int = 123456, utc: bool = False, more: bool = False) -> str:
    """MT Manager: ticks of 0.1 ms as 32 bits, packets as 16 bits, parts of UTC, and a rotation beside."""
    head = ["// General information:", f"//  MT Manager version:{separator}2022.0.0", "// Device information:",
            f"//  DeviceId:{separator}0080001234", f"// Update Rate: {board.sample_rate:.1f}Hz",
            "// Filter Profile: general (46.1)"]  # fmt: skip
    names = ["PacketCounter", "SampleTimeFine"]
    parts = ["Nano", "Year", "Month", "Day", "Hour", "Minute", "Second", "Valid"]
    names += [f"UTC_{one}" for one in parts] if utc else []
    names += [f"Acc_{axis}" for axis in "XYZ"] + ([f"FreeAcc_{axis}" for axis in "XYZ"] if more else [])
    names += [f"Gyr_{axis}" for axis in "XYZ"] + ([f"Mat[{i}][{j}]" for j in "123" for i in "123"] if more else [])
    rows = []
    for i, (t, at) in enumerate(zip(board.time, instants(board.time), strict=True)):
        cells = [str((65000 + i) % 2**16), str((first + round(t * 1e4)) % 2**32)]
        if utc:
            date = (at.microsecond * 1000, at.year, at.month, at.day, at.hour, at.minute, at.second, 7)
            cells += [str(one) for one in date]
        cells += [f"{one:.6f}" for one in board.acc[i]]
        cells += [f"{one:.6f}" for one in board.acc[i] - [0.0, 0.0, G]] if more else []
        cells += [f"{one:.6f}" for one in board.gyro[i]]
        rows.append(separator.join([*cells, *("100010001" if more else "")]))
    return lines([*head, separator.join(names), *rows])


def dot(board: Board) -> str:
    """The app of Xsens DOT: microseconds, deg/s."""
    head = ["DeviceTag:,Xsens DOT", "FirmwareVersion:,2.0.0", "OutputRate:,60Hz", "",
            "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z"]  # fmt: skip
    rows = (",".join([str(i), str(2_000_000_000 + round(t * 1e6)), *(f"{one:.6f}" for one in board.acc[i]),
                      *(f"{one:.6f}" for one in DEG * board.gyro[i])]) for i, t in enumerate(board.time))  # fmt: skip
    return lines([*head, *rows])


def serial_monitor(board: Board) -> str:
    """The serial monitor of the Arduino IDE, with its stamps, the header that the sketch prints among them."""
    first, *_ = instants(board.time)
    rows = [f"{first:%H:%M:%S}.000 -> ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps"]
    for i, at in enumerate(instants(board.time)):
        values = [*(board.acc[i] / G), *(DEG * board.gyro[i])]
        rows.append(f"{at:%H:%M:%S}.{at.microsecond // 1000:03d} -> " + ",".join(f"{one:.6f}" for one in values))
    return lines(rows, "\n")


def control_desk(board: Board) -> str:
    """DSPACE ControlDesk: a word before names, units and values."""
    names = ["x_axis", *(f"Model Root/gyro_{axis}" for axis in AXES)]
    head = ["Experiment;bench", "Date;11/30/2026", "", ";".join(["descr", *names]), "unit;s;deg/s;deg/s;deg/s",
            ";".join(["trace_names", *names])]  # fmt: skip
    rows = (";".join(["" if i else "trace_values", f"{t:.4f}", *(f"{one:.6f}" for one in DEG * board.gyro[i])])
            for i, t in enumerate(board.time))  # fmt: skip
    return lines([*head, *rows])


def evaluation_gui(board: Board) -> str:
    """The evaluation program of Analog Devices: registers as names, no unit."""
    head = "Timestamp,XGYRO_OUT,YGYRO_OUT,ZGYRO_OUT,XACCL_OUT,YACCL_OUT,ZACCL_OUT,DATA_CNTR"
    rows = (",".join([f"{t:.6f}", *(f"{one:.6f}" for one in DEG * board.gyro[i]),
                      *(f"{one:.4f}" for one in 1e3 / G * board.acc[i]), str(i % 2**16)])
            for i, t in enumerate(board.time))  # fmt: skip
    return lines([head, *rows], "\n")


def unicleo(board: Board) -> str:
    """Unicleo-GUI of ST."""
    head = ["Log of NUCLEO-F401RE + X-NUCLEO-IKS01A3", "Date: 30/11/2026", "",
            "Timestamp [ms],Acc X [mg],Acc Y [mg],Acc Z [mg],Gyro X [mdps],Gyro Y [mdps],Gyro Z [mdps],"
            "Mag X [mGa]"]  # fmt: skip
    rows = (",".join([str(round(t * 1e3)), *(f"{one:.3f}" for one in 1e3 / G * board.acc[i]),
                      *(f"{one:.2f}" for one in 1e3 * DEG * board.gyro[i]), str(210 + i % 3)])
            for i, t in enumerate(board.time))  # fmt: skip
    return lines([*head, *rows])


def numbers(columns: Sequence[NDArray[np.float64]]) -> str:
    """Columns without any header."""
    return lines((",".join(f"{one:.8g}" for one in row) for row in np.column_stack(columns)), "\n")


def _message(kind: str, content: bytes) -> bytes:
    return struct.pack("<HB", len(content), ord(kind)) + content


def vehicle_imu(board: Board, instances: int = 1) -> bytes:
    """Topic `vehicle_imu` of PX4: increments and how long each was gathered, which differs; and its status, slowly."""
    form = (
        "vehicle_imu:uint64_t timestamp;uint64_t timestamp_sample;uint32_t accel_device_id;uint32_t gyro_device_id;"
        "float[3] delta_angle;float[3] delta_velocity;uint32_t delta_angle_dt;uint32_t delta_velocity_dt;"
        "uint8_t delta_angle_clipping;uint8_t delta_velocity_clipping;"
    )
    status = (
        "vehicle_imu_status:uint64_t timestamp;uint32_t accel_device_id;uint32_t[3] accel_clipping;"
        "float accel_rate_hz;float[3] mean_accel;float[3] mean_gyro;float temperature_accel;"
    )
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 500), _message("B", bytes(40))]
    parts += [_message("F", form.encode()), _message("F", status.encode())]
    for k in range(instances):
        parts.append(_message("A", struct.pack("<BH", k, 2 * k) + b"vehicle_imu"))
        parts.append(_message("A", struct.pack("<BH", k, 2 * k + 1) + b"vehicle_imu_status"))
    spans = 10_000 + np.random.default_rng(1).integers(-900, 900, len(board.time))  # us
    for i, (t, span) in enumerate(zip(board.time, spans.tolist(), strict=True)):
        stamp = 30_000_000 + round(t * 1e6)
        for k in range(instances):
            both = (*(board.gyro[i] * span * 1e-6), *(board.acc[i] * span * 1e-6))
            row = struct.pack("<HQQII6fII2B", 2 * k, stamp + 300, stamp, 1 + k, 2 + k, *both, span, span, 0, 0)
            parts.append(_message("D", row))
            if i % 100 == 0:
                values = (100.0, *board.acc[i], *board.gyro[i], board.temperature[i])
                parts.append(_message("D", struct.pack("<HQI3I8f", 2 * k + 1, stamp, 1 + k, 0, 0, 0, *values)))
    return b"".join(parts)
