"""The page on the library: every example runs and prints what the page shows; lazily imported."""

import contextlib
import io
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import solarcal

ROOT = Path(__file__).parents[2]
EXAMPLE = re.compile(r"```python\n(.*?)```\n\n```\n(.*?)```", re.DOTALL)
EXAMPLES = EXAMPLE.findall((ROOT / "docs" / "library.md").read_text(encoding="utf-8"))


def test_there_are_five():
    assert len(EXAMPLES) == 5


@pytest.mark.parametrize(("code", "shown"), EXAMPLES, ids=range(1, len(EXAMPLES) + 1))
def test_an_example_prints_what_the_page_shows(code, shown, monkeypatch):
    monkeypatch.chdir(ROOT)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert printed.getvalue() == shown


def test_every_name_offered_is_there_and_no_other():
    from solarcal import library

    assert set(library.__all__) == set(solarcal._OFFERED)
    for name in solarcal._OFFERED:
        assert getattr(solarcal, name) is getattr(library, name)
        assert name in dir(solarcal)
    with pytest.raises(AttributeError, match="no attribute 'calibrate'"):
        _ = solarcal.calibrate


def test_points_of_ones_own_are_judged_at_a_site():
    mount = solarcal.MountGeometry("azel", 35.05)
    ax1, ax2 = [-60.0, -20.0, 20.0, 60.0], [50.0, 25.0, 25.0, 50.0]
    err = [0.1, 0.1, 0.1, 0.1]
    points = solarcal.Points(geometry=mount, ax1_deg=ax1, ax2_deg=ax2, err1_deg=err, err2_deg=err)
    with pytest.raises(Exception, match="need a site"):
        solarcal.analyse(points)
    assert solarcal.forecast(points, site=solarcal.Site(35.05, -106.48)).year_rms_deg > 0.0


def test_a_day_south_of_the_equator_is_of_one_piece_and_judged_by_the_tolerance_asked_for():
    """AX1 from 80 to 280 deg; without times, too, and where the centre given parts it, that is
    said: P2 and P5 of two calibrations would be taken for one."""
    site = solarcal.Site(-33.9, 151.2)
    utc_s = 1795471200.0 + 2400.0 * np.arange(14)
    sun = solarcal.sun_position("precise", utc_s, site, refraction="hughes")
    true = solarcal.Mechanism(P1=0.3, P2=-0.4, P3=0.5, P4=0.2, P5=0.0007)
    ax1, ax2 = solarcal.MountGeometry("azel", -33.9).axes_from_horizontal(
        sun.azimuth_deg, sun.zenith_deg
    )
    err1, err2 = true.errors_deg(solarcal.MountGeometry("azel", -33.9), ax1, ax2)
    noise = 0.02 * np.random.default_rng(4).standard_normal((2, 14))

    def judged(*centre_deg, **asked):
        points = solarcal.Points(
            geometry=solarcal.MountGeometry("azel", -33.9, *centre_deg), ax1_deg=ax1, ax2_deg=ax2,
            err1_deg=err1 + noise[0] / np.sin(np.radians(ax2)), err2_deg=err2 + noise[1],
        )  # fmt: skip
        return solarcal.analyse(points, site=site, **asked)

    found = judged()
    assert abs(found.solution.coefficients().P2 + 0.4) < 0.05
    assert found.verdict.state == "done"
    assert judged(tolerance_deg=0.002).verdict.state == "continue"
    parted = judged(0.0)
    assert parted.verdict.state != "done"
    assert any("beyond the end of axis 1's branch" in f.sentence for f in parted.findings)


@pytest.mark.parametrize(("ideal", "late_s", "kind"), [
    ("apparent", 0.0, None), ("airless", 0.0, None),
    ("apparent", 3600.0, "time_stamps"), ("airless", -3600.0, "time_stamps"),
])  # fmt: skip
def test_points_of_ones_own_are_compared_with_the_sun(ideal, late_s, kind):
    mount, site = solarcal.MountGeometry("azel", 35.05), solarcal.Site(35.05, -106.48)
    utc_s = 1782052800.0 + 3600.0 * np.arange(8)
    refraction = "hughes" if ideal == "apparent" else "none"
    sun = solarcal.sun_position("precise", utc_s, site, refraction=refraction)
    ax1, ax2 = mount.axes_from_horizontal(sun.azimuth_deg, sun.zenith_deg)
    err1, err2 = solarcal.Mechanism(P1=0.3).errors_deg(mount, ax1, ax2)
    points = solarcal.Points(
        geometry=mount, ax1_deg=ax1, ax2_deg=ax2, err1_deg=err1, err2_deg=err2,
        utc_s=utc_s + late_s,
    )  # fmt: skip
    analysis = solarcal.analyse(points, site=site, ideal=ideal)
    found = [f.kind for f in analysis.findings if f.certainty == "found"]
    assert found == ([kind] if kind else [])
    assert (analysis.verdict.state == "does_not_fit") == bool(kind)


def test_importing_the_package_imports_nothing_else():
    code = "import sys, solarcal; print(*(m for m in sys.modules if m in ('numpy', 'scipy')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
