"""Tests of a simulated campaign, reduced without files: the campaign from its text, the recordings from memory."""

from __future__ import annotations

import tomllib
from functools import lru_cache

from ...rigs.twin import SEED, Twin
from ..calls.call import campaign_of
from ..engine.engine import ReducedTest
from ..engine.whole import reduce_tests
from ..file.load import Campaign
from ..inputs.sources import Memory


def fitted_tests(twin: Twin) -> list[ReducedTest]:
    """Return the tests of a twin with ``use = "fit"``, reduced.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    store = Memory(twin.recordings, {file: extra.content for file, extra in twin.extras.items()})
    return reduce_tests(_fitted_campaign(twin.campaign), store)[1]


@lru_cache(4)
def _fitted_campaign(text: str) -> Campaign:
    """Return the campaign of a rig, which all its seeds share, with the tests of a fit alone."""
    document = tomllib.loads(text.replace(SEED, "0"))
    fitted = [test for test in document["tests"] if test.get("use", "fit") == "fit"]
    names = {test["id"] for test in fitted}
    for test in fitted:
        if test.get("against") not in names:
            test.pop("against", None)
    return campaign_of({**document, "tests": fitted, "requirements": [], "model": {}}, checked=False)
