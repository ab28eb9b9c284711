"""The thesis's compensation from counts, by one command, against Table 15 worked out in decimal arithmetic.

Nothing of the package takes part in the figures expected; every digit that the command prints is compared.
"""

from __future__ import annotations

import json
from decimal import Decimal, getcontext
from pathlib import Path

import pytest

from inertialcal.cli.__main__ import main

AXES = "xyz"
CODES = {
    "rate": (2412, 1897, 2190),
    "reference": (2047, 2049, 2046),
    "temperature": (1702, 1695, 1688),
    "validity": (3276, 3270, 3281),
}
HEAD = ",".join([*AXES, *(f"{kind}_{a}" for kind in ("reference", "temperature", "validity") for a in AXES)])
ROW = ",".join(str(code) for codes in CODES.values() for code in codes)
# Table 15, as printed: B, m1, m2, m3; b_cons; M in percent, row = the axis that is turned
POLYNOMIAL = (
    ("-0.00809", "-0.05675", "-0.0107", "-0.00503"),
    ("0.0038", "-0.01519", "-0.0037", "-0.00402"),
    ("0.03219", "-0.01581", "-0.01039", "-0.00796"),
)
B_CONS = ("7.18E-3", "-8.12E-3", "7.00E-3")
M = (("0.042", "0.102", "1.298"), ("-0.156", "-0.4", "0.128"), ("-0.2", "-0.139", "0.506"))
NOMINAL, T_REF = ("-0.5042", "-0.4909", "-0.5071"), ("25.7", "25.4", "25.3")


def by_hand(as_printed: bool) -> dict[str, list[Decimal]]:
    """Every step of equation (2), of each sensor; the name as the command prints it."""
    getcontext().prec = 40
    lsb = Decimal(5) / 4095
    volts = [(c - r) * lsb for c, r in zip(CODES["rate"], CODES["reference"], strict=True)]
    v_t = [(c - r) * lsb for c, r in zip(CODES["temperature"], CODES["reference"], strict=True)]
    rate = [v / Decimal("0.5") for v in volts]
    power = [[Decimal(m) * v**k for k, m in enumerate(row)] for row, v in zip(POLYNOMIAL, v_t, strict=True)]
    total = [sum(row, Decimal(0)) for row in power]
    in_run = total if as_printed else [t / Decimal("0.5") for t in total]
    if as_printed:
        matrix = [[Decimal(entry) / 100 for entry in row] for row in M]
    else:  # transposed, and the sign of the diagonal turned
        matrix = [[Decimal(M[j][i]) / 100 * (-1 if i == j else 1) for j in range(3)] for i in range(3)]
    m_i = [sum((matrix[i][j] * rate[j] for j in range(3)), Decimal(0)) for i in range(3)]
    errors = [b + m + Decimal(c) for b, m, c in zip(in_run, m_i, B_CONS, strict=True)]
    return {
        "V = that * 5 V / 4095": volts,
        "I = V / S_f": rate,
        "V_T = that * 5 V / 4095": v_t,
        "T = (V_T - V_nominal) / slope + T_ref": [
            (v - Decimal(n)) / Decimal("0.0264") + Decimal(t) for v, n, t in zip(v_t, NOMINAL, T_REF, strict=True)
        ],
        "m1 V_T": [row[1] for row in power],
        "m2 V_T^2": [row[2] for row in power],
        "m3 V_T^3": [row[3] for row in power],
        "sum": total,
        "sum, taken for deg/s" if as_printed else "b_in_run = sum / S_f": in_run,
        "M, from x, times I of x": [matrix[i][0] * rate[0] for i in range(3)],
        "M, from y, times I of y": [matrix[i][1] * rate[1] for i in range(3)],
        "M, from z, times I of z": [matrix[i][2] * rate[2] for i in range(3)],
        "M I = their sum": m_i,
        "b_in_run + M I + b_cons": errors,
        "rate = I - that": [r - e for r, e in zip(rate, errors, strict=True)],
    }


def typed(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main(list(words))
    out, err = capsys.readouterr()
    return int(left.value.code or 0), out, err


@pytest.fixture
def counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "counts.csv").write_text(f"unix_s,{HEAD}\n0,{ROW}\n2,{ROW}\n")
    return "counts.csv"


@pytest.mark.parametrize("as_printed", [False, True])
def test_every_printed_digit_is_that_of_the_hand_calculation(
    counts: str, capsys: pytest.CaptureFixture[str], as_printed: bool
) -> None:
    words = ["--as-printed"] if as_printed else []
    status, out, _ = typed(capsys, "compensate", "flight_unit", counts, "--steps", *words)
    assert status == 0
    assert max(map(len, out.splitlines())) <= 100
    lines = {line[2:].split("   ")[0].strip(): line.split() for line in out.splitlines()}
    for name, values in by_hand(as_printed).items():
        shown = lines[name][-4:-1]
        assert shown == [f"{value:.{len(text.partition('.')[2])}f}" for value, text in zip(values, shown, strict=True)]
        assert all(len(text.partition(".")[2]) in {4, 7} for text in shown)


def test_rates_are_those_of_the_manual_and_written_to_a_file(counts: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = typed(
        capsys, "compensate", "flight_unit", counts, "--steps", "--row", "2", "-o", "o.csv", "--json"
    )
    content = json.loads(out)
    assert (status, content["row"], content["rows"]) == (0, 2, 2)
    inverse = content["steps"][-1]["values"]
    assert {a: round(inverse[a], 7) for a in AXES} == {"x": 0.855848, "y": -0.3820461, "z": 0.2597821}
    written = Path("o.csv").read_text().splitlines()
    assert written[0].startswith("unix_s,x [deg/s],y [deg/s],z [deg/s],temperature_x [degC]")
    assert [float(cell) for cell in written[2].split(",")[1:4]] == pytest.approx([inverse[a] for a in AXES], abs=1e-12)


def test_other_headers_are_named_and_a_missing_test_is_said(
    counts: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    kept = ROW.rsplit(",", 3)[0]
    (tmp_path / "other.csv").write_text(f"rx,ry,rz,ref,tx,ty,tz\n{kept.replace(',2047,2049,2046', ',2047')}\n")
    status, _, err = typed(capsys, "compensate", "flight_unit", "other.csv", "--steps")
    assert (status, "no counts of x, y, z, reference_x" in err, "--column x=NAME" in err) == (3, True, True)
    named = ["x=rx", "y=ry", "z=rz", "reference=ref", "temperature_x=tx", "temperature_y=ty", "temperature_z=tz"]
    columns = [word for one in named for word in ("--column", one)]
    status, out, _ = typed(capsys, "compensate", "flight_unit", "other.csv", *columns, "-o", "o.csv", "--json")
    assert status == 0
    assert "no_built_in_test" in {remark["code"] for remark in json.loads(out)["remarks"]}


def test_headers_of_the_suites_recorder_are_found_and_means_keep_their_decimals(
    counts: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Recordings of the suite are means of 200 codes; each digit of what is subtracted is there."""
    head = HEAD
    for kind, short in (("reference", "ref"), ("temperature", "temp"), ("validity", "bit")):
        for axis in AXES:
            head = head.replace(f"{kind}_{axis}", f"{axis}_{short}")
    Path("means.csv").write_text(f"{head}\n{ROW.replace('2412', '2412.125').replace('2047', '2047.5')}\n")
    status, out, _ = typed(capsys, "compensate", "flight_unit", "means.csv", "--steps")
    lines = {line[2:].split("   ")[0].strip(): line.split() for line in out.splitlines()}
    assert (status, lines["rate - reference"][-4:-1]) == (0, ["364.625", "-152.000", "144.000"])
    assert lines["temperature - reference"][-4] == "-345.500"


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (("flight_unit", "counts.csv"), 2, "Add -o FILE"),
        (("flight_unit", "counts.csv", "--steps", "--row", "3"), 2, "rows 1 to 2"),
        (("qrs11", "counts.csv", "-o", "o.csv"), 3, "flight_unit"),
        (("counts.csv", "counts.csv", "--as-printed", "-o", "o.csv"), 3, "flight_unit"),
        (("flight_unit", "railed.csv", "--steps"), 3, "row 1 is not valid"),
    ],
)
def test_what_cannot_be_shown_is_refused(
    counts: str, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], status: int, said: str
) -> None:
    Path("railed.csv").write_text(f"{HEAD}\n{ROW.replace('2412', '4095')}\n")
    got, _, err = typed(capsys, "compensate", *words)
    assert (got, said in err) == (status, True), err
