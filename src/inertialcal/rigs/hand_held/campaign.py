"""campaign.toml of an IMU laid by hand, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.campaign_text import toml_text
from ...core.key import AXES
from ..parts.campaign import Content, campaign_head, channel_entries, standard_tables
from .setup import RIG_NAMES, Bench

TITLES = {"hand_held": "Positions of a simulated IMU", "six_faces": "Six faces and three turns of a simulated IMU"}
ABOUT = {
    "hand_held": "an IMU placed by hand in many positions",
    "six_faces": "an IMU placed by hand on its six faces, and turned about its axes",
}
REQUIRED = {
    "hand_held": {
        "text": "gravity carried by the gyros through a turn by hand is within half a degree (rms)",
        "quantity": "transition_error",
        "upper": "0.5 deg",
    },
    "six_faces": {
        "text": "scale factors within 5 % of the nominal ones",
        "quantity": "scale_factor_error",
        "lower": "-5 %",
        "upper": "5 %",
    },
}
SENSORS = {"acc": ("accelerometer", "m/s^2"), "gyro": ("gyro", "rad/s")}  # kind, and unit of the channels
TEMPERATURE = "temperature"  # channel and column


def recording_name(number: int) -> str:
    """Return the name of a record in the campaign."""
    return f"hand{number}"


def recording_file(number: int) -> str:
    """Return the file of a record, in the campaign folder."""
    return f"recordings/{recording_name(number)}.csv"


def protocol_file(number: int) -> str:
    """Return the file of the protocol of a record, in the campaign folder."""
    return f"protocols/{recording_name(number)}.csv"


def campaign_text(bench: Bench, count: int) -> str:
    """Return the text of campaign.toml of so many recordings, with the marks for the seed and for the seal."""
    rig = RIG_NAMES[bench.variant]
    standards = {"gravity.value": bench.gravity_error, "clock.rate": bench.clock}
    if bench.variant == "ferraris":
        standards["turn.angle"] = bench.angle
        standards["fixture.orientation"] = bench.orientation
        standards["fixture.mounting"] = bench.mounting
    plan: Content = {}
    if bench.temperatures:
        standards["thermometer.temperature"] = bench.thermometer
        plan = {"temperature_order": 1, "reference_temperature": f"{bench.reference_temperature:g} degC"}
    units = {"accelerometer": "m/s2", "gyro": "deg/s"}
    numbers = range(1, count + 1)
    uses = {"fit": list(numbers)}
    if bench.apart:
        uses = {"fit": list(numbers[: -bench.apart]), "hold_out": list(numbers[-bench.apart :])}
    tests = [
        {
            "id": "imu" if use == "fit" else "imu_held_out",
            "procedure": "positions",
            "recordings": [f"{sensor}{number}" for number in own for sensor in SENSORS],
            "use": use,
            **({"plan": plan} if plan else {}),
        }
        for use, own in uses.items()
    ]
    return toml_text(
        {
            **campaign_head(bench.rig, "simulated IMU", TITLES[rig], ABOUT[rig]),
            "site": {"gravity": f"{bench.gravity:g} m/s2", "latitude": f"{bench.latitude:g} rad"},
            "standards": standard_tables(standards, {"1": "ppm"}),
            "sensors": {
                sensor: {"kind": kind, "axes": list(AXES), "unit": units[kind]} for sensor, (kind, _) in SENSORS.items()
            },
            "recordings": {
                f"{sensor}{number}": _entry(bench, number, sensor) for number in numbers for sensor in SENSORS
            },
            "tests": tests,
            "requirements": [{"id": "R1", **REQUIRED[rig]}],
        }
    )


def _entry(bench: Bench, number: int, sensor: str) -> Content:
    """Return the entry of the channels of one sensor in a record."""
    interval = f"{bench.pace / bench.sample_rate:g} s"
    channels = channel_entries({axis: f"{sensor}_{axis}" for axis in AXES}, SENSORS[sensor][1])
    if bench.temperatures:
        channels |= channel_entries({TEMPERATURE: TEMPERATURE}, "degC")
    entry: Content = {
        "sensor": sensor,
        "file": recording_file(number),
        "clock": {"column": "unix_s", "stamp": "end", "interval": interval, "averaging": interval},
        "channels": channels,
    }
    return entry | ({"sections": protocol_file(number)} if bench.variant == "ferraris" else {})
