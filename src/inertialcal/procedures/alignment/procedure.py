"""The procedure ``alignment``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import OF_MOUNTING, Command, Correction, Facts, InputSpec, Procedure, Quantity, Reduced, Source, Tested
from .figures import FIGURES
from .plan import INFLUENCES, Plan

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.judging import Asked, Verdict
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ..entries import SaidTest
    from ..given import Described, GivenFile
    from .readings import Readings
    from .reduction import Result

ANGLE = Quantity(("angle",), unit="rad", shown="deg", redrawn_by=OF_MOUNTING)
RATE = Quantity(("angular_rate",), unit="rad/s", shown="deg/h")
QUANTITIES = {
    "roll": ANGLE,
    "pitch": ANGLE,
    "heading": ANGLE,
    "gyro_bias": RATE,
    "gyro_bias_vertical": RATE,
    "level_earth_rate": Quantity(("angular_rate",), unit="rad/s", shown="deg/h", size=True, redrawn_by=None),
    "latitude_seen": Quantity(("angle",), unit="rad", shown="deg", redrawn_by=None),
    "gravity_excess": Quantity(("acceleration",), unit="m/s^2", shown="mg", redrawn_by=None),
}


class Alignment(Procedure[Plan, "Readings", "Result"]):
    """Roll, pitch and heading of a unit at rest."""

    name, kind_of_test = "alignment", "static alignment"
    title = "Roll, pitch and heading of a unit at rest, from gravity and the rate of the earth."
    commands = (
        Command(
            "alignment",
            title,
            examples=(
                'align/recordings/imu.csv --latitude "36.6 deg" --turns "180 deg"',
                'align/recordings/imu.csv --latitude "36.6 deg" -o rates.png',
            ),
        ),
    )
    plan_type, influences = Plan, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    takes_corrections = changes = True
    inputs = InputSpec(("accelerometer", "gyro"), missing=True, several_sensors=True, windows="records")

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return both triads of a file."""
        from .given import described

        return described(given, self.inputs)

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the site, and the standards."""
        return {**super().plan_fields(facts), "height": facts.height or 0.0}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return what both triads read in each position.

        Raises
        ------
        DataError
            As ``readings.readings_from``.
        """
        from .readings import readings_from

        return readings_from(plan, sources, corrections)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the attitude."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give."""
        return QUANTITIES

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether the test is subject to an influence that is not stated."""
        return influence in self.influences and (
            influence != "turn.angle" or (len(result.readings) > 1 and not result.measured))  # fmt: skip

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on the figures of each position."""
        from .judging import judge

        return (judge(asked, tests), []) if asked.quantity in QUANTITIES else None

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the heading of the first position."""
        from ...core.show.rows import largest_of

        return largest_of(("heading",), rows) or ("No heading could be told: the gyro is too coarse",)

    def summary(self, found: Reduced) -> str:
        """Return how many positions there are, and how the unit points."""
        result = found.result
        many = len(result.readings)
        turns = "" if many == 1 else ", turned as " + ("the gyros measured" if result.measured else "stated")
        points = "up (x forward, y left)" if result.given.up else "down (x forward, y right)"
        return f"found: {many} position{'s' if many > 1 else ''}{turns}; z of the unit points {points}"

    def content(self, found: Reduced) -> Mapping[str, object]:
        """Return matrix, quaternion and covariance of each attitude."""
        return {
            "attitudes": [
                {
                    "position": at,
                    "C_level_body": one.matrix.tolist(),
                    "quaternion": one.quaternion.tolist(),
                    "covariance": one.covariance.tolist(),
                }
                for at, one in enumerate(found.result.attitudes, 1)
            ]
        }

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield a site without a latitude."""
        from ...core.errors import Problem

        if test.latitude is None:
            where = test.at("tests", test.number)
            what = f"test {test.id!r}: an alignment needs the latitude of the site"
            do = "Write it like 36.6 deg, north positive: --latitude; in a campaign, latitude under [site]"
            yield Problem(what, where, "the rate of the earth depends on it", do, "missing_key")


PROCEDURE = Alignment()
