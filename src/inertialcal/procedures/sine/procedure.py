"""The procedure ``sine``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from ...core.key import AXES
from ..protocol import Command, Correction, Facts, InputSpec, Procedure, Quantity, Reduced, Source, Tested
from .figures import FIGURES
from .plan import INFLUENCES, Drive, Plan

if TYPE_CHECKING:
    from ...core.remarks import Remark
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ..entries import EntryKey
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from .entry import SineEntry
    from .reduction import Readings, Result


QUANTITIES = {  # Amplitudes are in the unit of the file, whichever that is
    "amplitude": Quantity(),
    "quadrature": Quantity(),
    "phase": Quantity(("angle",)),
    "scale_factor": Quantity(("other", "dimensionless")),
    "noise_density": Quantity(("other",)),
}


class Sine(Procedure[Plan, "Readings", "Result"]):
    """Amplitude of a known drive in drift."""

    name = "sine"
    title = "Amplitude of a known drive in drift and noise."
    commands = (
        Command(
            "sine",
            "Amplitude of a known drive in drift and noise, with an uncertainty from neighbouring lines; or an"
            " upper limit.",
            examples=('pulses.csv --period "480 s" --phase "0 deg" -o sine.svg', "pulses.csv --schedule order.csv"),
        ),
    )
    plan_type, said_type, influences = Plan, Drive, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    gives = ("scale_factor",)
    takes_corrections = True
    inputs = InputSpec(("accelerometer", "gyro"), missing=True, bare=True, raw=True)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the channels of a file under a drive, with the schedule of the drive."""
        from .given import described

        return [described(given, self.inputs)]

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give; their units are those of the file."""
        return QUANTITIES

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return nothing: all of it is set."""
        return {}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the channels of all sources under their drive.

        Raises
        ------
        DataError
            ``no_drive`` if the drive of a recording is not given; as ``inputs``.
        """
        from ...core.errors import DataError
        from ..corrections import corrected
        from ..mass_attraction.schedule_csv import read_schedule
        from .inputs import driven_by_schedule, driven_by_sine
        from .reduction import Readings

        found, remarks = [], []
        for source in sources:
            drive = cast("SineEntry", source.entry).drive
            if (drive is None) == (plan.period is None):
                what = f"recordings.{source.name}: {'no drive' if drive is None else 'a period and a schedule'}"
                do = 'Give plan = { period = "PERIOD s" }, or drive = { schedule = "FILE" } of the recording'
                raise DataError(what, source.file, do=do, code="no_drive")
            named = source.recordings()
            recordings = corrected(corrections, named)[0] if corrections else [one for _, one in named]
            for recording in recordings:
                remarks += list(recording.remarks)
                for channel in (recording.channel(axis) for axis in AXES if axis in recording.names):
                    if drive is None:
                        one = driven_by_sine(recording, channel, float(plan.period or 0.0), plan.phase)
                    else:
                        schedule = source.read_file(drive.schedule, read_schedule)
                        one = driven_by_schedule(recording, channel, schedule, drive.schedule)
                    found.append(replace(one, name=source.name, where=source.file))
        return Readings(tuple(found), tuple(remarks))

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return recordings that disagree with the others, jumps, and changes of the response."""
        from .agreement import agreement

        return agreement(plan, readings)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the line of each channel."""
        from .reduction import reduce

        return reduce(plan, readings)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the scale factors of axes whose drive is known in size."""
        from .terms import model_terms

        return model_terms(result, tests)

    def without_model(self, plan: Plan) -> str:
        """Return what a scale factor takes."""
        return "" if plan.period is None else "A model needs what was applied: a schedule that says it in each dwell"

    def truths(self, result: Result) -> Sequence[Row]:
        """Return the rows: there is no joint estimate."""
        return result.rows()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest amplitude."""
        from ...core.show.rows import largest_of

        return largest_of(("amplitude",), rows) or ("No amplitude could be estimated",)

    def summary(self, found: Reduced) -> str:
        """Return drive, readings and fit of each channel."""
        result: Result = found.result
        return "; ".join(one.summary() for one in result.lines)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``drive``."""
        from .entry import KEYS

        return KEYS


PROCEDURE = Sine()
