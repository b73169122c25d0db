"""The certificate: one content, four formats, nothing from outside, nothing by colour alone."""

import hashlib
import io
import re
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_up_session import TRUTH, YES, header_of, hourly, points_at

from solarcal.cli import run_command
from solarcal.config import read_toml
from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.profiles import Profile
from solarcal.report.certificate import (
    WRITERS,
    SourceFile,
    make_certificate,
    office_zip,
    read_sources,
)
from solarcal.report.forecast_map import COLOURS, GLYPHS, forecast_map, level, year_cells
from solarcal.report.markup import paragraph
from solarcal.report.scales import Sheet
from solarcal.report.svg_figures import forecast_figure
from solarcal.session.journal import Journal
from solarcal.session.records import CheckRecord, UploadRecord, Void
from solarcal.station.analysing import FileAnalysis, analyse_files, read_files
from solarcal.station.sign_off import sign_off
from solarcal.station.uploading import forecast_with

NASTY = '<script>alert("x")</script> | `a` \x1b[31m & "q"'


def upload_of(seq: int, **changes) -> UploadRecord:
    record = UploadRecord(
        seq=seq,
        utc="2026-06-22T02:00:00.000Z",
        old_coefficients=Coefficients(),
        old_offsets=Offsets(0.1, -0.2),
        new_coefficients=TRUTH,
        new_offsets=Offsets(),
        verified=True,
        method="robust",
    )
    return msgspec.structs.replace(record, **changes)


def check_of(seq: int, sky_deg: float, status: str = "accepted") -> CheckRecord:
    return CheckRecord(
        seq=seq,
        utc=f"2026-06-22T{seq % 10 + 2:02d}:30:00.000Z",
        read_utc=f"2026-06-22T{seq % 10 + 2:02d}:29:30.000Z",
        status=status,  # type: ignore[arg-type]
        answers=YES,
        ideal_deg=(-60.0, 40.0),
        error_deg=(0.0, sky_deg),
        sky_error_deg=sky_deg,
    )


def write_session(
    path: Path, *after_the_points, operator: str = "A. Person", points: int = 12
) -> Path:
    """Twelve points of a June day (or fewer), then the records given."""
    header = msgspec.structs.replace(
        header_of(), operator=operator, pointing_device="plate, 1 m", software="solarcal 0.0.9"
    )
    with Journal.create(path, header) as journal:
        journal.append_all(
            [
                msgspec.structs.replace(point, seq=number)
                for number, point in enumerate(
                    points_at(header, hourly("2026-06-21", 14, 25))[:points], start=1
                )
            ]
        )
        for record in after_the_points:
            journal.append(record)
    return path


@pytest.fixture(scope="module")
def judged(tmp_path_factory) -> FileAnalysis:
    path = tmp_path_factory.mktemp("certificate") / "day.jsonl"
    records = upload_of(13), check_of(14, 0.031), check_of(15, 0.02)
    return analyse_files(read_files([write_session(path, *records)], {}))


def texts(judged: FileAnalysis) -> dict[str, str]:
    certificate = make_certificate(judged, read_sources(judged.files.paths))
    return {ending: write(certificate) for ending, write in WRITERS.items()}


def read_by_eye(ending: str, text: str) -> str:
    """What a reader sees: without markup, and spaces as one."""
    if ending in (".html", ".svg"):
        body = text.partition("</style>")[2] or text
        text = re.sub(r"<[^>]*>", " ", body)
    if ending == ".md":
        text = re.sub(r"\\(.)", r"\1", text)
    return " ".join(text.split())


@pytest.mark.parametrize("ending", WRITERS)
def test_every_format_says_everything(judged, ending):
    text = texts(judged)[ending]
    seen = read_by_eye(ending, text)
    digest = hashlib.sha256(judged.files.paths[0].read_bytes()).hexdigest()
    for said in (
        "SolarTrak 1", "A. Person", "plate, 1 m", "35.0500 N 106.4800 W", "2026-06-21",
        "SIGNED OFF: 2 check points after the upload", "0.031", digest, "solarcal 0.0.9",
        "12 points, method robust", "as found when the session began", "Signature",
        "Expected error by day of the year and solar hour",
        "Error of the axes at every point, and the model",
    ):  # fmt: skip
        assert said in seen or said in text, said
    for value, sigma in zip(judged.solution.values, judged.solution.sigmas, strict=True):
        assert any(f"{value:+.{d}f}" in seen and f"{sigma:.{d}f}" in seen for d in (4, 6)), value
    for reason in judged.of_the_controller().verdict.reasons:
        assert reason[:40] in seen


@pytest.mark.parametrize("ending", WRITERS)
def test_the_same_files_give_the_same_certificate(judged, ending):
    again = analyse_files(read_files(judged.files.paths, {}))
    assert texts(judged)[ending] == texts(again)[ending]


def test_html_and_svg_need_nothing_from_outside(judged):
    for ending in (".html", ".svg"):
        text = texts(judged)[ending].replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?:|\bsrc=|\bhref=|@import|<script|<link|url\((?!#)", text)


def test_svg_is_well_formed_and_names_what_it_refers_to(judged):
    root = ET.fromstring(texts(judged)[".svg"])
    ids = {element.get("id") for element in root.iter()} - {None}
    fills = {element.get("fill", "") for element in root.iter()}
    assert {f"url(#{name})" for name in ids} >= {fill for fill in fills if fill.startswith("url")}
    assert float(root.get("height")) > 1500.0


@pytest.mark.parametrize("ending", WRITERS)
def test_what_was_struck_out_stands_on_the_certificate_with_its_reason(tmp_path, ending):
    void = Void(seq=14, utc="2026-06-22T05:00:00.000Z", voids=13, reason="I did not like it")
    path = write_session(tmp_path / "s.jsonl", check_of(13, 0.45), void)
    seen = read_by_eye(ending, texts(analyse_files(read_files([path], {})))[ending])
    assert "struck out" in seen
    for said in ("13", "check point accepted: 0.4500 deg left on the sky", "I did not like it"):
        assert said in seen


@pytest.mark.parametrize("ending", WRITERS)
def test_what_is_in_force_again_is_not_listed_as_struck_out(tmp_path, ending):
    utc = "2026-06-22T05:00:00.000Z"
    void = Void(seq=14, utc=utc, voids=13, reason="bird on plate")
    again = Void(seq=15, utc=utc, voids=14, reason="it was none")
    path = write_session(tmp_path / "s.jsonl", check_of(13, 0.45), void, again)
    seen = read_by_eye(ending, texts(analyse_files(read_files([path], {})))[ending])
    assert "struck out" not in seen
    assert "bird on plate" not in seen


@pytest.mark.parametrize("ending", WRITERS)
def test_what_a_file_says_never_becomes_markup(tmp_path, ending):
    void = Void(seq=14, utc="2026-06-22T05:00:00.000Z", voids=2, reason=NASTY)
    path = write_session(tmp_path / "s.jsonl", upload_of(13, forced=NASTY), void, operator=NASTY)
    text = texts(analyse_files(read_files([path], {})))[ending]
    assert "\x1b" not in text
    if ending in (".html", ".svg"):
        assert "<script" not in text
        assert "&lt;script&gt;" in text
    if ending == ".md":
        assert r"\<script\>" in text
        (row,) = [line for line in text.splitlines() if line.startswith("| operator")]
        assert len(re.findall(r"(?<!\\)\|", row)) == 3


TWO = (check_of(14, 0.05), check_of(15, 0.06))


@pytest.mark.parametrize(
    ("records", "signed_off", "said"),
    [
        ([], False, "nothing was uploaded"),
        ([upload_of(13)], False, "no check point"),
        ([upload_of(13), check_of(14, 0.05)], False, "1 check point"),
        ([upload_of(13), check_of(14, 0.05)], False, "2 check points are needed"),
        ([upload_of(13), *TWO], True, "2 check points"),
        ([upload_of(13), check_of(14, 0.05), check_of(15, 0.2)], False, "1 of 2 check points"),
        ([upload_of(13), check_of(14, 0.05), check_of(15, 0.11)], True, "and the noise of a"),
        ([upload_of(13), *TWO, upload_of(16)], True, "2 check points"),
        ([upload_of(13), TWO[0], msgspec.structs.replace(TWO[0], seq=15)], False, "one direction"),
        ([upload_of(13), *TWO, upload_of(16, new_offsets=Offsets(0.1, 0.0))], False, "no check"),
        ([upload_of(13), check_of(14, 0.12, "rejected"), *TWO[1:]], False, "1 check"),
        ([check_of(13, 0.05), upload_of(14)], False, "no check point"),
        ([upload_of(13), *TWO, upload_of(16, rollback=True)], False, "rolled back"),
        ([upload_of(13, verified=False), *TWO], False, "did not read back"),
        ([upload_of(13, new_coefficients=Coefficients(P1=1.0)), *TWO], False, "upload the coeff"),
        ([upload_of(13, new_offsets=Offsets(2.0, 1.0)), *TWO], False, "less than 0.5 % sure"),
        (
            [
                upload_of(13),
                *TWO,
                check_of(16, 0.2),
                Void(seq=17, utc="2026-06-22T03:00:00.000Z", voids=16, reason="cloud"),
            ],
            True,
            "; 1 beyond it, up to 0.200 deg, rejected or struck out",
        ),
        (
            [upload_of(13), *TWO, check_of(16, 0.3, "rejected"), upload_of(17)],
            True,
            "; 1 beyond it, up to 0.300 deg, rejected or struck out",
        ),
    ],
)
def test_signed_off_means_proven_after_the_newest_upload(tmp_path, records, signed_off, said):
    path = write_session(tmp_path / "s.jsonl", *records)
    judged = analyse_files(read_files([path], {}))
    after = sign_off(judged.sessions, judged.analysis)
    assert after.signed_off is signed_off
    assert said in after.reason
    assert not sign_off(judged.sessions, None).signed_off


@pytest.mark.parametrize(("short", "signed_off"), [(0.005, True), (0.02, False)])
def test_what_the_units_decimals_take_of_a_year_just_sure_is_no_reason_against(
    judged, short, signed_off, monkeypatch
):
    """A probability is known from its draws to about a hundredth."""
    stored = replace(judged.analysis.forecast, probability_within_tolerance=0.95 - short)
    monkeypatch.setattr("solarcal.station.sign_off.forecast_with", lambda *given: stored)
    assert sign_off(judged.sessions, judged.analysis).signed_off is signed_off


def test_points_that_do_not_make_the_year_sure_are_not_signed_off(tmp_path):
    """Two check points beside the last points say nothing of the rest of the year."""
    path = write_session(
        tmp_path / "s.jsonl", upload_of(4), check_of(5, 0.05), check_of(6, 0.06), points=3
    )
    judged = analyse_files(read_files([path], {}))
    assert judged.analysis.verdict.state != "done"
    after = sign_off(judged.sessions, judged.analysis)
    assert (after.signed_off, after.proven) == (False, True)
    assert "(95 % needed): take more points" in after.reason


def test_check_points_beyond_the_tolerance_are_evidence_against_the_verdict(tmp_path):
    beyond = [upload_of(13), check_of(14, 0.05), check_of(15, 0.45)]
    path = write_session(tmp_path / "s.jsonl", *beyond)
    judged = analyse_files(read_files([path], {}))
    (finding,) = [one for one in judged.findings if one.kind == "not_proven"]
    assert (finding.number, finding.labels) == (0.45, (15,))
    verdict = judged.analysis.verdict
    assert verdict.state == "continue"
    assert verdict.reasons[0].startswith("1 of 2 check points after the upload: beyond")
    # The same numbers written once more prove nothing else; other ones have checks of their own.
    for name, new, state in (("same", TRUTH, "continue"), ("other", Coefficients(P1=0.4), "done")):
        again = upload_of(16, new_coefficients=new)
        path = write_session(tmp_path / f"{name}.jsonl", *beyond, again)
        assert analyse_files(read_files([path], {})).analysis.verdict.state == state


def test_as_found_is_the_year_with_what_the_unit_held(judged):
    judgement = judged.of_the_controller()
    nothing = forecast_with(judgement, Coefficients(), Offsets())
    assert nothing.year_rms_deg > 0.4
    shifted = Coefficients(TRUTH.P1, 0.0, TRUTH.P3, 0.0, TRUTH.P5, TRUTH.P6)
    same = forecast_with(judgement, shifted, Offsets(TRUTH.P2, TRUTH.P4))
    assert same.year_rms_deg == forecast_with(judgement, TRUTH, Offsets()).year_rms_deg
    assert same.year_rms_deg < 0.1


def test_the_map_grows_darker_with_the_error_and_keeps_the_worst_of_a_cell(judged):
    expected = judged.of_the_controller().forecast
    assert [level(x, 0.1) for x in (0.02, 0.04, 0.09, 0.15, 0.5)] == [0, 1, 2, 3, 4]
    assert level(np.nan, 0.1) is None
    worst = level(float(np.nanmax(expected.map_rms_deg)), 0.02)
    for width, height in ((40, 10), (80, 24), (130, 45)):
        drawn = forecast_map(expected, Sheet(width, height, colour=False), tolerance_deg=0.02)
        lines = drawn.split("\n")
        assert len(lines) <= height
        assert max(map(len, lines)) <= width
        body = "\n".join(lines[1:-2])
        assert GLYPHS[worst] in body
        assert all(glyph in lines[0] for glyph in GLYPHS)
    assert "\x1b" not in drawn


def test_colour_only_repeats_what_the_glyphs_say(judged, monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    expected = judged.of_the_controller().forecast
    plain = forecast_map(expected, Sheet(80, 24, colour=False))
    tinted = re.sub(r"\x1b\[[0-9;]*m", "", forecast_map(expected, Sheet(80, 24)))
    assert [line.rstrip() for line in tinted.split("\n")] == plain.split("\n")


def test_a_fine_map_has_two_half_hours_a_row_and_a_legend_in_degrees(judged, monkeypatch):
    """Each half block has the colour of its own half hour's level."""
    monkeypatch.delenv("NO_COLOR", raising=False)
    expected = judged.of_the_controller().forecast
    drawn = forecast_map(expected, Sheet(80, 24), tolerance_deg=0.02, fine=True)
    lines = drawn.split("\n")
    legend = re.sub(r"\x1b\[[0-9;]*m", "", lines[0])
    assert "deg" in legend
    assert [float(end) for end in re.findall(r"█ to ([\d.]+)", legend)] == [
        0.005, 0.01, 0.02, 0.04,
    ]  # fmt: skip
    cells = year_cells(expected)
    assert len(lines) == 1 + -(-len(cells.hours) // 2) + 2
    tones = COLOURS["phosphor"]
    for row, line in enumerate(lines[1:-2]):
        blocks = re.findall(r"\x1b\[38;5;(\d+)(?:;48;5;(\d+))?m([▀▄]+)", line)
        upper = [level(x, 0.02) for x in cells.rms_deg[2 * row]]
        two = [(front, back) for front, back, glyph in blocks if glyph[0] == "▀" and back]
        assert {int(front) for front, _ in two} <= {tones[k] for k in upper if k is not None}


def test_beyond_the_tolerance_the_drawn_map_is_hatched(judged):
    expected = judged.of_the_controller().forecast
    least, most = np.nanmin(expected.map_rms_deg), np.nanmax(expected.map_rms_deg)

    def cells(tolerance_deg: float) -> list[str]:
        drawn = re.findall(r'<rect [^>]*fill="([^"]*)"/>', forecast_figure(expected, tolerance_deg))
        return [fill for fill in drawn if fill not in ("none", "#fff")]

    assert not any(fill.startswith("url") for fill in cells(1.01 * float(most)))
    assert all(fill.startswith("url") for fill in cells(0.99 * float(least)))


def test_the_office_zip_checks_itself_and_is_always_the_same(judged, tmp_path):
    source = read_sources(judged.files.paths)[0]
    twin = SourceFile(source.name, source.content + b" ")
    certificate = SourceFile("c.html", b"<html>")
    packed = office_zip(certificate, [source, twin], judged.header)
    assert packed == office_zip(certificate, [source, twin], judged.header)
    archive = zipfile.ZipFile(io.BytesIO(packed))
    names = archive.namelist()
    assert len(names) == len(set(names)) == 6
    sums = dict(
        reversed(line.split("  ")) for line in archive.read("SHA256SUMS").decode().splitlines()
    )
    assert set(sums) == set(names) - {"SHA256SUMS"}
    for name, digest in sums.items():
        assert hashlib.sha256(archive.read(name)).hexdigest() == digest
    assert archive.read(source.name) == source.content
    (tmp_path / "p.toml").write_bytes(archive.read("profile.toml"))
    profile = read_toml(tmp_path / "p.toml", Profile)
    assert profile.operator == "A. Person"
    assert profile.site == judged.header.site


def test_points_of_other_terms_get_no_certificate(judged):
    free = analyse_files(read_files(judged.files.paths, {}), terms=("P1", "P2", "P3", "P4"))
    assert free.analysis is None
    with pytest.raises(ConfigurationError, match="six terms"):
        make_certificate(free, ())


@pytest.mark.parametrize(
    ("typed", "written"),
    [
        ("P1 +0.25 (one)", "P1 +0.25 (one)"),
        ("a|b <i> `c` *d* _e_ [f](g) &lt; ~~h~~ \\",
         r"a\|b \<i\> \`c\` \*d\* \_e\_ \[f\](g) \&lt; \~\~h\~\~ \\"),
        ("see https://x.y or www.z", r"see https:/\/x.y or www\.z"),
        ("- no list", r"\- no list"),
        ("12. no list", r"12\. no list"),
        ("# no heading", r"\# no heading"),
        ("two\nlines\x07", "two lines\N{REPLACEMENT CHARACTER}"),
    ],
)  # fmt: skip
def test_markdown_shows_what_was_typed(typed, written):
    assert paragraph(typed) == written


def written_over(path, content, session, *words):
    path.write_bytes(content)
    told = run_command(["report", str(session), "-o", str(path), *words])
    return told, path.read_bytes()


@pytest.mark.parametrize("ending", WRITERS)
def test_a_certificate_is_issued_again_and_nothing_else_is_replaced(judged, tmp_path, ending):
    session, path = judged.files.paths[0], tmp_path / f"day{ending}"
    code, issued = written_over(path, texts(judged)[ending].encode(), session)
    assert code == 0
    book = b"field book of the day\r\n09:10 az 80.12 el 30.11\r\n"
    assert written_over(path, book, session) == (2, book)
    assert written_over(path, b"", session) == (2, b"")
    assert written_over(path, issued, session, "--zip")[0] == 0


def test_a_zip_of_the_same_name_is_left_alone(judged, tmp_path, capsys):
    session, archive = judged.files.paths[0], tmp_path / "day.zip"
    call = ["report", str(session), "-o", str(tmp_path / "day.md"), "--zip"]
    assert run_command(call) == 0
    assert run_command(call) == 0
    whole = archive.read_bytes()
    (tmp_path / "day.md").unlink()
    broken = whole.replace(b"PK\1\2", b"PK\7\7")
    for other in (b"PK not really", b"", b"PK\5\6" + bytes(18), broken, whole[:-10]):
        archive.write_bytes(other)
        assert run_command(call) == 2
        assert "day.zip exists and is not a certificate" in capsys.readouterr().err
        assert archive.read_bytes() == other
        assert not (tmp_path / "day.md").exists()


def test_what_cannot_be_looked_at_is_not_replaced(judged, tmp_path, capsys, monkeypatch):
    path = tmp_path / "day.txt"
    path.write_text("locked")

    def refused(self: Path, mode: str) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refused)
    assert run_command(["report", str(judged.files.paths[0]), "-o", str(path)]) == 2
    assert "day.txt cannot be replaced: Permission denied" in capsys.readouterr().err
