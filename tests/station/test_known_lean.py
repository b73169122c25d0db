"""A lean read on the tower and the unit's last coefficients: known to every fit of a session."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from emulated_station import emulated_station

from solarcal.model.mechanism_solution import MechanismSolution, base_tilt
from solarcal.model.methods import DEFAULT_PRIOR
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import MountGeometry
from solarcal.session.journal import Journal
from solarcal.session.view import read_session, view_session
from solarcal.site import BoltCircle, Inclinometer
from solarcal.station.analysing import analyse_files, analyse_session, read_files
from solarcal.station.fitting import last_doubts, prior_of, solve
from solarcal.station.procedure import Station
from solarcal.station.technician import AutomaticTechnician, Schedule

SESSIONS = Path(__file__).parents[2] / "sessions"
READ = Inclinometer(lean_north_deg=0.6, lean_east_deg=-0.25, sigma_deg=0.02)


def header_with(reading, geometry="azel"):
    station, _ = emulated_station("tijeras-azel")
    return msgspec.structs.replace(
        station.session.header, inclinometer=reading, geometry=geometry, ax1_centre_deg=0.0
    )


def test_without_a_reading_the_prior_is_the_usual_one():
    assert prior_of(header_with(None)) == prior_of(None) == DEFAULT_PRIOR


def test_on_azel_the_reading_is_P1_and_P3_themselves():
    prior = prior_of(header_with(READ))
    assert (prior.means[0], prior.means[2]) == pytest.approx((0.6, -0.25))
    assert (prior.sigmas[0], prior.sigmas[2]) == pytest.approx((0.02, 0.02))
    assert prior.sigmas[1] == DEFAULT_PRIOR.sigmas[1]


@pytest.mark.parametrize("geometry", ["tiltroll-ew", "tiltroll-ns", "polar"])
def test_on_other_mounts_a_turned_base_stays_unknown(geometry):
    header = header_with(READ, geometry)
    prior = prior_of(header)
    assert max(prior.sigmas[0], prior.sigmas[2]) > 1.0
    assert min(prior.sigmas[0], prior.sigmas[2]) == pytest.approx(0.02)
    # Whatever P1 and P3 say about the base, its known component is the one read.
    stands = base_tilt(prior.mean_array(), MountGeometry(geometry, header.site.latitude_deg, 0.0))
    bearing = math.radians(stands.bearing_deg)
    tilt = stands.tilt_deg * np.array([math.cos(bearing), math.sin(bearing)])
    read = np.array([READ.lean_north_deg, READ.lean_east_deg])
    assert (np.abs(tilt - read) < 1e-9).any()


def replayed_after_one_point(path, **beforehand):
    """The live solution of a day's first point, and the session as it is read back."""
    plain, _ = emulated_station("tijeras-azel")
    station = Station(plain.tracker, plain.clock, **beforehand)
    station.connect()
    station.open_session(lambda header: Journal.create(path, header))
    technician = AutomaticTechnician(station, plain.tracker.emulation.spot, Schedule(points=1))
    technician.prepare()
    technician.take_point()
    live = solve(station.session)
    assert isinstance(live, MechanismSolution)
    station.leave()
    saved = read_session(path)
    view = view_session(saved.header, saved.records)
    replayed, judged = solve(view), analyse_session(view)
    assert replayed is not None
    assert judged is not None
    assert (replayed.values == live.values).all()
    assert (judged.solution.values == live.values).all()
    return live, view


def test_a_replay_fits_and_judges_with_the_reading_of_the_header(tmp_path):
    live, view = replayed_after_one_point(tmp_path / "day.jsonl", inclinometer=READ)
    assert live.posterior.mean[0] == pytest.approx(0.6, abs=0.05)
    assert view.header.inclinometer == READ


def test_a_replay_fits_and_judges_with_the_last_coefficients_of_the_header(tmp_path):
    last = (0.27, -0.3, 0.5, 0.2, 0.0007, -0.0001)
    path = tmp_path / "day.jsonl"
    live, view = replayed_after_one_point(
        path, last_coefficients=last, bolt_circle=BoltCircle(400.0, 4)
    )
    assert view.header.last_coefficients.as_tuple() == last
    assert live.prior.last == view.header.last_coefficients
    judged = analyse_session(view)
    assert judged.solution.sigmas[0] < 0.31
    assert len(judged.verdict.shims) == 4
    # The same from the file, and another answer where the command names others.
    files = read_files([path], {})
    assert (analyse_files(files).solution.values == live.values).all()
    wrong = analyse_files(files, last_coefficients=Coefficients(P1=-6.0))
    assert wrong.solution.prior == DEFAULT_PRIOR
    assert [f.kind for f in wrong.findings if f.direct][-1] == "last_coefficients"


def test_last_coefficients_the_points_contradict_are_reported_wherever_the_fit_is_shown(tmp_path):
    near = (0.27, -0.3, 0.5, 0.2, 0.0007, -0.0001)
    live, view = replayed_after_one_point(tmp_path / "near.jsonl", last_coefficients=near)
    assert last_doubts(view, live) == ()
    far = (-6.0, 0.0, 6.0, 0.0, 0.0, 0.0)
    live, view = replayed_after_one_point(tmp_path / "far.jsonl", last_coefficients=far)
    assert live.prior == DEFAULT_PRIOR
    (sentence,) = last_doubts(view, live)
    assert sentence in analyse_session(view).verdict.reasons


@pytest.mark.parametrize(
    ("read", "fits"),
    [
        (Inclinometer(lean_north_deg=0.28, lean_east_deg=0.53, sigma_deg=0.02), True),
        # North and east exchanged, both signs wrong, a reading of another tower.
        (Inclinometer(lean_north_deg=0.53, lean_east_deg=0.28, sigma_deg=0.02), False),
        (Inclinometer(lean_north_deg=-0.28, lean_east_deg=-0.53, sigma_deg=0.05), False),
        (Inclinometer(lean_north_deg=3.0, lean_east_deg=-2.0, sigma_deg=0.01), False),
    ],
)
def test_a_reading_that_the_points_contradict_is_named_and_not_used(read, fits):
    day = read_session(SESSIONS / "azel-good-day.jsonl")
    alone = analyse_session(day)
    told = view_session(msgspec.structs.replace(day.header, inclinometer=read), day.records)
    judged = analyse_session(told)
    assert judged.verdict.state == "done"
    named = [f for f in judged.findings if f.kind == "inclinometer"]
    assert (named == []) == fits
    assert last_doubts(told, judged.solution) == tuple(f.sentence for f in named)
    if fits:
        assert judged.solution.sigmas[0] < alone.solution.sigmas[0]
    else:
        assert (judged.solution.values == alone.solution.values).all()
        by_it = f"P1 {read.lean_north_deg:+.3f} and P3 {read.lean_east_deg:+.3f} deg by it"
        assert by_it in named[0].sentence
        assert named[0].sentence in judged.verdict.reasons
