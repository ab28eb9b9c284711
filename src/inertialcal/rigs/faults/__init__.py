"""General faults: what goes wrong in a laboratory, on every rig for which it makes sense.

A fault changes what a sound rig recorded, or what the campaign says. `FAULTS` is the table: what it does, its default
size, the procedures whose recordings it spoils, and what is expected: that the recording is refused or named by a code,
or that the intervals hold the truth all the same. A rig takes those for the procedures of its campaign
(``Rig.every_fault``); its own mistakes, which are settings of its bench, stand before them.
"""

from __future__ import annotations

from ..twin import Fault
from . import bench, logger, samples, sense

STILL, TABLE, HOT, HAND, TURN, MASS = "static_noise", "rate_table", "thermal", "positions", "flip", "mass_attraction"
SAMPLED = (STILL, TABLE, HOT, HAND, TURN)
ALL = (*SAMPLED, MASS)
FACES = "faces"  # where a protocol names the faces


FAULTS: dict[str, Fault] = {
    # ---- samples
    "glitch": Fault(
        "one sample is far off", "glitch", also=("rail",), size=3000.0, unit="sigma", least=5.0,
        tests=SAMPLED, spoil=samples.glitch,
    ),
    "spikes": Fault(
        "single samples of each axis, 1e-4 of all, are off", "glitch", size=50.0, unit="sigma", least=5.0,
        tests=SAMPLED, spoil=samples.spikes,
    ),
    "bursts": Fault(
        "some bursts of three samples are off in each axis", "glitch", also=("disturbed",), size=50.0, unit="sigma",
        least=5.0, tests=SAMPLED, spoil=samples.bursts,
    ),
    "level_step": Fault(
        "the level of one axis steps once", "level_step", also=("not_at_rest",), size=5.0, unit="sigma", least=0.0,
        tests=(STILL,), spoil=samples.level_step,
    ),
    "thermostat": Fault(
        "a thermostat of 10 min moves all axes by this amplitude", "slow_wave", also=("lines",), size=0.3,
        unit="sigma", least=0.0, tests=(STILL,), spoil=samples.thermostat,
    ),
    "noise_change": Fault(
        "one axis is this much noisier from the middle on", "noise_change", also=("not_stationary",), size=2.0,
        unit="times", least=1.0, tests=(STILL,), spoil=samples.noise_change,
    ),
    "low_pass": Fault(
        "the noise has passed a filter of first order", expects="covered", size=0.05, unit="Hz", least=1e-6,
        tests=(STILL,), spoil=samples.low_pass,
    ),
    "sharp_filter": Fault(
        "the noise has passed a sharp filter, stored in 32 bits", expects="covered", size=0.05, unit="Hz",
        least=1e-6, tests=(STILL,), spoil=samples.sharp_filter,
    ),
    # ---- converter and logger
    "saturation": Fault(
        "one axis is held at both ends of its range for this part of its samples", "saturated", also=("rail",),
        size=5.0, unit="%", least=0.0, most=90.0, tests=(STILL, TABLE, HAND), spoil=logger.saturation,
    ),
    "stuck_codes": Fault(
        "one axis repeats a code", "stuck", size=20.0, unit="samples", least=2.0, most=1e6, tests=SAMPLED,
        spoil=logger.stuck_codes,
    ),
    "doubled_samples": Fault(
        "this part of the samples is saved twice, over the next", "repeated_samples", size=2.0, unit="%",
        least=0.0, most=50.0, tests=(STILL,), spoil=logger.doubled_samples,
    ),
    "lost_samples": Fault(
        "this part of the samples is lost", expects="covered", size=5.0, unit="%", least=0.0, most=50.0,
        tests=SAMPLED, spoil=logger.lost_samples,
    ),
    "backward_stamps": Fault(
        "the clock is set back in the middle", "time_backwards", size=50.0,
        unit="samples", least=1.0, most=1e6, tests=SAMPLED, spoil=logger.backward_stamps,
    ),
    "wrong_sample_rate": Fault(
        "stamps are this many times too far apart", "sample_rate_disagrees",
        also=("sample_rate_suspect", "clock_disagrees"), size=2.0, unit="times", least=0.01, most=100.0,
        tests=(STILL, TABLE, HAND), spoil=logger.wrong_sample_rate,
    ),
    "scaled": Fault(
        "all readings are this many times too large", "beyond_range",
        also=("impossible_acceleration", "impossible_rate", "unit_slip", "magnitude"), size=1e3, unit="times",
        least=1e-9, most=1e9, tests=(HAND,), spoil=logger.scaled,
    ),
    "grouped_digits": Fault(
        'numbers from 1,000 on are written as "1,242"', "grouped_digits", expects="refused", tests=(MASS,),
        spoil=logger.grouped_digits,
    ),
    "separate_stamps": Fault(
        "accelerometers and gyros are saved apart, their stamps off by this part of the interval", expects="covered",
        size=40.0, unit="%", least=0.0, most=100.0, tests=(HAND,), spoil=logger.separate_stamps,
    ),
    # ---- files
    "copies": Fault(
        "every recording that is fitted is a copy of the first", "duplicate_recording", expects="refused",
        tests=(TABLE, HOT, MASS), spoil=logger.copies,
    ),
    "hold_out_copy": Fault(
        "the recordings held out are copies of fitted ones", "duplicate_recording", expects="refused",
        tests=(TABLE, HOT, HAND), spoil=logger.hold_out_copy,
    ),
    "appended": Fault(
        "a recording is appended to itself", "repeated", size=4.0, unit="times", least=2.0, most=20.0,
        tests=(STILL, TABLE), spoil=logger.appended,
    ),
    "swapped_files": Fault(
        "the files of the turns about x and y have each other's names", "axes_disagree",
        also=("axes_mixed",), tests=(TABLE,), spoil=logger.swapped_files,
    ),
    # ---- units, signs, gains, axes
    "unit_change": Fault(
        "readings are stored in rad/s, or in g, from the middle on", "unit_changed",
        also=("scale_changed", "unit_disagrees"), tests=SAMPLED, spoil=sense.unit_change,
    ),
    "sign_change": Fault(
        "the sign of all readings turns in the middle", "sign_changed", also=("sign_disagrees",),
        tests=(TABLE, HOT, HAND, TURN),
        spoil=sense.sign_change,
    ),
    "axes_change": Fault(
        "x and y are exchanged from the middle on", "axes_changed", also=("axes_disagree",), tests=(TABLE, HAND, TURN),
        spoil=sense.axes_change,
    ),
    "sensor_change": Fault(
        "another unit is read from the middle on: axes in another order, levels off", "axes_changed",
        also=("axes_disagree", "level_step", "unit_changed", "scale_changed"), size=20.0, unit="sigma", least=0.0,
        tests=(TABLE, HAND, TURN), spoil=sense.sensor_change,
    ),
    "run_in_rad_s": Fault(
        "one power-up is in rad/s, stated in deg/s", "unit_disagrees", also=("recording_differs",), tests=(TABLE, HOT),
        spoil=sense.run_in_rad_s,
    ),
    "run_sign": Fault(
        "one power-up has the wrong sign", "sign_disagrees", also=("recording_differs",), tests=(TABLE, HOT, MASS),
        spoil=sense.run_sign,
    ),
    "run_gain": Fault(
        "one power-up reads too much", "gain_disagrees", also=("recording_differs",), size=2.0, unit="%",
        least=-99.0, tests=(TABLE,), spoil=sense.run_gain,
    ),
    "dwell_off": Fault(
        "one dwell reads too much", "reading_disagrees", size=0.5, unit="deg/s", tests=(TABLE,), spoil=sense.dwell_off
    ),
    "copy_of_applied": Fault(
        "the readings are the rates of the table", "copy_of_applied", tests=(TABLE,), spoil=sense.copy_of_applied
    ),
    # ---- bench and standards
    "impossible_temperature": Fault(
        "ten temperatures are impossible", "impossible_temperature", also=("code_outside",), size=50_000.0,
        unit="degC", tests=(HOT, MASS), spoil=bench.impossible_temperature,
    ),
    "stuck_temperature": Fault(
        "the thermometers stick for the last part of a recording", "stuck", also=("stuck_temperature",), size=50.0,
        unit="%", least=1.0, most=99.0, tests=(HOT,), spoil=bench.stuck_temperature,
    ),
    "zero_uncertainty": Fault(
        "a standard is stated with an uncertainty of zero", "zero_uncertainty", expects="refused", tests=ALL,
        spoil=bench.zero_uncertainty,
    ),
    "turn_on": Fault(
        "each power-up has a bias of its own, with this scatter", expects="covered", size=0.01, unit="deg/s",
        least=0.0, tests=(TABLE, HOT), spoil=bench.turn_on,
    ),
    "gyro_flicker": Fault(
        "the gyros have flicker noise with this floor", expects="covered", size=20.0, unit="deg/h", least=0.0,
        tests=(HAND,), spoil=bench.gyro_flicker,
    ),
    "face_error": Fault(
        "each face is tilted, the same whenever it is laid", expects="covered", size=0.5, unit="deg", least=0.0,
        most=20.0, tests=(FACES,), spoil=bench.face_error,
    ),
    "ambient_drift": Fault(
        "the ambient acceleration changes steadily", expects="covered", size=3.0, unit="ug/h", tests=(TURN,),
        spoil=bench.ambient_drift,
    ),
    "wrong_label": Fault(
        "one window has the angle of the other position", "not_turned_by_angle", tests=(TURN,),
        spoil=bench.wrong_label,
    ),
    # ---- moved mass
    "repeating_exponential": Fault(
        "every run has the same drift, which dies away in T/10, in amplitudes of the signal", expects="covered",
        size=300.0, unit="times", tests=(MASS,), spoil=bench.repeating_exponential,
    ),
    "repeating_cubic": Fault(
        "every run has the same cubic drift, in amplitudes of the signal", expects="covered", size=300.0,
        unit="times", tests=(MASS,), spoil=bench.repeating_cubic,
    ),
    "repeating_wave": Fault(
        "every run has the same three slow waves, in amplitudes of the signal", expects="covered", size=300.0,
        unit="times", tests=(MASS,), spoil=bench.repeating_wave,
    ),
    "jump": Fault(
        "the level jumps at the same dwell of every run, in amplitudes of the signal", "jump", size=5.0, unit="times",
        tests=(MASS,), spoil=bench.jump,
    ),
    "gain_change": Fault(
        "the gain of one run changes in the middle", "scale_changed", also=("runs_differ",), size=4.0, unit="times",
        least=0.0, tests=(MASS,), spoil=bench.gain_change,
    ),
    "repeating_gain_change": Fault(
        "the gain changes at the same dwell of every run", "scale_changed", size=1.5, unit="times", least=0.0,
        tests=(MASS,), spoil=bench.repeating_gain_change,
    ),
}  # fmt: skip
