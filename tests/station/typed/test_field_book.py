"""A field book: its lines, what is wrong with one, and the calibration it holds."""

from pathlib import Path

import numpy as np
import pytest
from hand_bench import MORNING, MOUNT, SITE, displayed, unit_model
from reads_a_display import HandReader, with_slips

from solarcal.errors import InputFileError, ProcedureRefused
from solarcal.mount.formula import correction_deg
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import Closed, PointRecord, Typed
from solarcal.session.view import read_session
from solarcal.station.fitting import solve
from solarcal.station.typed.field_book import STEPS, read_entries
from solarcal.station.typed.field_book_calibration import HandCalibration, calibrate_by_book

OPEN = ["2026-06-03", "16:00:00 open clock 09:00:00"]
PROFILE = Profile(name="by-hand", driver="typed", site=SITE, mount=MOUNT)


def perform(*lines: str) -> HandCalibration:
    return calibrate_by_book([*OPEN, *lines], "day.book", PROFILE, Journal.memory)


def shown(at_s: float, o1: float = -0.5, o2: float = 0.2) -> str:
    texts = displayed(unit_model(), at_s, o1, o2)
    return " ".join(f"{name} {text}" for name, text in texts.items())


# -- lines -------------------------------------------------------------------------------------


def test_a_line_is_a_time_a_step_its_answers_and_values_in_any_order() -> None:
    (entry,) = read_entries(
        ["# a day", "2026-06-03", "", "16:00:10 point YES y no  # the spot moved"], "b"
    )
    assert (entry.where, entry.utc_s, entry.step) == ("b:4", MORNING + 10.0, "point")
    assert entry.answers == (True, True, False)
    (entry,) = read_entries(
        ["2026-06-03T16:00:10Z point yes yes yes o1 -0,5 AX1 81.2 reject the spot moved"], "b"
    )
    assert entry.values == {"o1": "-0,5", "ax1": "81.2"}
    assert (entry.stores, entry.reason) == (False, "the spot moved")
    for stored, stores in (("", None), ("store ", True)):
        line = f"2026-06-03T16:00:10Z point yes yes yes {stored}because near the limit"
        (entry,) = read_entries([line], "b")
        assert (entry.stores, entry.reason) == (stores, "near the limit")


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("15:59:59 clock clock 08:59:59", "is before the line above"),
        ("16:01 clock", "'16:01' is not a time like 15:30:05"),
        ("16:01:00", "a step is missing"),
        ("16:01:00 jump", "'jump' is not a step; the steps are: open, clock"),
        ("16:01:00 jump up", "'jump' is not a step"),
        ("16:01:00 offset ax3 1", "'ax3' is not the name of a value"),
        ("16:01:00 offset ax1", "ax1 has no value"),
        ("16:01:00 offset ax1 1 ax1 2", "ax1 is given twice"),
        ("16:01:00 point yes yes yes ax1 1 reject", "reject what?"),
        ("16:01:00 offset ax1 x ax2 1 o1 0 o2 0", "ax1: AX1, read-out: 'x' is not a number"),
        ("16:01:00 offset ax1 1 o1 0 o2 0", "ax2: AX2, read-out: is missing"),
        ("16:01:00 offset found1 1", "found1 is not asked for here; offset takes"),
        ("16:01:00 zero o1 0 o2 0", "nothing above needs a line `zero`"),
        ("16:01:00 void twelve", "void which record, and why?"),
        ("16:01:00 void twelve it had moved", "void which record, and why?"),
        ("16:01:00 void 12", "void which record, and why?"),
        ("2026-13-03", "is not a date"),
    ],
)  # fmt: skip
def test_a_line_that_cannot_be_is_named(line: str, wrong: str) -> None:
    with pytest.raises(InputFileError, match=r"^day\.book:3: ") as refused:
        perform(line)
    assert wrong in str(refused.value)


def test_the_example_of_the_page_is_a_book() -> None:
    page = (Path(__file__).parents[3] / "docs" / "by-hand.md").read_text(encoding="utf-8")
    example = next(part for part in page.split("```") if part.startswith("\n2026-06-03"))
    entries = list(read_entries(example.splitlines(), "by-hand.md"))
    assert [entry.step for entry in entries][:4] == ["open", "clock", "reference", "initialise"]
    assert [step for step in STEPS if f"`{step}" not in page] == []


def test_a_time_needs_a_day() -> None:
    with pytest.raises(InputFileError, match="b:1: which day"):
        list(read_entries(["16:00:00 open"], "b"))


def test_an_empty_book_says_what_it_must_begin_with() -> None:
    with pytest.raises(InputFileError, match=r"in empty\.book a line `open` is missing"):
        calibrate_by_book([], "empty.book", PROFILE, Journal.memory)


def test_a_doubted_line_needs_to_be_corrected_or_kept() -> None:
    wrong = shown(MORNING + 60.0).replace("o1 -", "o1 +")
    with pytest.raises(InputFileError, match=r"day\.book:3: O1 typed \+0\.500, the sign") as said:
        perform(f"16:01:00 offset {wrong}")
    assert "`again` with the right values, or `keep` and a reason" in str(said.value)


def test_again_puts_it_right_and_the_first_typing_stays_in_the_record() -> None:
    wrong = shown(MORNING + 60.0).replace("o1 -", "o1 +")
    session = perform(f"16:01:00 offset {wrong}", "16:01:20 again o1 -0.500").session
    record = next(r for r in session.records if isinstance(r, Typed) and r.form == "offset")
    assert record.values["o1"] == "-0.500"
    assert [before["o1"] for before in record.corrected] == ["+0.500"]
    assert session.sun_offsets[0].offsets.O1 == -0.5
    # The look was the first one; only its typing was wrong.
    assert session.sun_offsets[0].read_utc == "2026-06-03T16:01:00.000Z"


def test_keep_lets_it_stand_with_the_doubt_in_the_record() -> None:
    wrong = shown(MORNING + 60.0).replace("o1 -", "o1 +")
    session = perform(f"16:01:00 offset {wrong}", "16:01:20 keep read twice").session
    record = next(r for r in session.records if isinstance(r, Typed) and r.form == "offset")
    assert record.kept[0].endswith("(read twice)")
    assert session.sun_offsets[0].offsets.O1 == 0.5


def test_a_step_the_procedure_refuses_names_its_line() -> None:
    with pytest.raises(ProcedureRefused, match=r"^day\.book:3: initialise the data file first"):
        perform("16:01:00 point yes yes yes")


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        ("yes yes", "answer the three questions"),
        ("yes yes yes ax1 1 ax2 2 o1 0 o2 0", "store it or not?"),
    ],
)
def test_a_point_is_answered_and_decided(words: str, wrong: str) -> None:
    with pytest.raises(InputFileError, match=r"^day\.book:4: .*" + wrong.replace("?", r"\?")):
        perform("16:01:00 initialise", f"16:02:00 point {words}")


def test_the_first_no_ends_the_attempt_and_nothing_is_asked() -> None:
    session = perform("16:01:00 initialise", "16:02:00 point yes no").session
    assert [p.status for p in session.points] == ["aborted"]
    assert session.points[0].answers.tracking is None


def test_a_rejected_point_keeps_why() -> None:
    session = perform(
        "16:01:00 initialise",
        f"16:01:30 offset {shown(MORNING + 90.0)}",
        f"16:03:00 point yes yes yes {shown(MORNING + 180.0)} reject a gust",
    ).session
    assert [(p.status, p.reason) for p in session.points] == [("rejected", "a gust")]


# -- a whole day -------------------------------------------------------------------------------


class Day:
    """An emulated day written down, calibrated from what was written, keyed in and proven."""

    def __init__(self, folder: Path) -> None:
        self.reader = HandReader(points=6, every_min=105.0)
        self.reader.take_points()
        self.before_upload = self.reader.book.text()
        self.unfinished_path = folder / "unfinished.jsonl"
        self.unfinished = self.calibrate(self.before_upload, self.unfinished_path)
        assert self.unfinished.proposal is not None
        self.truth = self.reader.upload_and_check(self.unfinished.proposal.rounded)
        self.text = self.reader.book.text()
        self.path = folder / "day.jsonl"
        self.done = self.calibrate(self.text, self.path)

    def calibrate(self, text: str, path: Path) -> HandCalibration:
        return calibrate_by_book(
            text.splitlines(),
            "day.book",
            self.reader.profile,
            lambda header: Journal.create(path, header),
        )


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Day:
    return Day(tmp_path_factory.mktemp("day"))


def test_the_written_day_recovers_the_hidden_truth(day: Day) -> None:
    assert day.done.completed
    assert len(day.done.session.accepted) == 6
    # Points whose error is 0.9 deg; a display of a hundredth, an eye of the same.
    assert day.truth.day_rms_deg < 0.04
    assert day.truth.year_rms_deg < 0.05
    # What was fitted after each point stored is kept: the history of the coefficients.
    assert [fit.points for fit in day.done.session.fits] == [1, 2, 3, 4, 5, 6]
    left = [check.sky_error_deg for check in day.done.session.checks]
    assert len(left) == 2
    assert all(one is not None and one < 0.06 for one in left)


def test_a_display_of_counts_gives_the_same_errors_as_the_wire() -> None:
    reader = HandReader(points=2, every_min=60.0, counts=True)
    reader.take_points()
    lines = reader.book.text().splitlines()
    by_hand = calibrate_by_book(lines, "day.book", reader.profile, Journal.memory).session
    pairs = list(zip(by_hand.accepted, reader.station.session.accepted, strict=True))
    assert len(pairs) == 2
    for hand, wire in pairs:
        assert hand.counts == wire.counts
        assert hand.error_deg == pytest.approx(wire.error_deg, abs=0.0006)


def test_by_hand_or_by_wire_the_correction_is_the_same(day: Day) -> None:
    by_wire = day.reader.station.session
    fits = [solve(session) for session in (day.done.session, by_wire)]
    at = by_wire.geometry.axes_from_horizontal(np.linspace(90.0, 270.0, 13), np.full(13, 40.0))
    e_hand, e_wire = (
        np.array(correction_deg(fit.coefficients(), *at)) for fit in fits if fit is not None
    )
    # Half a unit of the last digit of O moves it by no more.
    assert np.abs(e_hand - e_wire).max() < 0.005


def test_slips_put_right_and_attempts_given_up_change_nothing_that_is_fitted(
    day: Day, tmp_path: Path
) -> None:
    slipped = day.calibrate(with_slips(day.before_upload), tmp_path / "slipped.jsonl").session
    errors = [point.error_deg for point in slipped.accepted]
    assert errors == [point.error_deg for point in day.done.session.accepted]
    assert [p.status for p in slipped.points].count("aborted") == 1
    corrected = [r for r in slipped.records if isinstance(r, Typed) and r.corrected]
    assert [record.form for record in corrected] == ["offset", "point"]


def test_the_same_book_gives_the_same_file_byte_for_byte(day: Day, tmp_path: Path) -> None:
    day.calibrate(day.before_upload, tmp_path / "again.jsonl")
    assert (tmp_path / "again.jsonl").read_bytes() == day.unfinished_path.read_bytes()


def test_a_longer_book_begins_as_the_shorter_one_did(day: Day) -> None:
    assert day.path.read_bytes().startswith(day.unfinished_path.read_bytes())
    records = read_session(day.path).records
    assert isinstance(records[-1], Closed)
    assert [r.status for r in records if isinstance(r, PointRecord)] == ["accepted"] * 6


def test_a_book_that_ends_before_the_upload_says_what_to_key_in_and_stays_open(day: Day) -> None:
    assert (day.unfinished.completed, day.unfinished.upload) == (False, None)
    names = [name for name, _ in day.unfinished.key_in]
    assert names == ["P1", "P2", "P3", "P4", "P5", "P6", "O1", "O2"]
    assert not isinstance(read_session(day.unfinished_path).records[-1], Closed)


def test_typed_back_otherwise_it_is_not_completed(day: Day, tmp_path: Path) -> None:
    upload = next(line for line in day.text.splitlines() if " upload " in line)
    wrong = upload.replace("stored yes", "stored no")
    text = f"{day.before_upload}{wrong}\n{upload.split()[0]} keep\n"
    done = day.calibrate(text, tmp_path / "wrong.jsonl")
    assert done.upload is not None
    assert not done.completed
