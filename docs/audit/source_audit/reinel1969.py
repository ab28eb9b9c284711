"""Mass attraction: Reinel, NASA TM X-53857, 1969."""

from __future__ import annotations

from . import lead_body as lead
from .figures import Document, Effect
from .reinel1969_mass import DOC, MASS, axial, mass_sections
from .reinel1969_program import PAUSE, SAMPLE, program_sections
from .reinel1969_results import result_sections, without_subtraction
from .reinel1969_travel import best_travel, travel_sections
from .table_files import stated


def document() -> Document:
    """Return the audited document."""
    told = stated(DOC)
    return Document(
        DOC,
        "Mass attraction",
        'K. Reinel, "Accelerometer Calibration in the Low g Range by Means of Mass Attraction", NASA TM X-53857, 1969',
        (*mass_sections(told), *travel_sections(told), *result_sections(told), *program_sections(told)),
        _effects(),
    )


def _effects() -> tuple[Effect, ...]:
    told = stated(DOC)
    ratios = [shown.value / found for _, shown, found in axial()]
    bare = without_subtraction()
    start, change = best_travel()
    bound = lead.largest_attraction(MASS, told["surface_zero"].value)
    return (
        Effect(
            "The attraction of the source mass is printed larger than its lead can attract.",
            f"Table 3 starts at 74.017 ng where {MASS:.0f} kg give {bound:.2f} ng at most, and Table 2 lies "
            f"{100.0 * (min(ratios) - 1.0):.1f} to {100.0 * (max(ratios) - 1.0):.1f} % above the body of "
            "cubes. An error of the "
            "input is one of the scale factor: twice the 0.9 % that is stated for the input, and it comes "
            "out too small.",
        ),
        Effect(
            "The noise is subtracted from the amplitude.",
            f"Without that the same runs give {bare / 1e7:.2f}e7 pps/g, {100.0 * (bare / 1.02e7 - 1.0):.0f} "
            "% above the data sheet: the "
            "agreement with 1.02e7 rests on how noise is taken off.",
        ),
        Effect(
            "Frequencies leave out the pauses in which the mass moves.",
            f"{SAMPLE:.0f} s and {PAUSE:.0f} s make {1e3 / (4.0 * (SAMPLE + PAUSE)):.3f} mHz, not 2.5 mHz: "
            "every frequency is "
            f"{100.0 * PAUSE / SAMPLE:.0f} % too high. The line number 25 is not affected.",
        ),
        Effect(
            "Cubes and proof mass are said to be points to 1e-3.",
            f"At twice its side a cube is off by {lead.cube_error(2.0):.4f}, the nearest one on the proof mass by "
            f"{lead.shell_error(told['nearest_cube_centre'].value, 2.915, 1.268):.3f}. Over the whole body "
            "it averages out; near a single small mass it does not.",
        ),
        Effect(
            "The travel is said to give the largest change.",
            (
                f"Starting at {start:.1f} cm instead of 12.7 cm gives {change:.2f} ng, "
                f"{100.0 * (change / 46.009 - 1.0):.1f} % more: harmless."
            ),
        ),
        Effect(
            "The index of the input is printed as I where the listing has I - 1.",
            (
                "With the printed formula the whole answer is in A(25) and B(25) is zero: a program written "
                "from the text finds no signal."
            ),
        ),
    )
