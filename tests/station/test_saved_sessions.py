"""The saved sessions can be replayed and fitted, and show what their README says."""

import json
import os
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace as replace_struct

from solarcal.config import Choice
from solarcal.errors import ProcedureRefused
from solarcal.mount.formula import Coefficients
from solarcal.optics.reflection import Target
from solarcal.session.journal import Journal
from solarcal.session.lines import sealed
from solarcal.session.records import PointRecord, Void
from solarcal.session.view import read_session
from solarcal.site import Site
from solarcal.station import saved_sessions
from solarcal.station.analysing import analyse_files, read_files
from solarcal.station.clocks import clock_beside
from solarcal.station.fitting import sky_context, solve
from solarcal.station.procedure import Station
from solarcal.station.saved_sessions import (
    Replay,
    SavedSession,
    continuing,
    finished,
    look_into,
    session_files,
)
from solarcal.station.sign_off import sign_off
from solarcal.station.uploading import find_upload
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import UnitIdentity

SESSIONS = Path(__file__).parents[2] / "sessions"
FILES = sorted(SESSIONS.glob("*.jsonl"))


def view(name: str):
    replay = Replay.open(SESSIONS / name)
    replay.jump(len(replay))
    return replay.view


def test_every_session_is_told_in_the_readme():
    readme = (SESSIONS / "README.md").read_text()
    assert len(FILES) >= 6
    assert all(f"`{file.name}`" in readme for file in FILES)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_saved_session_is_whole_and_its_last_fit_comes_out_again(file):
    session = view(file.name)
    assert read_session(file).warnings == ()
    solution = solve(session)
    assert solution is not None
    told = session.fits[-1]
    again = solution.coefficients().as_tuple()
    for number, (now, then) in enumerate(
        zip(again, told.coefficients.as_tuple(), strict=True), start=1
    ):
        # Other versions of numpy and of the fit may differ in the last digits, not in the answer.
        assert now == pytest.approx(then, abs=2e-4 if number > 4 else 0.02), f"P{number}"
    assert session.uploads[-1].verified


def test_the_one_with_aborted_and_rejected_points_has_them():
    statuses = [point.status for point in view("azel-aborted-and-rejected.jsonl").points]
    assert statuses.count("aborted") == 1
    assert statuses.count("rejected") == 2
    assert statuses.count("accepted") == 12


def test_the_southern_one_is_on_its_branch():
    session = view("southern-day.jsonl")
    assert session.header.ax1_centre_deg == 180.0
    assert all(0.0 < p.ideal_deg[0] < 360.0 for p in session.accepted)


def test_the_two_day_one_has_two_days():
    days = {point.utc[:10] for point in view("ns-tiltroll-two-days.jsonl").accepted}
    assert {"2026-06-10", "2026-06-11"} <= days


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        (None, None),
        ("site.longitude_deg=253.52", None),
        ("unit.ax1_centre_deg=10", "centre of the branch of axis 1"),
        ("site.latitude_deg=35.2", "latitude"),
    ],
)
def test_a_session_is_loaded_only_into_a_unit_that_is_set_up_as_it_was(bench, setting, what):
    b = bench()
    b.on_sun()
    b.technician.take_point()
    b.station.leave()
    other = bench(*(("tijeras-azel",) if setting is None else ("tijeras-azel", setting)))
    station = Station(other.unit, clock_beside(other.unit.emulation))
    station.connect()
    journal = Journal.resume(b.path)
    try:
        if what is None:
            station.resume_session(journal)
            assert station.upload(Coefficients(P1=0.1), method="linear").verified
        else:
            with pytest.raises(ProcedureRefused, match=f"another {what}"):
                station.resume_session(journal)
    finally:
        journal.close()


def test_a_session_needs_no_going_on_with_before_it_is_begun_and_after_a_verified_upload():
    replay = Replay.open(SESSIONS / "azel-good-day.jsonl")
    told = []
    for position in range(len(replay) + 1):
        replay.jump(position)
        told.append(finished(replay.view))
    names = [type(record).__name__ for record in replay.records]
    begun = names.index("Initialised") + 1
    uploaded = names.index("UploadRecord") + 1
    assert set(told[:begun]) == {"left before the calibration was begun"}
    assert set(told[begun:uploaded]) == {""}
    assert set(told[uploaded:]) == {"calibration finished"}


def test_neither_a_rollback_nor_a_failed_upload_finishes_a_calibration():
    replay = Replay.open(SESSIONS / "azel-good-day.jsonl")
    replay.jump(len(replay))
    session = replay.view
    for change in ({"rollback": True}, {"verified": False}):
        upload = msgspec.structs.replace(session.uploads[-1], **change)
        assert finished(replace(session, uploads=(upload,))) == ""


def test_a_replay_warns_of_a_contradiction_and_not_of_a_session_that_goes_on(tmp_path):
    whole = (SESSIONS / "azel-good-day.jsonl").read_bytes().splitlines(keepends=True)
    path = tmp_path / "session.jsonl"
    path.write_bytes(b"".join(whole[:8]))
    assert len(read_session(path).warnings) == 1
    assert Replay.open(path).warnings == ()
    path.write_bytes(b"".join(whole[:8]) + whole[8][:20])
    (warning,) = Replay.open(path).warnings
    assert "session.jsonl" in warning


def test_a_replay_stops_at_both_ends_of_its_session():
    replay = Replay.open(SESSIONS / "azel-good-day.jsonl")
    replay.jump(3)
    replay.step(-10)
    assert replay.position == 0
    assert replay.utc_s == parse_utc(replay.header.utc)
    assert replay.view.records == ()
    replay.step(10_000)
    assert replay.position == len(replay)


def test_a_replay_goes_to_just_after_a_point():
    replay = Replay.open(SESSIONS / "azel-aborted-and-rejected.jsonl")
    places = [i for i, r in enumerate(replay.records) if isinstance(r, PointRecord)]
    for number, place in ((1, places[0]), (3, places[2]), (0, places[0]), (99, places[-1])):
        replay.jump_to_point(number)
        assert replay.position == place + 1
        assert replay.utc_s == parse_utc(replay.records[place].utc)


def test_the_newest_upload_to_a_unit_is_found_among_its_sessions(tmp_path):
    unit = read_session(SESSIONS / "azel-good-day.jsonl").header.unit
    identity = UnitIdentity(unit.model, unit.serial, unit.firmware)
    with pytest.raises(ProcedureRefused, match="records an upload to unit"):
        find_upload(tmp_path, identity)
    lines = (SESSIONS / "azel-good-day.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "b.jsonl").write_bytes(b"".join(lines))
    (tmp_path / "a.jsonl").write_bytes(b"".join(lines[:8]))
    assert find_upload(tmp_path, identity) == (tmp_path / "b.jsonl", ())
    # What cannot be read is no reason not to roll back, and is named.
    (tmp_path / "c.jsonl").write_bytes(b"".join(lines[:3]).replace(b"0001", b"0002"))
    found, (unreadable,) = find_upload(tmp_path, identity)
    assert found == tmp_path / "b.jsonl"
    assert str(tmp_path / "c.jsonl") in unreadable
    with pytest.raises(ProcedureRefused, match="records an upload to unit"):
        find_upload(tmp_path, msgspec.structs.replace(identity, serial="another"))


def test_the_year_of_a_unit_ends_at_its_limits_and_an_import_has_none():
    session = view("azel-good-day.jsonl")
    header, table = session.header, session.table
    assert sky_context(table, header).limits == header.unit.limits
    imported = msgspec.structs.replace(header.unit, model="imported")
    assert sky_context(table, msgspec.structs.replace(header, unit=imported)).limits is None
    assert sky_context(table).limits is None


def test_without_an_upload_nothing_is_signed_off():
    session = replace(view("azel-good-day.jsonl"), uploads=())
    proof = sign_off([session], None)
    assert (proof.signed_off, proof.reason) == (False, "nothing was uploaded")


def test_two_sessions_between_which_an_encoder_was_moved_are_told_apart(tmp_path):
    """Half a degree at the encoder of axis 1; four years later the Sun stands where it stood."""
    lines = (SESSIONS / "azel-good-day.jsonl").read_bytes().splitlines()
    (tmp_path / "first.jsonl").write_bytes(b"\n".join(lines) + b"\n")
    later = []
    for line in lines:
        record = json.loads(line.replace(b"2026-06-03", b"2030-06-03"))
        if record["type"] == "point":
            record["error_deg"][0] += 0.5
            record["reading_deg"][0] += 0.5
        del record["crc32c"]
        later.append(sealed(json.dumps(record).encode()))
    (tmp_path / "second.jsonl").write_bytes(b"\n".join(later) + b"\n")
    names = [tmp_path / name for name in ("first.jsonl", "second.jsonl")]
    findings = analyse_files(read_files(names, {})).findings
    (moved,) = [finding for finding in findings if finding.kind == "moved"]
    assert moved.subject == "zeros"
    assert moved.number == pytest.approx(0.5, abs=0.1)


def test_a_point_struck_out_is_not_counted_where_the_session_is_offered(tmp_path):
    copy = tmp_path / "day.jsonl"
    copy.write_bytes((SESSIONS / "azel-good-day.jsonl").read_bytes())
    assert "12 points" in look_into(copy).words()
    point = view("azel-good-day.jsonl").accepted[0]
    with Journal.resume(copy) as journal:
        journal.append(Void(seq=journal.next_seq, utc=point.utc, voids=point.seq, reason="a cloud"))
    assert "11 points" in look_into(copy).words()


def test_only_a_whole_unfinished_session_of_the_same_unit_can_be_gone_on_with(monkeypatch):
    unit = ("SolarTrak", "0042", "azel")
    site, target = Site(35.05, 179.998, 1830.0), Target(10.0, 80.0, 100.0)
    mine = SavedSession(Path("mine.jsonl"), finished=False, unit=unit, site=site, target=target)
    others = [
        replace(mine, finished=True),
        replace(mine, damage="torn"),
        replace(mine, unit=("SolarTrak", "0043", "azel")),
        replace(mine, unit=("SolarTrak", "0042", "polar")),
        replace(mine, site=replace_struct(site, latitude_deg=35.07)),
        replace(mine, site=replace_struct(site, longitude_deg=179.98)),
        replace(mine, site=None),
        replace(mine, target=None),
        replace(mine, target=Target(10.0, 80.0, 120.0)),
    ]
    monkeypatch.setattr(saved_sessions, "saved_sessions", lambda: [*others, mine])
    # The surveyed place may differ by a few digits, and across the date line.
    near = replace_struct(site, longitude_deg=-179.998)
    assert saved_sessions.unfinished_sessions(*unit, near, target) == [mine]


def test_session_files_are_listed_newest_first_without_those_that_are_gone(tmp_path):
    folder, other = tmp_path / "sessions", tmp_path / "other.jsonl"
    folder.mkdir()
    for at, path in enumerate((folder / "b.jsonl", other, folder / "a.jsonl", folder / "c.txt")):
        path.write_text("")
        os.utime(path, (1e9 + at, 1e9 + at))
    (folder / "nowhere.jsonl").symlink_to(tmp_path / "gone.jsonl")
    found = session_files([folder, tmp_path / "none"], [other, tmp_path / "gone.jsonl"])
    assert found == [folder / "a.jsonl", other, folder / "b.jsonl"]


def test_a_session_is_offered_with_its_points_and_where_it_is(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(SESSIONS))
    saved = look_into(SESSIONS / "azel-good-day.jsonl")
    last_utc = read_session(SESSIONS / "azel-good-day.jsonl").records[-1].utc
    assert saved.words() == f"azel-good-day.jsonl  12 points, last {last_utc[:16]}Z"
    assert {one.path for one in saved_sessions.saved_sessions()} == set(FILES)
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path))
    assert saved.words().endswith(f"  in {SESSIONS}")
    (tmp_path / "bad.jsonl").write_text("x")
    assert look_into(tmp_path / "bad.jsonl").words() == "bad.jsonl  cannot be read"


def test_a_session_goes_on_on_the_line_it_was_taken_on(tmp_path):
    saved = SavedSession(tmp_path / "day.jsonl")
    line = Choice(port="/dev/ttyUSB0", driver="solartrak")
    assert continuing(saved, line) == replace_struct(line, session=str(saved.path))
    assert continuing(saved, None) is None
    by_hand = continuing(replace(saved, typed=True), None)
    assert by_hand == Choice(driver="typed", session=str(saved.path))


def test_an_unfinished_session_of_the_unit_at_its_place_is_offered(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path))
    lines = (SESSIONS / "azel-good-day.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "left.jsonl").write_bytes(b"".join(lines[:8]))
    (tmp_path / "closed.jsonl").write_bytes(b"".join(lines))
    (tmp_path / "damaged.jsonl").write_bytes(b"".join(lines[:8])[:-40] + b"\n" + lines[8])
    unit = read_session(tmp_path / "left.jsonl").header.unit
    mount = (unit.model, unit.serial, "azel")
    (left,) = saved_sessions.unfinished_sessions(*mount, unit.site, None)
    assert left.path == tmp_path / "left.jsonl"
    near = replace_struct(unit.site, longitude_deg=unit.site.longitude_deg + 360.0)
    assert len(saved_sessions.unfinished_sessions(*mount, near, None)) == 1
    for name in ("latitude_deg", "longitude_deg"):
        away = replace_struct(unit.site, **{name: getattr(unit.site, name) + 0.1})
        assert saved_sessions.unfinished_sessions(*mount, away, None) == []
    assert saved_sessions.unfinished_sessions(unit.model, "2", "azel", unit.site, None) == []
    target = Target(10.0, 80.0, 50.0)
    assert saved_sessions.unfinished_sessions(*mount, unit.site, target) == []
