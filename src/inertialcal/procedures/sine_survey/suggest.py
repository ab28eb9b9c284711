"""What looks like a survey: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.campaign_text import Noted
from ...core.recording import Recording
from ...files.info.survey import Survey
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion
from ..vibration.suggest import Shaken, entries, shaken

REQUIREMENT = {"quantity": "resonance_frequency_change", "limit": "5 %"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``vibration survey`` of a swept sine."""
    one = shaken(recording)
    if one is None or one.kind != "swept":
        return None
    return Suggestion(("vibration survey",), Strength.STEPPED, options=one.options)


def claims(file: FolderFile) -> Claim | None:
    """Claim a swept sine."""
    one = None if file.recording is None else shaken(file.recording)
    return None if one is None or one.kind != "swept" else Claim(Strength.STEPPED, lambda: (one, ()))


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensor, recordings and tests of surveys, a test each: which came before and after is for people to say."""
    surveys = {file: one for file, one in contents.items() if isinstance(one, Shaken)}
    sensors, recordings, names = entries(surveys, "survey")
    tests: list[object] = []
    for number, (name, _) in enumerate(names):
        one = {"id": f"sweep_{name}", "procedure": "sine_survey", "recordings": [name]}
        above = f'against = "{tests_id(names, number)}" tells what changed since that survey' if number else ""
        tests.append(Noted(one, above=above))
    return Draft(sensors, recordings, tests, REQUIREMENT if len(names) > 1 else {}, example=False)


def tests_id(names: list[tuple[str, Shaken]], number: int) -> str:
    """Return the test of the survey before."""
    return f"sweep_{names[number - 1][0]}"
