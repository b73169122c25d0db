"""The field calculators of the workstation: every number of the physics document they can show."""

import math

import numpy as np
import pytest
from golden_screens import shows_golden
from procedure_bench import LARGE, SMALL, plain_start, screen_text, screen_words, shows, until
from textual.widgets import OptionList

from solarcal.config import Settings, load_settings
from solarcal.instruments.catalogue import BY_ID, INSTRUMENTS
from solarcal.instruments.form import FormError
from solarcal.profiles import Profile
from solarcal.site import Site
from solarcal.tui.app import SolarcalApp
from solarcal.tui.calculators import CalculatorScreen, CalculatorsScreen, open_calculator
from solarcal.tui.widgets.form_rows import ChoiceBox, FormRow

TIJERAS = Profile(site=Site(35.05, -106.48, 1900.0, "Tijeras"))
JUNE = "2026-06-10T17:00:00Z"


def app_with(profile=TIJERAS, settings=None, remember=False):
    return plain_start(profile=profile, settings=settings, remember=remember)


async def opened(app, pilot, name, **typed):
    """The calculator's screen, with these texts typed and computed."""
    open_calculator(app, BY_ID[name])
    await until(pilot, lambda: isinstance(app.screen, CalculatorScreen) and rows(app))
    if typed:
        for row in rows(app):
            if row.field.name in typed:
                row.fill(typed[row.field.name])
        app.screen.action_compute()
    return app.screen


def rows(app):
    return list(app.screen.query(FormRow))


def drawn(path, *circles):
    """A picture of circles (x, y, radius, brightness), each drawn over those before it."""
    rows, columns = np.mgrid[:140, :160]
    image = np.full(rows.shape, 0.1)
    for x, y, radius, brightness in circles:
        part = np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0.0, 1.0)
        image += (brightness - image) * part
    path.write_bytes(b"P5 160 140 255\n" + np.round(255 * image).astype(np.uint8).tobytes())


NUMBERS = [
    # Section 6: three feet at eight hundred.
    ("heliostat-shift", {}, ["0.2149 deg"]),
    # Section 6: phi 22.5 deg, d/r 5; both roots, and where the normal stands.
    ("heliostat-circle", {}, ["12.489466", "10.010534", "10.232014", "12.267986"]),
    # Section 6: the normal stands half-way, gamma/2 from the target.
    ("heliostat-aim", {}, ["zenith angle  60.0000", "incidence 20.0000 deg"]),
    ("heliostat-target", {"seen1": "180 40 180 60"}, ["180.0000  zenith angle  80.0000"]),
    ("heliostat-drift", {"at": JUNE}, ["Without correction", "first order"]),
    # Section 6: M(0, 0) = I; to first order gamma = P3, beta = P1.
    ("mirrors-point", {"sun": "180 0"}, ["+1.000000 +0.000000 +0.000000"]),
    ("mirrors-trace", {}, ["0.000 mrad off", "axis 1 +0.00000 deg"]),
    # Section 6: 6 mm at 200 mm 30 mrad, 10 cm at 5 m 20 mrad; the Sun's 9 mrad.
    ("mirrors-fov", {}, ["29.99 mrad", "20.00 mrad", "tracker limits"]),
    # The disc stands 10 pixels beside the aim, each 4.65 mrad by 46.5 pixels.
    ("mirrors-camera", {"image": "sun.pgm"}, ["0.1000 mrad a pixel", "mrad off the aim"]),
    # Section 5: SJP2 = -2 R1 R2, SJP3 = R1^2 + R2^2 - R3^2.
    (
        "screwjack",
        {
            "R1": "30", "R2": "20", "R3": "1.5", "counts": "4000",
            **{
                f"at{n}": f"{s} {math.sqrt(1297.75 - 1200 * math.cos(math.radians(s + 90)))}"
                for n, s in ((1, -40), (2, 35))
            },
        },
        ["90.0000 deg", "-1200.0000", "1297.7500", "-90.000 and 90.000", "counts a degree"],
    ),
    # Section 5: error = atan((E - (Rs - Ro))/F), F = 2H: 1 mm in 1 m.
    ("sunspot", {"edge": "5.5"}, ["+0.0573 deg", "4.5 on every side"]),
    ("sunspot-design", {}, ["resolution", "deg"]),
    # The spot of 13 moved by 0.5 to the right of the hole of 4: E = 4.5 + 0.5.
    ("sunspot-picture", {"image": "plate.pgm"}, ["E to the right", "error to the right"]),
    ("sun", {"at": JUNE}, ["azimuth", "AX2 (azel)", "solar time"]),
    ("sun-compare", {"from_year": "2010", "to_year": "2010"}, ["altitude", "azimuth on sky"]),
    # 120 deg of swing is about eight hours in summer (15 deg an hour of a polar mount).
    ("day", {"at": JUNE, "geometry": "polar", "limits1": "-60 60"}, ["8.001 h within", "sunrise"]),
    ("year", {"year": "2026", "collector": "tracking"}, ["2026-06-21", "whole year"]),
    # Section 4, SUNCALC's own question.
    (
        "energy", {},
        ["71.449641", "94.804440 %", "36.694840 %", "15.065298 h", "4.467351 h", "19.532649",
         "32.376807", "N -0.318138  E +0.000000  U +0.948044"],
    ),
]  # fmt: skip


def test_every_calculator_is_among_these():
    assert sorted(name for name, _, _ in NUMBERS) == sorted(BY_ID)


@pytest.mark.parametrize(("name", "typed", "said"), NUMBERS, ids=[n for n, _, _ in NUMBERS])
async def test_form_in_result_and_drawing_out(name, typed, said, tmp_path):
    app = app_with()
    drawn(tmp_path / "sun.pgm", (89.5, 69.5, 46.5, 0.9))
    drawn(tmp_path / "plate.pgm", (84.0, 70.0, 52.0, 0.9), (80.0, 70.0, 16.0, 0.1))
    if "image" in typed:
        typed = {"image": str(tmp_path / typed["image"])}
    async with app.run_test(size=SMALL) as pilot:
        screen = await opened(app, pilot, name, **typed)
        await until(
            pilot,
            lambda: (
                screen.answer is not None
                and all(word in "\n".join(screen.answer.lines) for word in said)
            ),
        )
        heading = screen.answer.lines[0].strip()[:30]
        await until(pilot, lambda: all(w in screen_text(app) for w in ("┌", "STOP", heading)))
        text = screen_text(app)
        assert len(text.split("\n")) == SMALL[1]
        assert "no room for the plot" not in text


async def test_typing_computes_and_a_comma_is_a_decimal_point():
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "heliostat-circle")
        await shows(pilot, "12.489466")
        for _ in range(4):
            await pilot.press("backspace")
        await pilot.press("3", "0", ",", "0")
        await until(pilot, lambda: "12.489466" not in screen_words(app))
        await pilot.press("down", "down", "up", "enter")
        await until(pilot, lambda: app.screen.answer is not None)
        assert app.settings.calculators == {"heliostat-circle": {"angle": "30,0"}}


async def test_a_wrong_field_is_named_in_one_line_and_no_old_result_stays():
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "sunspot")
        await shows(pilot, "on every side")
        rows(app)[0].fill("1..5")
        await shows(pilot, "! H, plate to mirror: '1..5' is not a number", "no result")
        assert "on every side" not in screen_words(app)
        assert rows(app)[0].has_class("-wrong")
        rows(app)[0].fill("500")
        await shows(pilot, "on every side")
        assert not rows(app)[0].has_class("-wrong")


BAD = [
    ("heliostat-aim", {"sun": "90 95"}, "below the horizon"),
    ("heliostat-aim", {"azimpivot_r": "1"}, "Target distance is missing"),
    ("heliostat-aim", {"azimpivot_r": "1", "distance": "0.5"}, "behind the mirror"),
    ("heliostat-aim", {"sun": "", "lat": "", "geometry": "azel"}, "Latitude is missing"),
    ("heliostat-aim", {"geometry": "polar", "lat": ""}, "Latitude is missing"),
    ("heliostat-target", {}, "Sun, normal is missing"),
    ("heliostat-target", {"seen2": "1 2 3"}, "2: Sun, normal: write 4 numbers"),
    ("heliostat-drift", {"azimpivot_r": "0", "pivotrefl_z": "0", "lat": "1", "lon": "2"}, "drifts"),
    ("screwjack", {}, "R1, axis to pivot is missing"),
    ("screwjack", {"R1": "30", "R2": "20", "at1": "0 80"}, "cannot close"),
    ("screwjack", {"R1": "30", "R2": "20", "at1": "0 0"}, "greater than zero"),
    ("sunspot", {"height": "0"}, "height H"),
    ("sunspot-design", {"plate": "5"}, "too small"),
    ("mirrors-trace", {"a": "0", "b": "0", "c": "0", "d": "0"}, "no light on the diode"),
    ("mirrors-fov", {"focal": "0"}, "the focal length must be greater than zero"),
    ("day", {"lat": "91", "lon": "0"}, "Latitude: 91 is not between -90 and 90"),
    ("day", {"lat": "35", "lon": "0", "at": "soon"}, "Time (UTC): 'soon' is not a date"),
    ("day", {"lat": "35", "lon": "0", "limits1": "60 -60"}, "the lower one comes first"),
    ("energy", {"acceptance": "1"}, "Half acceptance: needs the error whose cost is computed"),
    ("energy", {"collector": "normal", "vector": ""}, "normal, axis: write North, East and Up"),
]


@pytest.mark.parametrize(("name", "typed", "said"), BAD)
def test_bad_input_is_one_clear_line(name, typed, said):
    from solarcal.errors import SolarcalError

    calculator = BY_ID[name]
    with pytest.raises(SolarcalError) as refused:
        calculator.answer(calculator.form(typed, 1_780_000_000.0))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "--" not in str(refused.value)


def test_a_field_error_knows_its_field():
    with pytest.raises(FormError) as refused:
        BY_ID["sunspot"].answer(BY_ID["sunspot"].form({"hole": ""}, 0.0))
    assert (refused.value.field, refused.value.missing) == ("hole", True)


def test_a_date_alone_is_the_sites_own_day():
    day = BY_ID["day"]
    typed = {"lat": "35.05", "lon": "-106.48", "at": "2026-06-21"}
    found = day.answer(day.form(typed, 0.0)).document
    assert found["transit_utc"].startswith("2026-06-21T19:07")
    east = day.answer(day.form(typed | {"lon": "170"}, 0.0)).document
    assert east["transit_utc"].startswith("2026-06-21T00:41")


async def test_values_are_remembered_and_defaults_come_back():
    app = app_with(remember=True)
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "sunspot", edge="6.5")
        await pilot.press("escape")
        await until(pilot, lambda: not isinstance(app.screen, CalculatorScreen))
        await until(pilot, lambda: load_settings().calculators == {"sunspot": {"edge": "6.5"}})
    again = app_with(settings=load_settings(), remember=True)
    async with again.run_test(size=SMALL) as pilot:
        await opened(again, pilot, "sunspot")
        assert [row.value for row in rows(again) if row.field.name == "edge"] == ["6.5"]
        await pilot.press("ctrl+r")
        await until(pilot, lambda: [r.value for r in rows(again)][3] == "4.5")
        await pilot.press("escape")
        await until(pilot, lambda: load_settings() == Settings())


async def test_the_place_comes_from_the_profile_and_follows_it():
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "sun")
        assert [row.value for row in rows(app)][:3] == ["35.05", "-106.48", "1900"]
        await pilot.press("escape")
        assert "sun" not in app.settings.calculators


async def test_without_a_place_it_asks_for_one_without_alarm():
    app = app_with(Profile())
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "day")
        await shows(pilot, "Latitude is missing; type it")
        assert not app.screen.query_one("#log").has_class("-error")


async def test_g_opens_the_list_and_enter_a_calculator():
    app = SolarcalApp(profile=TIJERAS)
    async with app.run_test(size=SMALL) as pilot:
        await shows(pilot, "g Calcs")
        await pilot.press("g")
        await until(pilot, lambda: isinstance(app.screen, CalculatorsScreen))
        await shows(pilot, "Screwjack", "Targeting", "Field of view", "Collector energy")
        choices = app.screen.query_one(OptionList)
        assert sum(not option.disabled for option in choices.options) == len(INSTRUMENTS)
        await pilot.press("enter")
        await shows(pilot, "The Sun: Sun position")
        await pilot.press("f11")
        await until(pilot, lambda: isinstance(app.screen, CalculatorsScreen))
        await pilot.press("f11", "escape")
        await until(pilot, lambda: not isinstance(app.screen, CalculatorsScreen))


async def test_letters_typed_in_a_field_fire_nothing_behind_it(monkeypatch):
    app, asked = app_with(), []
    async with app.run_test(size=SMALL) as pilot:
        screen = await opened(app, pilot, "sunspot")
        monkeypatch.setattr(SolarcalApp, "action_perform", lambda self, name: asked.append(name))
        await pilot.press("end", *"abcdefghijklmnopqrstuvwxyz.,+-?")
        await shows(pilot, "is not a number")
        assert rows(app)[0].value == "500abcdefghijklmnopqrstuvwxyz.,+-?"
        assert (asked, app.screen, screen._view) == ([], screen, 0)


async def test_stop_works_while_a_field_has_the_focus(monkeypatch):
    app, asked = app_with(), []
    async with app.run_test(size=SMALL) as pilot:
        await opened(app, pilot, "sunspot")
        monkeypatch.setattr(SolarcalApp, "action_perform", lambda self, name: asked.append(name))
        await pilot.press("f12", "ctrl+s")
        await pilot.click("StopKey")
        await until(pilot, lambda: asked == ["stop"] * 3)
        assert rows(app)[0].value == "500"


async def test_the_palette_knows_every_calculator():
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        await pilot.press("ctrl+p")
        await pilot.press(*"screwj")
        await shows(pilot, "Calculator: Drives and devices, Screwjack")
        await pilot.press("down", "enter")
        await shows(pilot, "SJP#1-3 from measured lengths")


async def test_views_enlarge_drawings_and_text():
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        screen = await opened(app, pilot, "heliostat-drift", at=JUNE)
        await until(pilot, lambda: screen.answer is not None)
        await pilot.press("ctrl+n")
        await shows(pilot, "beam from the target's middle")
        await until(pilot, lambda: screen.query_one("#drawing").size.width == SMALL[0])
        await pilot.press("v")
        await shows(pilot, "first order from exact")
        await pilot.press("v")
        await until(pilot, lambda: screen.has_class("-text"))
        await shows(pilot, "Corrected to first order")
        await pilot.press("escape")
        await shows(pilot, "AzimPivot_R", "Corrected to first order")


async def test_a_click_turns_a_choice_and_left_turns_it_back():
    app = app_with()
    async with app.run_test(size=LARGE) as pilot:
        await opened(app, pilot, "energy")
        box = app.screen.query_one(ChoiceBox)
        await pilot.click(box)
        await until(pilot, lambda: box.value == "tilted" and "facing N" in screen_words(app))
        await pilot.press("left")
        await until(pilot, lambda: box.value == "level")


@pytest.mark.parametrize("name", ["heliostat-aim", "screwjack"])
async def test_goldens(name):
    app = app_with()
    async with app.run_test(size=SMALL) as pilot:
        typed = next(typed for one, typed, _ in NUMBERS if one == name)
        screen = await opened(app, pilot, name, **typed)
        await until(pilot, lambda: screen.answer is not None)
        await shows_golden(pilot, f"calculator-{name}-80x24")
