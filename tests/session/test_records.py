"""What a record is beside its fields: made by their names, and what it holds when nobody says."""

import inspect

import pytest
from session_samples import HEADER, UTC, point

from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session import records
from solarcal.session.records import FitRecord, LinkRestored, Record, UploadBegun, UploadRecord
from solarcal.session.view import view_session


def test_records_are_made_by_the_names_of_their_fields() -> None:
    for _, one in inspect.getmembers(records, inspect.isclass):
        if getattr(one, "__struct_config__", None) is not None and one.__struct_config__.tag:
            named = inspect.signature(one).parameters.values()
            assert {field.kind for field in named} == {inspect.Parameter.KEYWORD_ONLY}, one


def test_what_a_header_and_an_upload_say_when_nobody_says_otherwise() -> None:
    assert (HEADER.tolerance_deg, HEADER.done_probability) == (0.1, 0.95)
    assert (HEADER.sun_model, HEADER.refraction, HEADER.true_sun) == (
        "solartrak",
        "none",
        "precise",
    )
    upload = UploadRecord(
        seq=1,
        utc=UTC,
        old_coefficients=Coefficients(),
        old_offsets=Offsets(),
        new_coefficients=Coefficients(P1=0.1),
        new_offsets=Offsets(),
        verified=True,
        method="robust",
    )
    assert (upload.rollback, upload.forced, upload.failure) == (False, "", "")
    begun = UploadBegun(
        seq=1,
        utc=UTC,
        old_coefficients=Coefficients(),
        old_offsets=Offsets(),
        new_coefficients=Coefficients(P1=0.1),
        new_offsets=Offsets(),
    )
    assert (begun.rollback, begun.forced) == (False, "")


def test_a_field_that_a_record_does_not_have_says_nothing() -> None:
    """A file of an older format lacks fields: nothing was seen, lost, doubted or forced."""
    assert LinkRestored(seq=1, utc=UTC, serial="0001").losses == 0
    empty = ("", None, 0, False, ())
    for _, one in inspect.getmembers(records, inspect.isclass):
        if getattr(one, "__struct_config__", None) is None or not one.__struct_config__.tag:
            continue
        for field in inspect.signature(one).parameters.values():
            default = field.default
            if one is records.Header or default is inspect.Parameter.empty:
                continue
            # What every check and fit of the first format was.
            old = {"at_switches": True, "method": "linear"}.get(field.name)
            assert default == old if old is not None else default in empty, (one, field.name)


@pytest.mark.parametrize(
    ("fit_seq", "points", "recorded"),
    [(3, 2, False), (5, 2, True), (5, 1, False), (None, 0, False)],
)
def test_a_fit_is_recorded_when_it_is_newer_than_the_last_point_and_of_all(
    fit_seq: int | None, points: int, recorded: bool
) -> None:
    found: list[Record] = [point(1), point(4)]
    if fit_seq is not None:
        found.append(
            FitRecord(
                seq=fit_seq,
                utc=UTC,
                method="robust",
                points=points,
                coefficients=Coefficients(),
                sigmas=None,
                sky_rms_deg=0.0,
            )
        )
    session = view_session(HEADER, tuple(sorted(found, key=lambda record: record.seq)))
    assert session.fit_recorded == recorded
    assert view_session(HEADER, ()).fit_recorded
