# ruff: noqa: E501 - advices stand as the sources have them
"""Advices on models, levels, archives and campaigns, obeyed; as those of `advised_cases`."""

from __future__ import annotations

from advised_cases import Case

COMPENSATED = (
    Case(
        'Write it like --standard \'{}={ u = "0.1 %", certificate = "C-1" }\'',
        "allan rest_units.csv --standard 'sensor.scale_factor={ u = 0.1 % }'",
        'allan rest_units.csv --standard \'sensor.scale_factor={ u = "0.1 %", certificate = "C-1" }\'',
        "white x 0.02",
    ),
    Case(
        "Cut out the rows of one condition: inertialcal convert DATA OUT --from --to",
        "compensate both.json pumped.csv -o pumped_out.csv",
        "convert pumped.csv in_air.csv --from 0 --to 2 ; compensate both.json in_air.csv -o air_out.csv",
        "zero air_out.csv",
    ),
    Case(
        "These data fit: --condition {}",
        "compensate both.json in_vacuum.csv -o vacuum_out.csv --condition air",
        "compensate both.json in_vacuum.csv -o vacuum_out.csv --condition vacuum",
        "zero vacuum_out.csv",
    ),
    Case(
        "--condition {}",
        "compensate both.json unsaid.csv -o unsaid_out.csv",
        "+ --condition vacuum",
        "zero unsaid_out.csv",
        quick=True,
    ),
    Case(
        "Say it: --column pressure=NAME",
        "compensate both.json two_gauges.csv -o gauge_out.csv",
        "+ --column pressure=gauge_2_pressure",
        "zero gauge_out.csv",
    ),
    Case(
        'Say it: --temperature {}, or --temperature "NUMBER degC"',
        "compensate thermal.json rest_plain.csv -o plain_out.csv",
        '+ --temperature "20 degC"',
        "zero plain_out.csv",
        quick=True,
    ),
    Case(
        "; of each axis: --column temperature_x=COLUMN. Columns: {}",
        "compensate thermal.json rest_thermometers.csv -o thermometers_out.csv",
        "+ --column temperature_x=case --column temperature_y=case --column temperature_z=board",
        "zero thermometers_out.csv",
    ),
    Case(
        "--column {}=NAME",
        "compensate supply.json levels_two.csv -o levels_out.csv",
        "+ --column supply=vcc",
        "done",
    ),
    Case(
        "Give the model of the {} too: --with MODEL",
        "export model.json --to imucal -o both_sensors.json --unjudged --nominal",
        "+ --with acc.json",
        "done",
    ),
    Case(
        "Estimate it, export --to json, which says so, or add --nominal",
        "export model.json --to kalibr-model -o model.yaml --unjudged",
        "+ --nominal",
        "done",
    ),
    Case(
        "; noise: inertialcal allan FILE --for kalibr",
        "export thermal.json --to kalibr-model -o thermal.yaml --unjudged --nominal",
        "allan rest_units.csv --for kalibr",
        "white x 0.02",
    ),
    Case(
        "If these have a temperature calibration, export both in one file: --with MODEL of the {}s",
        "export thermal.json --to ardupilot -o thermal.parm --unjudged",
        "+ --with acc_thermal.json",
        "done",
    ),
    Case(
        "Make the model of a thermal test: inertialcal thermal FILE -o model.json",
        "export no_range.json --to ardupilot -o air.parm --unjudged",
        "thermal chamber_units.csv -o thermal_2.json ; export thermal_2.json --to ardupilot -o air.parm --unjudged",
        "done",
    ),
    Case(
        "With uncertainties, on whole recordings: inertialcal compensate MODEL DATA -o OUT --uncertainty",
        "export model.json --to python -o applied.py --unjudged --nominal",
        "compensate model.json turned_units.csv -o uncertain.csv --uncertainty",
        "zero uncertain.csv",
    ),
    Case(
        "Give it beside the model: inertialcal filter MODEL NOISE, a recording at rest or terms.json of allan",
        "filter model.json",
        "filter model.json rest_units.csv",
        "noise 0.02",
    ),
    Case(
        "Give a recording at rest, or terms.json of: inertialcal allan FILE -o FOLDER",
        "filter model.json no_terms.json",
        "allan rest_units.csv -o terms ; filter model.json terms/terms.json",
        "noise 0.02",
    ),
    Case(
        "Add --sample-rate, that of the readings that the filter takes",
        "filter noisy.json --vibration vibration.csv --unit acc=g",
        "+ --sample-rate 50",
        "noise 0.02",
    ),
    Case(
        "Give the unit: --unit acc=g",
        "filter model.json rest_units.csv --vibration vibration.csv",
        "+ --unit acc=g",
        "noise 0.02",
    ),
    Case(
        "{}, below {} {} (95 %); --take upper_limit writes that",
        "allan rest_units.csv --for kalibr",
        "+ --take upper_limit",
        "white x 0.02",
    ),
    Case(
        "Add: --column COLUMN. The file has: {}",
        "allan warm.csv",
        "+ --column warm",
        "white x 0.02",
    ),
    Case(
        "--unit {}={} ({})",
        "allan acc_bare.csv",
        "+ --unit acc=m/s2",
        "done",
    ),
)
LEVELS = (
    Case(
        "Name its column: --column {}=COLUMN, or conditions = { {} = { column, unit } }",
        "sensitivity levels_two.csv --to supply",
        "+ --column supply=vcc",
        "bias_supply x 0.4",
    ),
    Case(
        "Add: --column {}=COLUMN; it has {}",
        "sensitivity levels.csv --to humidity",
        "+ --column humidity=supply",
        "bias_humidity x 0.4",
    ),
    Case(
        "State the unit of its column: --unit {}={}, or the reference: --reference {}=VALUE",
        "sensitivity levels_wrong.csv --to supply",
        "+ --unit supply=V",
        "bias_supply x 0.4",
    ),
    Case(
        "Fit the drift: --drift 1. Better: {}{}",
        "sensitivity levels_drift.csv --to supply",
        "+ --drift 1",
        "bias_supply x 0.4",
    ),
    Case(
        "Check the unit of its column: --unit {}=Torr",
        "sensitivity torr.csv --to pressure",
        "+ --unit pressure=Torr",
        "bias_pressure x 3.00025e-6",
    ),
    Case(
        "Add: --axis x",
        "sensitivity swung.csv --to supply",
        "+ --axis x",
        "bias_supply x 0.4",
        quick=True,
    ),
    Case(
        'Give what a sample is the mean of, at most its interval: --averaging "{} s"',
        'sine wave.csv --column x=pulses --period "4 s" --averaging "1 s"',
        'sine wave.csv --column x=pulses --period "4 s" --averaging "0 s"',
        "amplitude x 3",
    ),
    Case(
        "If it is the decimal sign: inertialcal convert FILE NEW.csv --decimal comma. ",
        "allan comma.csv",
        "convert comma.csv point.csv --decimal comma ; allan point.csv",
        "white x 0.02",
        quick=True,
    ),
    Case(
        ". If the comma is the decimal sign all the same: inertialcal convert FILE NEW.csv --decimal comma",
        "allan comma_whole.csv",
        "convert comma_whole.csv point_2.csv --decimal comma ; allan point_2.csv",
        "white x 0.02",
    ),
    Case(
        'State the unit: --unit gyro={}, or unit = "{}" of the channels in campaign.toml',
        "positions faces_gyro_wrong.csv",
        "+ --unit gyro=rad/s",
        "gyro.bias x 0.0061087",
    ),
    Case(
        'State the unit: --unit acc={}, or unit = "{}" of the channels in campaign.toml',
        "positions faces_acc_wrong.csv",
        "+ --unit acc=g",
        "bias x 0.0122366",
    ),
    Case(
        "--unit {}={}, or {}=count",
        "positions faces_length.csv --column acc_x=a --column acc_y=b --column acc_z=c",
        "+ --unit acc=m/s2",
        "bias x 0.12",
    ),
    Case(
        "Add --time-column NAME, or --unit NAME=ns where its stamps are whole numbers",
        "positions acc=faces_acc_ns.csv gyro=faces_gyro_ns.csv",
        "+ --unit t=ns",
        "gyro.bias x 0.0061087",
    ),
)
HEADS = (
    Case(
        "Cut the record there (--from, --to), or record the gain as well",
        'flip head_gain.csv --window "0..600=0 deg" --window "606..1200=180 deg" --window "1206..1800=0 deg"',
        'flip head_gain.csv --window "0..600=0 deg" --window "606..1200=180 deg" --from 0 --to 1500',
        "bias z 1135.698",
    ),
    Case(
        "Cut the record there (--from, --to), and state unit and range of each part",
        'flip head_unit.csv --window "0..600=0 deg" --window "606..1200=180 deg" --window "1206..1800=0 deg"',
        'flip head_unit.csv --window "0..600=0 deg" --window "606..1200=180 deg" --from 0 --to 1500',
        "bias y 1227.412",
    ),
    Case(
        "--window {} --window ...",
        "flip head_gain.csv",
        '+ --window "0..600=0 deg" --window "606..1200=180 deg" --window "1206..1800=0 deg"',
        "bias y 1227.412",
    ),
    Case(
        "Give the windows of these dwells too, or cut the record (--from, --to): it shows the noise",
        'flip head.csv --window "0..600=0 deg" --window "606..1200=180 deg"',
        'flip head.csv --window "0..600=0 deg" --window "606..1200=180 deg" --window "1206..1800=0 deg"',
        "bias y 1227.412",
    ),
    Case(
        "Add: --mission-start TIME",
        'flip pads --frame sensor --axis y --window "000/00:00:00..000/00:10:00=0 deg" --window "000/00:10:06..000/00:20:00=180 deg"',
        "+ --mission-start 2014-10-22T09:36:36Z",
        "bias x 1227.412",
    ),
    Case(
        'Add: --position "{}=ANGLE deg"',
        "flip halves.csv",
        '+ --position "forward=0 deg" --position "reverse=180 deg"',
        "bias y 980",
        quick=True,
    ),
    Case(
        "Add: --unit ug",
        'flip halves_bare.csv --position "forward=0 deg" --position "reverse=180 deg"',
        "+ --unit ug",
        "bias y 980",
    ),
    Case(
        "Add: --column mean=COLUMN",
        'flip halves_named.csv --position "forward=0 deg" --position "reverse=180 deg" --unit ug',
        "+ --column mean=read_out",
        "bias y 980",
    ),
    Case(
        "If the stamps are right: --sample-rate {}",
        "info pad_drift",
        "+ --sample-rate 100.050005",
        "rate 100.05",
    ),
    Case(
        "Use one part alone (--from, --to)",
        "info pad_gain",
        "+ --from 2014-10-22T09:36:36Z --to 2014-10-22T09:36:37Z",
        "rate 100",
    ),
    Case(
        "For sensor axes, in which its bias and scale factor are defined, add --frame sensor",
        "info pads",
        "+ --frame sensor",
        "has to the axes of the sensor",
    ),
    Case(
        "Read it without --frame",
        "info pad_plain --frame sensor",
        "info pad_plain",
        "rate 100",
        quick=True,
    ),
    Case(
        "Leave --time-column out",
        "info pad_plain --time-column 1",
        "info pad_plain",
        "rate 100",
    ),
    Case(
        "Name files of one sample rate, or limit the time (--from, --to)",
        "info pad_rates",
        "+ --from 2014-10-22T09:36:36Z --to 2014-10-22T09:36:36.9Z",
        "rate 100",
    ),
    Case(
        "Read them in the axes of the sensor (--frame sensor), or one file alone",
        "info pad_frames",
        "+ --frame sensor",
        "rate 100",
    ),
    Case(
        "The head may have been turned about {}: check plan.axis (--axis {}), columns and mounting",
        "flip pads --frame sensor",
        "+ --axis y",
        "bias x 1227.412",
    ),
)
MASSES = (
    Case(
        'Write --set GROUP.KEY=VALUE, like --set body.cube="5.08 cm"',
        "plan mass-attraction --set orbit.stand_off",
        'plan mass-attraction --set "orbit.stand_off=10.2 cm"',
        "done",
    ),
    Case(
        "Add: --schedule schedule.csv",
        "mass-attraction rig_mesa/recordings/run1.csv rig_mesa/recordings/run2.csv --column x=pulses --gate '100 s'",
        "+ --schedule rig_mesa/schedule.csv",
        "scale_factor x 10.1447",
    ),
    Case(
        '--gate "GATE s"',
        "mass-attraction rig_mesa/recordings/run1.csv rig_mesa/recordings/run2.csv --column x=pulses --schedule rig_mesa/schedule.csv",
        "+ --gate '100 s'",
        "scale_factor x 10.1447",
    ),
)
CAMPAIGNS = (
    Case(
        "Type: inertialcal run {}",
        "certificate certified -o certificate.xml",
        "run certified ; certificate certified -o certificate.xml",
        "has 2026-014",
    ),
    Case(
        "Give both: --sign-key KEY.pem --sign-certificate CERT.pem",
        "certificate certified -o signed.xml --sign-key key.pem",
        "+ --sign-certificate cert.pem",
        "done",
    ),
    Case(
        "Add --allowed CHANGE, the largest that is allowed",
        "compare shared_1 shared_2 --decision simple_acceptance",
        "+ --allowed '1 %'",
        "done",
    ),
    Case(
        'State it for a quantity, like --allowed bias="0.01 deg/s"',
        'compare shared_1 shared_2 --allowed "1 m"',
        'compare shared_1 shared_2 --allowed bias="0.01 deg/s"',
        "done",
    ),
    Case(
        "--shared {}",
        "compare shared_1 shared_2",
        "+ --shared rate_table.rate",
        "has one standard in both, so its error cancels",
    ),
    Case(
        "Delete the file, then type: inertialcal init {}",
        "check empty",
        "rm empty/campaign.toml ; init empty --yes",
        "done",
    ),
    Case(
        "Name another folder: inertialcal demo {} -o FOLDER",
        "demo sams1996 -o taken",
        "demo sams1996 -o demo_here",
        "done",
    ),
    Case(
        "Type again: inertialcal run DIR; it keeps the edited file apart",
        "edit edited/out/results.json 0.35 0.36 ; show edited",
        "run edited ; show edited",
        "done",
    ),
    Case(
        "Try: inertialcal simulate {} -o DIR",
        "score campaign",
        "simulate rate_table -o simulated ; run simulated ; score simulated",
        "has scale_factor",
    ),
    Case(
        "Say: inertialcal simulate {} -o DIR",
        "simulate mesa",
        "simulate mesa -o simulated_2",
        "done",
    ),
    Case(
        "Next: inertialcal run {}, then inertialcal score {}",
        "text simulate mesa -o simulated_3",
        "run simulated_3 ; score simulated_3",
        "done",
    ),
    Case(
        "{}: {}. Next: inertialcal run {}",
        "text check campaign",
        "run campaign",
        "done",
    ),
)
MORE = (*COMPENSATED, *LEVELS, *HEADS, *MASSES, *CAMPAIGNS)
