"""Texts as Excel and data loggers write them, put together by hand: nothing of the package's writers or readers.

Each form takes a chamber log (`newcomer_truths.chamber`) and returns the bytes of a file. What a form leaves open, a
newcomer says with the options beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from newcomer_truths import Log

START = datetime(2024, 3, 12, 9, 15, tzinfo=UTC)
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Form:
    """A way to write a log, and what a newcomer has to say of it beside the noun."""

    name: str
    write: Callable[[Log], bytes]
    options: tuple[str, ...] = ()
    ending: str = ".csv"


def comma(value: float, digits: int, grouped: bool = False) -> str:
    """Return a number with decimal comma, in thousands with points where wanted."""
    text = f"{value:,.{digits}f}" if grouped else f"{value:.{digits}f}"
    return text.translate(str.maketrans(",.", ".,"))


def rows_of(log: Log, number: Callable[[float, int], str], times: Iterable[str]) -> list[list[str]]:
    """Return the cells of a log: time, rates, temperature."""
    return [
        [time, *(number(float(log.readings[axis][i]), 5) for axis in AXES), number(float(log.temperature[i]), 2)]
        for i, time in enumerate(times)
    ]


def joined(head: Sequence[str], rows: Iterable[Sequence[str]], separator: str, end: str = "\r\n") -> str:
    """Return lines of a file."""
    return "".join(line + end for line in (*head, *(separator.join(cells) for cells in rows)))


def point(value: float, digits: int) -> str:
    """Return a number with decimal point."""
    return f"{value:.{digits}f}"


def seconds(log: Log, number: Callable[[float, int], str] = point) -> list[str]:
    """Return the times of a log."""
    return [number(float(t), 1) for t in log.time]


def stamps(log: Log, form: str, fraction: str = "") -> list[str]:
    """Return instants, with milliseconds after a sign where wanted."""
    found = []
    for t in log.time:
        at = START + timedelta(seconds=float(t))
        found.append(at.strftime(form) + (f"{fraction}{at.microsecond // 1000:03d}" if fraction else ""))
    return found


GERMAN = "Drehrate X [°/s];Drehrate Y [°/s];Drehrate Z [°/s];Temperatur [°C]"
FRENCH = "Vitesse X (deg/s);Vitesse Y (deg/s);Vitesse Z (deg/s);Température (°C)"
ENGLISH = "Gyro X (deg/s),Gyro Y (deg/s),Gyro Z (deg/s),Temperature (°C)"


def excel_german(log: Log) -> bytes:
    rows = rows_of(log, comma, seconds(log, comma))
    return joined(["sep=;", f"Zeit [s];{GERMAN}"], rows, ";").encode("utf-8-sig")


def thousands(log: Log) -> bytes:
    times = [comma(float(t), 1, grouped=True) for t in log.time]
    return joined([f"Zeit [s];{GERMAN}"], rows_of(log, comma, times), ";").encode("cp1252")


def logger_semicolons(log: Log) -> bytes:
    head = ["Messprotokoll;Klimakammer 3", "Bediener;Müller", "Datum;12.03.2024", "Abtastrate;1 Hz", "Kanäle;4", ""]
    rows = rows_of(log, comma, seconds(log, comma))
    return joined([*head, f"Zeit [s];{GERMAN}"], rows, ";").encode("cp1252")


def logger_commas(log: Log) -> bytes:
    head = ["Device,ACME Logger 2000", "Serial,00123,rev,B", "Start,2024-03-12 09:15:00", "Channels,4", ""]
    return joined([*head, f"Time (s),{ENGLISH}"], rows_of(log, point, seconds(log)), ",").encode()


def german_dates(log: Log) -> bytes:
    rows = rows_of(log, comma, stamps(log, "%d.%m.%Y %H:%M:%S"))
    return joined([f"Zeitstempel;{GERMAN}"], rows, ";").encode()


def german_milliseconds(log: Log) -> bytes:
    rows = rows_of(log, comma, stamps(log, "%d.%m.%Y %H:%M:%S", ","))
    return joined([f"Datum/Uhrzeit;{GERMAN}"], rows, ";").encode("cp1252")


def us_dates(log: Log) -> bytes:
    """Dates that only make sense with the month first: the log runs on the 13th."""
    times = []
    for t in log.time:
        at = START + timedelta(days=1, seconds=float(t))
        times.append(f"{at.month}/{at.day}/{at.year} {at:%I:%M:%S %p}")
    return joined([f"Timestamp,{ENGLISH}"], rows_of(log, point, times), ",").encode()


def ambiguous_dates(log: Log) -> bytes:
    """The 12th of March, or the 3rd of December: nobody can tell."""
    return joined([f"Time,{ENGLISH}"], rows_of(log, point, stamps(log, "%m/%d/%Y %H:%M:%S")), ",").encode()


def date_and_time(log: Log) -> bytes:
    rows = [
        [day, clock, *cells[1:]]
        for day, clock, cells in zip(
            stamps(log, "%d.%m.%Y"), stamps(log, "%H:%M:%S"), rows_of(log, comma, seconds(log)), strict=True
        )
    ]
    return joined([f"Datum;Uhrzeit;{GERMAN}"], rows, ";").encode()


def french(log: Log) -> bytes:
    rows = rows_of(log, comma, seconds(log, comma))
    return joined([f"Temps (s);{FRENCH}"], rows, ";").encode("latin-1")


def spread(log: Log) -> bytes:
    """A standard deviation beside each mean, as averaging loggers write it."""
    head = "time_s," + ",".join(f"gyro_{axis}_dps,gyro_{axis}_dps_std" for axis in AXES) + ",temp_degC,temp_degC_std"
    rows = [
        [cells[0], *(one for cell in cells[1:4] for one in (cell, "0.02000")), cells[4], "0.01"]
        for cells in rows_of(log, point, seconds(log))
    ]
    return joined([head], rows, ",", "\n").encode()


def quoted(log: Log) -> bytes:
    rows = ([f'"{cell}"' for cell in cells] for cells in rows_of(log, comma, seconds(log, comma)))
    names = ",".join(f'"{one}"' for one in f"Zeit [s];{GERMAN}".split(";"))
    return joined([names], rows, ",").encode()


def unicode_text(log: Log) -> bytes:
    """Excel's "Unicode text": UTF-16, tabs."""
    rows = rows_of(log, comma, seconds(log, comma))
    return joined([f"Zeit [s]\t{GERMAN}".replace(";", "\t")], rows, "\t").encode("utf-16")


def units_row(log: Log) -> bytes:
    head = ["Zeit;DrehrateX;DrehrateY;DrehrateZ;Temperatur", "s;°/s;°/s;°/s;°C"]
    return joined(head, rows_of(log, comma, seconds(log, comma)), ";").encode()


def trailing(log: Log) -> bytes:
    rows = ([*cells, ""] for cells in rows_of(log, comma, seconds(log, comma)))
    return joined([f"Zeit [s];{GERMAN};"], rows, ";").encode()


def campbell(log: Log) -> bytes:
    """TOA5 of Campbell loggers: a line about the logger, names, units, and what each figure is, all in quotes."""
    head = ['"TOA5","CR1000X","CR1000X","1734","CR1000X.Std.05.02","CPU:gyro.CR1X","51234","Minute"',
            '"TIMESTAMP","RECORD",' + ",".join(f'"gyro_{a}_Avg","gyro_{a}_Std"' for a in AXES) + ',"PTemp_C"',
            '"TS","RN",' + ",".join(['"deg/s"'] * 6) + ',"Deg C"',
            '"","",' + ",".join(['"Avg","Std"'] * 3) + ',"Smp"']  # fmt: skip
    rows = [
        [f'"{stamp}"', str(41 + i), *(one for cell in cells[1:4] for one in (cell, "0.0200")), cells[4]]
        for i, (stamp, cells) in enumerate(
            zip(stamps(log, "%Y-%m-%d %H:%M:%S"), rows_of(log, point, seconds(log)), strict=True)
        )
    ]
    return joined(head, rows, ",").encode()


def hobo(log: Log) -> bytes:
    """HOBO loggers: units behind the names, serial numbers in brackets, empty columns of events."""
    about = "(LGR S/N: 20123456, SEN S/N: 20123456, LBL: gyro)"
    names = ["#", "Date Time, GMT+00:00", *(f"Gyro {a.upper()}, deg/s {about}" for a in AXES), f"Temp, °C {about}",
             "Host Connected (LGR S/N: 20123456)", "End Of File (LGR S/N: 20123456)"]  # fmt: skip
    head = ['"Plot Title: gyro in the chamber"', ",".join(f'"{name}"' for name in names)]
    times = [f"{START + timedelta(days=1, seconds=float(t)):%m/%d/%y %I:%M:%S %p}" for t in log.time]
    rows = [[str(i), *cells, "", ""] for i, cells in enumerate(rows_of(log, point, times), start=1)]
    return joined(head, rows, ",").encode("utf-8-sig")


def french_spaces(log: Log) -> bytes:
    """Thousands apart by the space that does not break."""
    times = [comma(float(t), 1, grouped=True).replace(".", "\u202f") for t in log.time]
    return joined([f"Temps (s);{FRENCH}"], rows_of(log, comma, times), ";").encode()


def german_standard(log: Log) -> bytes:
    """Names and units as DIN 461 writes them at axes."""
    head = "t / s;Drehrate X in °/s;Drehrate Y in °/s;Drehrate Z in °/s;Temperatur / °C"
    return joined([head], rows_of(log, comma, seconds(log, comma)), ";").encode()


def list_of_channels(log: Log) -> bytes:
    """A multimeter's scan: a table of its channels above that of its readings."""
    head = ["Name:,soak", "Instrument:,34972A", "", "Channel,Name,Function,Range,Resolution,Scale,Label",
            *(f"10{i},{a},DC voltage,AUTO,5.5,1,VDC" for i, a in enumerate(AXES, start=1)), "Scan Control:",
            "Start Action:,Immediate", "", f"Scan,Time (s),{ENGLISH}"]  # fmt: skip
    rows = ([str(i), *cells] for i, cells in enumerate(rows_of(log, point, seconds(log)), start=1))
    return joined(head, rows, ",").encode("utf-16")


def torn(log: Log) -> bytes:
    """The logger lost power in the middle of a row."""
    return spread(log)[:-23]


FORMS = (
    Form("excel_german", excel_german),
    Form("thousands", thousands),
    Form("logger_semicolons", logger_semicolons),
    Form("logger_commas", logger_commas),
    Form("german_dates", german_dates),
    Form("german_milliseconds", german_milliseconds),
    Form("us_dates", us_dates),
    Form("ambiguous_dates", ambiguous_dates, ("--dates", "month-first")),
    Form("date_and_time", date_and_time),
    Form("french", french),
    Form("spread", spread),
    Form("quoted", quoted),
    Form("unicode_text", unicode_text, ending=".txt"),
    Form("units_row", units_row),
    Form("trailing", trailing),
    Form("torn", torn),
    Form("campbell", campbell, ending=".dat"),
    Form("hobo", hobo),
    Form("french_spaces", french_spaces),
    Form("german_standard", german_standard),
    Form("list_of_channels", list_of_channels),
)
