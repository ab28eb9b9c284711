"""What converters, loggers and people who copy files do to recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...core.labelled import LabelledPart, labelled_csv
from ...core.recording import SECOND
from ..twin import Extra
from .scene import Place, Scene


def saturation(scene: Scene, size: float) -> None:
    """Hold the axis of the widest range at both ends; the size is the part of its samples that is held."""
    place = scene.chosen()
    turned = [one for one in place.signals if one.axis == place.entry.get("axis")]
    signals = turned or [one for one in place.signals if one.kind == "gyro"] or list(place.signals)
    taken = np.concatenate([np.arange(part.start, part.stop) for part in scene.used(place)])
    ranges = [float(np.ptp(scene.values(place.file, one.column)[taken])) for one in signals]
    signal = signals[int(np.argmax(ranges))]
    values = scene.values(place.file, signal.column)
    middle = float(np.median(values[taken]))
    level = float(np.quantile(np.abs(values[taken] - middle), 1.0 - size / 100.0))
    scene.put(place.file, signal.column, np.clip(values, middle - level, middle + level), signal.ends)


def stuck_codes(scene: Scene, size: float) -> None:
    """Let one axis repeat a code for so many samples."""
    place = scene.chosen()
    signal, n = scene.signal(place), round(size)
    at = scene.somewhere(place, n)
    values = scene.values(place.file, signal.column)
    values[at : at + n] = values[at]
    scene.put(place.file, signal.column, values)


def doubled_samples(scene: Scene, size: float) -> None:
    """Save samples of all axes again in place of the next ones; stamps go on."""
    place = scene.chosen()
    n = len(scene.recordings[place.file])
    at = scene.rng.choice(n - 1, round(size / 100.0 * n), replace=False)
    for signal in place.signals:
        for column in (signal.column, *([signal.zero] if signal.zero else [])):
            values = scene.values(place.file, column)
            values[at + 1] = values[at]
            scene.put(place.file, column, values)


def lost_samples(scene: Scene, size: float) -> None:
    """Lose samples here and there."""
    place = scene.chosen()
    kept = scene.rng.random(len(scene.recordings[place.file])) >= size / 100.0
    scene.take(place.file, kept)
    if "sections" in place.entry:  # of samples, counted in the file as it was saved
        before = np.append(0, np.cumsum(kept))
        file = place.entry["sections"]
        parts: Sequence[LabelledPart] = scene.extras[file].content  # type: ignore[assignment]
        saved = [replace(one, start=float(before[int(one.start)]), stop=float(before[int(one.stop)])) for one in parts]
        scene.extras[file] = Extra(saved, labelled_csv(saved))


def backward_stamps(scene: Scene, size: float) -> None:
    """Set the clock back in the middle, by so many samples."""
    place = scene.chosen()
    stamps = scene.recordings[place.file].time_ns
    assert stamps is not None  # noqa: S101 - recordings of rigs have a clock
    late = stamps.copy()
    late[scene.middle(place) :] -= round(size * float(np.median(np.diff(stamps))))
    scene.stamp(place.file, late)


def wrong_sample_rate(scene: Scene, size: float) -> None:
    """Let the clock of every recording run too fast or too slowly."""
    for place in scene.places:
        scene.note(place)
        stamps = scene.recordings[place.file].time_ns
        assert stamps is not None  # noqa: S101 - recordings of rigs have a clock
        scene.stamp(place.file, stamps[0] + np.rint((stamps - stamps[0]) * size).astype(np.int64))
        scene.texts[place.file] = str  # read from its file: what a reader sees in the stamps counts


def scaled(scene: Scene, size: float) -> None:
    """Store all readings too large by a factor, under the unit that they had."""
    for place in scene.places:
        scene.note(place)
        for signal in place.signals:
            scene.scale(signal, size)


def copies(scene: Scene, size: float) -> None:
    """Put copies of the first recording of a kind in place of the others that are fitted."""
    firsts: dict[tuple[object, ...], Place] = {}
    for place in scene.fitted():
        first = firsts.setdefault((place.test, *place.like), place)
        if first is not place:
            scene.recordings[place.file] = scene.recordings[first.file]
            scene.note(place)


def hold_out_copy(scene: Scene, size: float) -> None:
    """Put copies of fitted recordings in place of those that are held out."""
    fitted = scene.fitted()
    for place in scene.places:
        like = [one for one in fitted if one.like == place.like]
        if place.use == "hold_out" and like:
            scene.recordings[place.file] = scene.recordings[like[0].file]
            if "sections" in place.entry:
                scene.extras[place.entry["sections"]] = scene.extras[like[0].entry["sections"]]
            scene.note(place)


def swapped_files(scene: Scene, size: float) -> None:
    """Exchange the files of the turns about the first two axes of one power-up."""
    first, second, *_ = scene.chosen_run()
    scene.spoiled.clear()
    scene.note(first)
    scene.note(second)
    recordings = scene.recordings
    recordings[first.file], recordings[second.file] = recordings[second.file], recordings[first.file]


def appended(scene: Scene, size: float) -> None:
    """Append a recording to itself, so that it stands there so many times; its clock goes on."""
    place = scene.chosen()
    stamps = scene.recordings[place.file].time_ns
    assert stamps is not None  # noqa: S101 - recordings of rigs have a clock
    n, times = len(stamps), round(size)
    lap = stamps[-1] - stamps[0] + round(float(np.median(np.diff(stamps))))
    later = (stamps + lap * np.arange(times)[:, None]).ravel()
    scene.take(place.file, np.tile(np.arange(n), times), later)


def grouped_digits(scene: Scene, size: float) -> None:
    """Write numbers from 1,000 on as a spreadsheet does: "1,242", in a file with semicolons."""
    place = scene.chosen()
    columns = {one.column for one in place.signals}
    scene.texts[place.file] = _grouping(columns)


def _grouping(columns: set[str]) -> Callable[[str], str]:
    def grouped(text: str) -> str:
        head, *rows = text.splitlines()
        names = head.split(",")
        cells = [[f'"{float(cell):,.0f}"' if name in columns else cell
                  for name, cell in zip(names, row.split(","), strict=True)] for row in rows]  # fmt: skip
        return "\n".join([";".join(names), *map(";".join, cells), ""])

    return grouped


def separate_stamps(scene: Scene, size: float) -> None:
    """Save the gyros in a file of their own, as a phone does: one clock, stamps later by a part of the interval.

    What else is read with them, such as a temperature, stands in both files.
    """
    for place in scene.places:
        names = [name for name in place.names if scene.document["recordings"][name]["sensor"] == "gyro"]
        for name in names:
            file = place.file.replace(".csv", "_gyro.csv")
            whole = scene.recordings[place.file]
            stamps = whole.time_ns
            assert stamps is not None  # noqa: S101 - recordings of rigs have a clock
            interval = float(np.median(np.diff(stamps))) / SECOND
            late = size / 100.0 * interval + 0.02 * interval * scene.rng.standard_normal(len(stamps))
            columns = {one.column for one in place.signals if one.kind == "gyro"}
            named = scene.document["recordings"][name].get("channels", {}).values()
            scene.recordings[file] = whole
            _keep(scene, file, columns | {one["column"] for one in named}, True)
            _keep(scene, place.file, columns, False)
            scene.stamp(file, stamps + np.rint(late * 1e6).astype(np.int64) * 1_000)
            old = rf'(\[recordings\.{name}\]\n(?:.*\n)*?file = ")[^"]*"'
            scene.edit(old, rf'\g<1>{file}"')
            scene.note(place)


def _keep(scene: Scene, file: str, columns: set[str], inside: bool) -> None:
    recording = scene.recordings[file]
    kept = tuple(one for one in recording.channels if (one.name in columns) == inside)
    scene.recordings[file] = replace(recording, channels=kept)
