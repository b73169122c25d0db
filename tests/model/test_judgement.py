"""One call from points to verdict, and the limits of the years the Sun is known for."""

import json

import numpy as np
import pytest
from made_up_trackers import context_of, day_of

from solarcal.errors import ConfigurationError, SolarcalError
from solarcal.model.analysis import analyse
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext, sun_directions
from solarcal.mount.geometry import GEOMETRIES, MountGeometry


def test_fit_forecast_plan_and_verdict_in_one_document():
    context, points = day_of("azel", 8)
    whole = analyse(points.subset([0, 1, 2, 3]), context, at_utc_s=float(points.utc_s[4]))
    document = json.loads(json.dumps(whole.as_json()))
    keys = {"coefficients", "mechanism", "forecast", "verdict", "plan"}
    assert keys <= set(document)
    assert document["verdict"]["state"] == "continue"
    assert document["forecast"]["year_p95_deg"] > 0.1


def test_a_day_without_hope_is_called_so():
    context, points = day_of("tiltroll-ew", 12, day=1)
    used = points.subset(list(range(9)))
    whole = analyse(used, context, at_utc_s=float(points.utc_s[9]))
    assert not whole.plan.reaches
    assert whole.verdict.state == "not_today"
    assert whole.verdict.reasons[0] == whole.plan.sentence
    assert "come back" in whole.verdict.reasons[0]


def test_without_a_time_nothing_is_planned():
    context, points = day_of("azel", 8)
    whole = analyse(points, context)
    assert whole.plan is None
    assert "plan" not in whole.as_json()


def test_manual_is_judged_and_planned_too():
    context, points = day_of("azel", 8)
    used = points.subset([0, 1, 2, 3])
    at = float(points.utc_s[4])
    manual = analyse(used, context, method="linear", at_utc_s=at)
    robust = analyse(used, context, at_utc_s=at)
    assert manual.plan.now.year_p95_deg > robust.plan.now.year_p95_deg
    assert manual.verdict.state in ("continue", "not_today")


# erfa remarks on nodes beyond 2100, where it is good to a milliarcsecond still.
@pytest.mark.filterwarnings("ignore:ERFA function")
def test_the_sun_is_known_to_the_ends_of_its_years_and_refused_beyond():
    context = context_of("azel")
    for moment, known in (("1960-01-02", True), ("2100-02-27", True), ("2101-01-01", False)):
        times = np.array([float(np.datetime64(moment, "s").astype(int))])
        if known:
            assert np.isfinite(sun_directions(context, times).true2_deg).all()
        else:
            with pytest.raises(ConfigurationError):
                sun_directions(context, times)


def test_odd_points_get_an_answer_or_one_line():
    """Whatever the errors, sigmas and numbers: finite JSON, or an error meant for the user."""
    rng = np.random.default_rng(8)
    answered = 0
    for _ in range(60):
        geometry = MountGeometry(
            str(rng.choice(GEOMETRIES)), float(rng.choice([-35, 20, 66])), 90.0
        )
        n = int(rng.integers(1, 7))
        err1, err2 = np.clip(10.0 ** rng.uniform(-3, 2.2) * rng.standard_normal((2, n)), -170, 170)
        points = Points(
            geometry=geometry,
            ax1_deg=rng.uniform(0.0, 180.0, n),
            ax2_deg=rng.uniform(1.0, 80.0, n),
            err1_deg=err1,
            err2_deg=err2,
            sigma_deg=None if rng.random() < 0.5 else np.full(n, 10.0 ** rng.uniform(-4, 1)),
            utc_s=1.78e9 + 1800.0 * np.arange(n),
        )
        method = str(rng.choice(["robust", "exact"]))
        try:
            whole = analyse(
                points, SkyContext.for_points(points), method=method, at_utc_s=1.78e9 + 1800.0 * n
            )
        except SolarcalError:
            continue
        json.dumps(whole.as_json(), allow_nan=False)
        answered += 1
    assert answered > 40
