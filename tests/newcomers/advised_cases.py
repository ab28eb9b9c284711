# ruff: noqa: E501 - advices stand as the sources have them
"""What is typed, the advice that it gets, what is typed then, and what must come out.

Files are those of `files_for_advice`; commands are typed in their folder. ``+`` begins what is added to the first
command, ``;`` stands between commands. What must come out is checked against what the files were made of:
``bias x 0.35`` (an estimate, within its uncertainty), ``rate 50`` (of `info`), ``start 2024-03-12``, ``unit NAME UNIT``,
``has TEXT``, ``done`` (it works: the answer has no number of its own).
"""

from __future__ import annotations

import re
from typing import NamedTuple


class Case(NamedTuple):
    """An advice, obeyed."""

    advice: str
    typed: str
    obeyed: str
    right: str
    quick: bool = False  # in the default suite


CASES = (
    Case(
        "time: none; add --sample-rate or --time-column",
        "text info no_time.csv",
        "+ --sample-rate 50",
        "rate 50",
        quick=True,
    ),
    Case(
        "--sample-rate HZ",
        "info no_time.csv",
        "+ --sample-rate 50",
        "rate 50",
        quick=True,
    ),
    Case(
        "If it is time: --time-column 1 --unit 1=UNIT",
        "info no_header.csv",
        "+ --time-column 1 --unit 1=ms",
        "rate 50",
        quick=True,
    ),
    Case(
        "If it is time: --time-column {}{}, or clock = { column = ... } in campaign.toml",
        "info restarted.csv",
        "+ --time-column stamp --unit stamp=ms",
        "has time_backwards",
    ),
    Case(
        " --unit {}=UNIT",
        "info restarted.csv",
        "+ --time-column stamp --unit stamp=ms",
        "has time_backwards",
    ),
    Case(
        "If the sensor samples evenly, give its rate: --sample-rate",
        "info bursts.csv",
        "+ --sample-rate 50",
        "rate 50",
    ),
    Case(
        "Check the rate, and the unit of time: --unit COLUMN=UNIT",
        "info milliseconds.csv --sample-rate 50",
        "info milliseconds.csv --unit time_s=ms",
        "rate 50",
        quick=True,
    ),
    Case(
        "Check the sample rate (--sample-rate) and the unit of time",
        "info too_fast.csv",
        "+ --sample-rate 1",
        "rate 1",
    ),
    Case(
        "Say it: --dates {}, or --dates {}",
        "info dated.csv",
        "+ --dates month-first",
        "start 2024-03-12",
    ),
    Case(
        "Write it like 2010-04-28T15:10:00Z. Dates with strokes: --dates day-first, or month-first",
        "info dates_mixed.csv --dates day-first",
        "info dates_mixed.csv --dates month-first",
        "start 2024-03-12",
    ),
    Case(
        "Cut the record there; sort its rows if they are in another order; or give --sample-rate if its clock was set",
        "info clock_set.csv",
        "+ --sample-rate 50",
        "rate 50",
    ),
    Case(
        " the sample rate (--sample-rate HZ) or the time column (--time-column)",
        "allan no_time.csv",
        "+ --sample-rate 50",
        "white x 0.02",
    ),
    Case(
        "Give the sample rate: --sample-rate, or a time column: --time-column",
        'sine wave_no_time.csv --period "4 s"',
        "+ --sample-rate 20",
        "amplitude x 3",
    ),
    Case(
        "Leave --frame out",
        "info rest_units.csv --frame sensor",
        "info rest_units.csv",
        "rate 50",
        quick=True,
    ),
    Case(
        "inertialcal init {}",
        "info staged/turned_stage.csv",
        "init staged",
        "has staged/campaign.toml",
    ),
    Case(
        "inertialcal {} {}",
        "info rest_units.csv",
        "allan rest_units.csv",
        "white x 0.02",
    ),
    Case(
        "If the file is right, add --max-memory {}GiB",
        "info rest_units.csv --max-memory 1MB",
        "+ --max-memory 1GiB",
        "rate 50",
    ),
    Case(
        "Read them by name: --topic NAME",
        "info other_clock.mat",
        "+ --topic slow",
        "has slow",
    ),
    Case(
        "Leave the unit out; a test takes --scale-factor, of the data sheet, and --reference, what it gives without input",
        "thermal chamber_volts.csv --unit gyro=deg/s",
        'thermal chamber_volts.csv --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        "{}: --unit {}={}?",
        "info fast.csv",
        "+ --unit acc=m/s2",
        "unit acc_z m/s^2",
    ),
    Case(
        "inertialcal info {} {}",
        "info bare.csv",
        "info bare.csv --unit gyro=deg/s",
        "unit gyro_x deg/s",
    ),
    Case(
        "Give the units: --unit gyro=UNIT --unit acc=UNIT",
        "convert bare.csv bare.mcap",
        "+ --unit gyro=deg/s ; info bare.mcap",
        "unit angular_velocity.x rad/s",
    ),
    Case(
        "Counts and volts need a model: inertialcal compensate MODEL {} -o OUT.mcap",
        "convert chamber_volts.csv volts.mcap",
        "compensate volts.json chamber_volts.csv -o volts.mcap ; info volts.mcap",
        "unit angular_velocity.x rad/s",
    ),
    Case(
        "Leave the unit out; a test takes --scale-factor, of the data sheet, and --reference, what it gives without input",
        "info chamber_volts.csv --unit gyro=deg/s",
        "info chamber_volts.csv",
        "unit gyro_x V",
    ),
    Case(
        "Add --sample-rate",
        "convert no_time.csv out.mcap",
        "+ --sample-rate 50 ; info out.mcap",
        "rate 50",
    ),
    Case(
        "inertialcal info {}",
        "text convert rest_units.csv kept.csv",
        "info kept.csv",
        "rate 50",
    ),
    Case(
        "Add: --column x=COLUMN",
        "thermal abc.csv --unit a=deg/s --unit b=deg/s --unit c=deg/s",
        "+ --column x=a",
        "bias x 0.3542",
    ),
    Case(
        'Add that of its data sheet: --scale-factor "NUMBER {}/(UNIT)"',
        'thermal chamber_volts.csv --reference "2.5 V"',
        '+ --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        'Add: --reference "NUMBER V"',
        'thermal chamber_volts.csv --scale-factor "0.02 V/(deg/s)"',
        '+ --reference "2.5 V"',
        "bias x 0.3542",
    ),
    Case(
        '--scale-factor "NUMBER V{}"',
        "thermal chamber_volts.csv",
        '+ --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        '--reference "NUMBER V"',
        "thermal chamber_volts.csv",
        '+ --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        '--lsb "NUMBER V"',
        "thermal chamber_counts.csv",
        '+ --lsb "5 V / 4095" --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        '--scale-factor "NUMBER count{}"',
        "rate-table digital.csv --axis x --unit reading=count",
        '+ --scale-factor "16.4 count/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        '--lsb "NUMBER V" --reference "NUMBER V" --scale-factor "NUMBER V/(UNIT)"',
        "info turned_headed.csv",
        'rate-table turned_headed.csv --axis x --lsb "5 V / 4095" --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        '--reference "NUMBER V" --scale-factor "NUMBER V/(UNIT)"',
        "info turned_volts.csv",
        'rate-table turned_volts.csv --axis x --reference "2.5 V" --scale-factor "0.02 V/(deg/s)"',
        "bias x 0.3542",
    ),
    Case(
        'Write it like --counts "0, 4095"',
        'thermal chamber_counts.csv --lsb "5 V / 4095" --reference "2.5 V" --scale-factor "0.02 V/(deg/s)" --counts all',
        'thermal chamber_counts.csv --lsb "5 V / 4095" --reference "2.5 V" --scale-factor "0.02 V/(deg/s)" --counts "0, 4095"',
        "bias x 0.3542",
    ),
    Case(
        "--unit {}={}",
        "thermal chamber_bare.csv",
        "+ --unit gyro=deg/s",
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        "--applied COLUMN",
        "rate-table dwells_named.csv --axis x --reading out --unit deg/s",
        "+ --applied given",
        "bias x 0.3542",
    ),
    Case(
        "--schedule DWELLS.csv",
        "rate-table turned_bared.csv",
        "+ --schedule dwells_at.csv --axis x",
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        ". If one of its columns says it: --applied COLUMN",
        "rate-table turned_stage.csv --axis x",
        "+ --applied stage",
        "bias x 0.3542",
    ),
    Case(
        "--reading COLUMN",
        "rate-table dwells_named.csv --axis x --applied given --unit deg/s",
        "+ --reading out",
        "bias x 0.3542",
    ),
    Case(
        "--unit UNIT",
        "rate-table dwells_named.csv --axis x --applied given --reading out",
        "+ --unit deg/s",
        "bias x 0.3542",
    ),
    Case(
        "--axis AXIS",
        "rate-table dwells_units.csv",
        "+ --axis x",
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        "Add: --axis {}",
        "rate-table turned_units.csv",
        "+ --axis x",
        "bias x 0.3542",
        quick=True,
    ),
    Case(
        "--axis {}",
        "info turned_units.csv",
        "rate-table turned_units.csv --axis x",
        "bias x 0.3542",
    ),
    Case(
        "Add: --reading x=COLUMN",
        "rate-table turned_abc.csv --applied table_rate --axis x --unit a=deg/s",
        "+ --reading x=a",
        "bias x 0.3542",
    ),
    Case(
        "Add: --unit deg/s",
        "rate-table dwells_units.csv --axis x --unit g",
        "rate-table dwells_units.csv --axis x --unit deg/s",
        "bias x 0.3542",
    ),
    Case(
        "Name the ones you want: --column COLUMN",
        "allan rest_more.csv",
        "+ --column gyro_x",
        "white x 0.02",
    ),
    Case(
        "--unit {}=UNIT (UNIT: {}, ...)",
        "allan bare.csv",
        "+ --unit gyro=deg/s",
        "white x 0.02",
    ),
    Case(
        "--quantity increment",
        "allan angles.csv",
        "+ --quantity increment",
        "white x 0.02",
    ),
    Case(
        "--quantity angle",
        "allan angles_summed.csv",
        "+ --quantity angle",
        "white x 0.02",
    ),
    Case(
        "Leave --quantity out, or correct the unit",
        "allan rest_units.csv --quantity angle",
        "allan rest_units.csv",
        "white x 0.02",
    ),
    Case(
        "If they add up to it, or are its integral: --quantity increment or angle",
        "allan bare.csv",
        "allan bare.csv --quantity increment",
        "done",
    ),
    Case(
        "Name one or three channels: --column COLUMN",
        "allan rest_two.csv --for kalibr",
        "+ --column gyro_x",
        "done",
    ),
    Case(
        "Give the unit: --unit gyro=UNIT --unit acc=UNIT",
        "allan bare.csv --for kalibr",
        "+ --unit gyro=deg/s",
        "done",
    ),
    Case(
        'Add its uncertainty: --standard sensor.scale_factor="..."',
        "allan rest_units.csv",
        '+ --standard sensor.scale_factor="0.1 %"',
        "white x 0.02",
    ),
    Case(
        'Give one: --period "PERIOD s", or --schedule FILE',
        "sine wave.csv --column x=pulses",
        '+ --period "4 s"',
        "amplitude x 3",
    ),
    Case(
        'Say how samples are made: --averaging "{} s" for means, --averaging "0 s" for points',
        'sine wave.csv --column x=pulses --period "0.4 s"',
        '+ --averaging "0 s"',
        "done",
    ),
    Case(
        "--to {}",
        "info supplied.csv",
        "sensitivity supplied.csv --to supply",
        "done",
    ),
    Case(
        "Add: --unit {}=V",
        "sensitivity humid.csv --to humidity",
        "+ --unit humidity=V",
        "done",
    ),
    Case(
        "Add: --column {}=COLUMN; or name the file: acc=FILE gyro=FILE",
        "positions faces_named.csv --unit a=m/s2 --unit b=m/s2 --unit c=m/s2",
        "+ --column acc_x=a --column acc_y=b --column acc_z=c",
        "bias x 0.12",
    ),
    Case(
        "Else add: --column {}_x=COLUMN",
        "positions acc=faces_named.csv --unit a=m/s2 --unit b=m/s2 --unit c=m/s2",
        "+ --column acc_x=a --column acc_y=b --column acc_z=c",
        "bias x 0.12",
    ),
    Case(
        "--unit {}={}",
        "positions faces_bare.csv",
        "+ --unit acc=m/s2",
        "bias x 0.12",
    ),
    Case(
        "--unit {}",
        "compensate model.json turned_bare.csv -o o1.csv",
        "+ --unit gyro_x=deg/s --unit gyro_y=deg/s --unit gyro_z=deg/s",
        "zero o1.csv",
    ),
    Case(
        "Add --unit {} (UNIT: {})",
        "compensate thermal.json chamber_no_unit.csv -o o4.csv --temperature probe",
        "+ --unit probe=degC",
        "done",
    ),
    Case(
        "--unit {}",
        "compensate counts.json turned_wrong.csv -o o5.csv",
        "+ --unit gyro_x=count --unit gyro_y=count --unit gyro_z=count",
        "zero o5.csv",
    ),
    Case(
        "Add -o FILE; or --steps, for a published model",
        "compensate model.json turned_units.csv",
        "+ -o o6.csv",
        "zero o6.csv",
    ),
    Case(
        'Hold out (more) tests, use = "hold_out", and run again; or add --unjudged',
        "export model.json --to json -o e.json",
        "+ --unjudged",
        "done",
    ),
    Case(
        "Try: inertialcal check {}",
        "init campaign",
        "check campaign",
        "done",
    ),
    Case(
        "Try: inertialcal demo",
        "run nowhere",
        "demo --help",
        "done",
    ),
    Case(
        "Name a {}, or type: inertialcal run {}",
        "show campaign_new2",
        "run campaign_new2 ; show campaign_new2",
        "done",
    ),
    Case(
        "Try: {} --help",
        "allan --no-such-option x",
        "allan --help",
        "done",
        quick=True,
    ),
    Case(
        "Try: inertialcal --help",
        "no-such-noun",
        "--help",
        "done",
        quick=True,
    ),
    Case(
        "Try: inertialcal score --help",
        "score",
        "score --help",
        "done",
    ),
    Case(
        "Say it: -o figure.png, or --plot to draw it in text",
        "allan rest_units.csv --figure allan",
        "+ -o allan.png",
        "done",
    ),
    Case(
        "Add --pdf",
        "run campaign --appendices",
        "+ --pdf",
        "done",
    ),
)

INSTALLS = re.compile(r"^Type: pip install 'inertialcal\[(\w+)\]'$")  # `test_advice` looks up what the extra holds
