"""campaign.toml of a simulated gyro that stands still, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.axes import AXES
from ...core.campaign_text import Noted, toml_text
from ..parts.campaign import campaign_head, channel_entries, standard_tables
from .setup import Bench


def recording_name(number: int) -> str:
    """Return the name of a record in the campaign."""
    return f"still{number}"


def recording_file(number: int) -> str:
    """Return the file of a record, in the campaign folder."""
    return f"recordings/{recording_name(number)}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title, about = "Noise of a simulated three-axis gyro", "a three-axis rate gyro that stands still"
    times = {"interval": f"{bench.interval:g} s", "averaging": f"{bench.averaging:g} s"}
    recordings = {
        recording_name(number): {
            "sensor": "suite",
            "file": recording_file(number),
            "clock": {"column": "unix_s", "stamp": "end", **times},
            "channels": channel_entries({axis: axis for axis in AXES}, "deg/s"),
        }
        for number in range(1, bench.records + 1)
    }
    saved = f"Each average lasts {bench.averaging:g} s; one is saved every {bench.interval:g} s."
    limits = {"angle_random_walk": "0.36 deg/sqrt(h)", "bias_instability": "20 deg/h"}
    requirements = [
        {"id": f"R{i}", "text": f"{quantity.replace('_', ' ')} at most {limit}", "quantity": quantity, "upper": limit}
        for i, (quantity, limit) in enumerate(limits.items(), 1)
    ]
    return toml_text(
        {
            **campaign_head("still_gyro", "simulated rate gyro", title, about),
            "standards": standard_tables({"sensor.scale_factor": bench.scale_factor}),
            "sensors": {"suite": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}},
            "recordings": Noted(recordings, above=saved),
            "tests": [{"id": "noise", "procedure": "static_noise", "recordings": list(recordings)}],
            "requirements": requirements,
        }
    )
