"""The start screen: what it offers, in which order, and what opening something leaves behind."""

import msgspec
import pytest
from procedure_bench import screen_words, shows, until
from textual.widgets import Input, OptionList

from solarcal.config import (
    REMEMBERED_LINES,
    Choice,
    Settings,
    load_settings,
    save_settings,
    sessions_dir,
)
from solarcal.emulated_units import open_choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_pty
from solarcal.errors import ConfigurationError
from solarcal.profile_form import MOUNT_FIELDS, FieldError, form_texts, profile_from_form
from solarcal.profiles import MountDescription, Profile, load_profile, save_profile
from solarcal.session.journal import Journal
from solarcal.session.records import Closed
from solarcal.session.view import read_session
from solarcal.site import BoltCircle
from solarcal.station.news import FileInitialised
from solarcal.station.saved_sessions import finished, saved_sessions
from solarcal.timescale import SystemClock, parse_utc
from solarcal.tui.app import SolarcalApp
from solarcal.tui.menu_entries import menu_entries
from solarcal.tui.start_screen import StartScreen
from solarcal.tui.workstation.screen import WorkstationScreen


def app_with(start=None, **settings):
    return SolarcalApp(settings=Settings(**settings), start=start, remember=True)


async def offers(pilot):
    """The sections and entries of the list, once everything has been looked up."""
    await shows(pilot, "tilted-tower")
    choices = pilot.app.screen.query_one(OptionList)
    return [str(option.prompt).strip() for option in choices.options]


def unfinished_session(name="field-2026-06-03.jsonl"):
    """A session that broke off, as a killed program leaves it; its line is an emulated one."""
    line = open_choice(Choice(scenario="tijeras-azel"), Profile())
    line.station.set_unit_clock()
    line.station.initialise(confirmed=True)
    path = line.path
    line.station.leave()
    line.resources.close()
    renamed = path.with_name(name)
    path.rename(renamed)
    return renamed


async def test_a_newcomer_is_offered_the_emulated_trackers():
    async with app_with().run_test(size=(100, 40)) as pilot:
        entries = await offers(pilot)
        at = entries.index("Emulated trackers, to learn and to try")
        assert entries[at + 1].startswith("tijeras-azel")


async def test_the_last_choice_comes_first_and_enter_opens_it():
    async with app_with(last=Choice(scenario="tijeras-azel")).run_test(size=(100, 40)) as pilot:
        entries = await offers(pilot)
        assert entries[:2] == ["Last time", "emulated tracker tijeras-azel"]
        await pilot.press("enter")
        await until(pilot, lambda: isinstance(pilot.app.screen, WorkstationScreen))
        await shows(pilot, "LINK OK", "Set the unit's clock")
        await pilot.app.leave()


async def test_opening_creates_the_session_at_once_and_remembers_its_line():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        app.open_choice(Choice(scenario="tilted-tower", seed=3))
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
        assert [path.name for path in sessions_dir().iterdir()] == [app.session_name]
        settings = load_settings()
        assert settings.last == Choice(scenario="tilted-tower", seed=3)
        assert settings.lines == {app.session_name: Choice(scenario="tilted-tower", seed=3)}
        await app.leave()


def test_two_workstations_on_one_laptop_remember_the_lines_of_both():
    begun = load_settings()
    one = begun.with_line(sessions_dir() / "one.jsonl", Choice(port="/dev/ttyUSB0"))
    save_settings(one)
    save_settings(begun.with_line(sessions_dir() / "other.jsonl", Choice(port="/dev/ttyUSB1")))
    save_settings(one)
    assert set(load_settings().lines) == {"one.jsonl", "other.jsonl"}
    for number in range(2 * REMEMBERED_LINES):
        one = one.with_line(sessions_dir() / f"{number}.jsonl", Choice(port="/dev/ttyUSB0"))
    save_settings(one)
    assert list(load_settings().lines) == list(one.lines)


async def test_an_unfinished_session_comes_before_everything_and_goes_on():
    path = unfinished_session()
    before = read_session(path).records
    line = Choice(scenario="tijeras-azel")
    app = app_with(last=line, lines={path.name: line})
    async with app.run_test(size=(100, 40)) as pilot:
        entries = await offers(pilot)
        assert entries[0] == "Unfinished sessions: continue"
        assert entries[1].startswith(path.name)
        await pilot.press("enter")
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
        assert app.session_name == path.name
        assert app.state.session.records[: len(before)] == before
        assert app.state.session.initialised is not None
        await app.leave()


def test_an_unfinished_session_outside_the_sessions_folder_is_offered_too(tmp_path):
    inside = unfinished_session()
    outside = inside.rename(tmp_path / "roof.jsonl")
    line = Choice(scenario="tijeras-azel")
    save_settings(load_settings().with_line(outside, line))
    (words, choice), *rest = menu_entries(load_settings()).unfinished
    assert choice == msgspec.structs.replace(line, session=str(outside))
    assert words.startswith("roof.jsonl")
    assert words.endswith(f"in {tmp_path}")
    assert not rest
    # Moved into the sessions folder it is there once, and its line is known by its name.
    save_settings(load_settings().with_line(inside, line))
    outside.rename(inside)
    (entry,) = menu_entries(load_settings()).unfinished
    assert entry[1].session == str(inside)


async def test_an_unfinished_session_of_an_unknown_line_asks_for_the_line():
    path = unfinished_session()
    app = app_with()
    async with app.run_test(size=(100, 40)) as pilot:
        await offers(pilot)
        await pilot.press("enter")
        await shows(pilot, "On which line is the unit of", "Escape: back to all choices")
        assert path.name in screen_words(app)
        await pilot.press("escape")
        await shows(pilot, "Unfinished sessions", "Choose with the arrow keys, open with Enter.")
        assert "Escape: back" not in screen_words(app)


async def test_a_session_of_an_emulated_tracker_of_another_program_goes_on_with_its_scenario():
    path = unfinished_session("tijeras-azel-2026-06-03.jsonl")
    before = read_session(path).records
    known = unfinished_session("known.jsonl")
    app = app_with(lines={known.name: Choice(scenario="tijeras-azel")})
    async with app.run_test(size=(100, 40)) as pilot:
        entries = await offers(pilot)
        # What needs a question comes after what needs none.
        assert [entry.split()[0] for entry in entries[1:3]] == [known.name, path.name]
        await pilot.press("down", "enter")
        await shows(pilot, "On which line is the unit of", "It was an emulated tracker")
        entries = await offers(pilot)
        at = entries.index("It was an emulated tracker")
        assert entries[at + 1].startswith("tijeras-azel")
        app.screen.query_one(OptionList).highlighted = at + 1
        await pilot.press("enter")
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
        assert app.session_name == path.name
        assert app.state.session.records[: len(before)] == before
        assert app.state.live.status.unit_utc_s >= parse_utc(before[-1].utc)
        await app.leave()


async def test_leaving_before_anything_was_begun_leaves_nothing_to_go_on_with():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        app.open_choice(Choice(scenario="tijeras-azel"))
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
        path = app.line.path
        await pilot.press("ctrl+q")
        await until(pilot, lambda: app.return_value is not None)
    assert isinstance(read_session(path).records[-1], Closed)
    assert [saved.finished for saved in saved_sessions()] == [True]


async def test_leaving_in_the_middle_of_a_calibration_offers_to_go_on():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        app.open_choice(Choice(scenario="tijeras-azel"))
        await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
        app.worker.submit(FileInitialised, lambda s: s.initialise(confirmed=True))
        await until(pilot, lambda: app.state.session.initialised is not None)
        assert finished(app.state.session) == ""
        await pilot.press("ctrl+q")
        await until(pilot, lambda: app.return_value is not None)
    assert [saved.finished for saved in saved_sessions()] == [False]


async def test_a_port_that_is_not_there_is_said_in_one_line_and_can_be_tried_again(tmp_path):
    app = app_with()
    async with app.run_test(size=(100, 30)) as pilot:
        await offers(pilot)
        await pilot.press("a", *"/dev/nosuch", "enter")
        await shows(pilot, "/dev/nosuch")
        await until(pilot, lambda: not app._opening)
        assert isinstance(app.screen, StartScreen)
        assert app.screen.query_one(Input).value == "/dev/nosuch"
        assert app.worker is None
    assert list(sessions_dir().glob("*")) == []


async def test_a_damaged_session_file_is_no_reason_to_stop(tmp_path):
    sessions_dir().mkdir(parents=True)
    (sessions_dir() / "torn.jsonl").write_text("not a session\n")
    async with app_with().run_test(size=(100, 40)) as pilot:
        assert not any("torn" in entry for entry in await offers(pilot))
    (saved,) = saved_sessions()
    assert "torn.jsonl" in saved.damage


async def test_links_that_lead_nowhere_are_no_reason_to_stop():
    good = unfinished_session()
    (sessions_dir() / "stick.jsonl").symlink_to("/media/stick-that-is-not-plugged-in/day.jsonl")
    (sessions_dir() / "loop.jsonl").symlink_to("loop.jsonl")
    (sessions_dir() / "folder.jsonl").mkdir()
    async with app_with().run_test(size=(100, 40)) as pilot:
        assert any(good.name in entry for entry in await offers(pilot))
        await pilot.press("f9")
        await shows(pilot, "RECOMPUTE", "(1 of 2")
        await pilot.press("space", "enter")
        await shows(pilot, "(2 of 2")


async def test_a_theme_is_remembered():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        app.theme = "sunlight"
        await until(pilot, lambda: load_settings().theme == "sunlight")


# -- the profile form ------------------------------------------------------------------------


async def test_the_profile_form_saves_what_it_shows():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("e")
        await shows(pilot, "Site, unit and operator")
        for field, text in {
            "name": "Tijeras", "operator": "Ann", "latitude_deg": "35.08",
            "longitude_deg": "-106.4", "elevation_m": "1900", "pressure_hpa": "805",
            "lean_north_deg": "0.3", "lean_east_deg": "-0.1", "lean_sigma_deg": "0.05",
            "last_coefficients": "0.3 -0.36 +0.53 0.22 0.0007 -0.0006", "bolt_circle": "400,4,45",
        }.items():  # fmt: skip
            app.screen.query_one(f"#{field}", Input).value = text
        await pilot.press("ctrl+w")
        await shows(pilot, "profile Tijeras", "operator Ann")
    saved = load_profile("Tijeras")
    assert saved.site.longitude_deg == -106.4
    assert saved.weather.pressure_hpa == 805.0
    assert saved.inclinometer.lean_east_deg == -0.1
    assert saved.last_coefficients == (0.3, -0.36, 0.53, 0.22, 0.0007, -0.0006)
    assert saved.bolt_circle == BoltCircle(400.0, 4, 45.0)
    assert profile_from_form(form_texts(saved)) == saved
    assert load_settings().profile == "Tijeras"


async def test_the_arrow_keys_go_from_field_to_field_and_the_view_follows():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("e")
        await shows(pilot, "Site, unit and operator")
        fields = list(form_texts(Profile()))
        await pilot.press(*["down"] * fields.index("bolt_circle"))
        await pilot.press(*"400,4")
        await shows(pilot, "400,4")
        assert app.screen.query_one("#bolt_circle", Input).value == "400,4"
        await pilot.press("up", *"0.3")
        assert app.screen.query_one("#last_coefficients", Input).value == "0.3"
        await pilot.press("ctrl+w")
        await shows(pilot, "1 of the six numbers P1 to P6")


async def test_a_wrong_field_is_named_marked_and_nothing_is_saved():
    app = app_with()
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("e")
        await shows(pilot, "Site, unit and operator")
        app.screen.query_one("#latitude_deg", Input).value = "95"
        app.screen.query_one("#longitude_deg", Input).value = "10"
        await pilot.press("ctrl+w")
        await shows(pilot, "Latitude, deg north: 95 is not between -90 and 90")
        assert app.screen.query_one("#latitude_deg").has_class("-wrong")
        assert app.focused is app.screen.query_one("#latitude_deg")
        await pilot.press("escape")
        await shows(pilot, "profile default")


def test_what_the_form_has_no_field_for_stays():
    before = Profile(name="x", unmodelled={"clock_s": 10.0}, done_probability=0.9)
    assert profile_from_form(form_texts(before), before) == before


@pytest.mark.parametrize(
    ("texts", "field"),
    [
        ({"name": "../up"}, "name"),
        ({"latitude_deg": "35"}, "longitude_deg"),
        ({"elevation_m": "100"}, "latitude_deg"),
        ({"temperature_c": "20"}, "pressure_hpa"),
        ({"pressure_hpa": "29.9"}, "pressure_hpa"),
        ({"lean_north_deg": "0.1"}, "lean_east_deg"),
        ({"lean_north_deg": "0.1", "lean_east_deg": "0", "lean_sigma_deg": "0"}, "lean_sigma_deg"),
        ({"last_coefficients": "0.3 -0.36 0.53"}, "last_coefficients"),
        ({"last_coefficients": "12 0 0 0 0 0"}, "last_coefficients"),
        ({"bolt_circle": "400"}, "bolt_circle"),
        ({"bolt_circle": "400,2"}, "bolt_circle"),
        ({"tolerance_deg": "a tenth"}, "tolerance_deg"),
        ({"baudrate": "3"}, "baudrate"),
    ],
)
def test_the_form_names_the_field_that_is_wrong(texts, field):
    with pytest.raises(FieldError) as refused:
        profile_from_form({"name": "x", **texts})
    assert refused.value.field == field


@pytest.mark.parametrize(
    ("texts", "field"),
    [
        ({"driver": "belt"}, "driver"),
        ({"geometry": "elaz"}, "geometry"),
        ({"drive2": "rotary"}, "drive2"),
        ({"limits1_deg": "130 -130"}, "limits1_deg"),
        ({"limits2_deg": "3"}, "limits2_deg"),
        ({"reference_deg": "0 north"}, "reference_deg"),
        ({"update_range_deg": "90"}, "update_range_deg"),
        ({"update_range_deg": "0.1_0"}, "update_range_deg"),
        ({"zone_west_h": "٣"}, "zone_west_h"),
    ],
)
def test_a_wrong_field_of_the_mount_is_named(texts, field):
    with pytest.raises(FieldError) as caught:
        profile_from_form({"name": "x", **texts})
    assert caught.value.field == field


def test_a_mount_comes_back_from_the_form_with_what_the_form_has_no_field_for():
    mount = MountDescription(
        unit_name="roof", geometry="polar", drive1="rotary:250", limits1_deg=(-90.0, 85.5),
        update_range_deg=0.2, reference1_deg=10.0, scale_decimals=7, zone_west_h=7.0,
    )  # fmt: skip
    before = Profile(name="x", mount=mount)
    assert profile_from_form(form_texts(before), before) == before
    save_profile(before)
    assert load_profile("x") == before
    changed = {**form_texts(before), "unit_name": "", "update_range_deg": "0,05"}
    again = profile_from_form(changed, before).mount
    assert (again.unit_name, again.update_range_deg, again.scale_decimals) == ("", 0.05, 7)
    emptied = {**form_texts(before), **{name: "" for name, _, _ in MOUNT_FIELDS}}
    assert profile_from_form(emptied, before).mount is None


def test_a_profile_comes_back_from_the_form_and_from_its_file_unchanged():
    texts = {
        "name": "São Paulo"[:1] + "ao", "operator": 'Ann "the hand" \\ Ω', "latitude_deg": "-23,55",
        "longitude_deg": "-46.6333333333", "port": "socket://host:7", "tolerance_deg": "0.05",
    }  # fmt: skip
    profile = profile_from_form(texts)
    assert profile.site.latitude_deg == -23.55
    assert profile_from_form(form_texts(profile)) == profile
    save_profile(profile)
    assert load_profile(profile.name) == profile


def test_a_damaged_settings_file_is_named():
    from solarcal.config import config_dir

    config_dir().mkdir(parents=True)
    (config_dir() / "settings.toml").write_text("theme = [\n")
    with pytest.raises(ConfigurationError, match=r"settings\.toml"):
        load_settings()


def test_a_unit_that_believes_in_another_site_is_noticed_at_once():
    right = open_choice(Choice(scenario="tijeras-azel"), Profile())
    wrong = open_choice(
        Choice(scenario="tijeras-azel", settings=("truth.unit_offset_s=3600",)), Profile()
    )
    assert right.noticed == ()
    assert any("+1 h" in sentence for sentence in wrong.noticed)
    right.close()
    wrong.close()


def test_a_real_unit_has_the_laptops_clock_and_an_emulated_one_its_own():
    line = open_choice(Choice(scenario="tijeras-azel"), Profile())
    assert not isinstance(line.clock, SystemClock)
    line.close()


def test_going_on_is_refused_when_another_program_has_the_file():
    from solarcal.errors import SolarcalError

    path = unfinished_session()
    with Journal.resume(path), pytest.raises(SolarcalError, match=path.name):
        open_choice(Choice(scenario="tijeras-azel", session=str(path)), Profile())


# -- the driver ------------------------------------------------------------------------------


async def test_d_chooses_how_the_next_unit_is_talked_to():
    app = SolarcalApp()
    async with app.run_test(size=(80, 24)) as pilot:
        await shows(pilot, "Driver [d]: solartrak", "device, socket:// or rfc2217://host:port")
        await pilot.press("d")
        await shows(pilot, "Driver [d]: rotctld", "host or host:port of Hamlib's rotctld")
        await pilot.press("a", *"nowhere")
        await pilot.press("enter")
        await shows(pilot, "driver rotctld needs the site", "--site FILE")


async def test_the_profiles_driver_is_chosen_already():
    save_profile(Profile(name="roof", driver="rotctld", port="nowhere:1"))
    app = SolarcalApp(profile=load_profile("roof"))
    async with app.run_test(size=(80, 24)) as pilot:
        await shows(pilot, "Driver [d]: rotctld", "nowhere:1 as in the profile")


async def test_an_emulated_rotator_is_opened_like_any_unit():
    start = Choice(
        scenario="tijeras-azel", driver="rotctld", settings=("start=2026-06-03T16:00:00Z",)
    )
    app = SolarcalApp(start=start)
    async with app.run_test(size=(80, 24)) as pilot:
        await shows(pilot, "Emulated Rotator 0001 azel", "LINK OK")


# -- the port of the command line --------------------------------------------------------------


async def test_the_port_asked_for_offers_its_units_unfinished_session_first():
    path = unfinished_session()
    with serve_pty(Emulator(load_scenario("tijeras-azel", []))) as port:
        app = app_with(start=Choice(port=port, offers_unfinished=True))
        async with app.run_test(size=(100, 40)) as pilot:
            await shows(pilot, "Unfinished sessions of this unit", "Or begin anew")
            assert path.name in screen_words(app)
            await pilot.press("enter")
            await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
            assert app.session_name == path.name
            await app.leave()


async def test_a_new_session_is_begun_all_the_same_when_that_is_chosen():
    path = unfinished_session()
    with serve_pty(Emulator(load_scenario("tijeras-azel", []))) as port:
        app = app_with(start=Choice(port=port, offers_unfinished=True))
        async with app.run_test(size=(100, 40)) as pilot:
            await shows(pilot, "Or begin anew")
            await pilot.press("down", "enter")
            await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
            assert app.session_name != path.name
            await app.leave()


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("tijeras-azel", ["unit.serial=B9"]),
        ("ns-tiltroll", []),
        ("heliostat", []),
        ("southern", []),
    ],
)
async def test_another_units_unfinished_session_is_not_offered(scenario, settings):
    unfinished_session()
    with serve_pty(Emulator(load_scenario(scenario, settings))) as port:
        app = app_with(start=Choice(port=port, offers_unfinished=True))
        async with app.run_test(size=(100, 40)) as pilot:
            await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
            await app.leave()


async def test_a_session_that_was_chosen_is_not_asked_for_again():
    """The line remembered with a session is that of ``run --port``, which asks."""
    path = unfinished_session()
    with serve_pty(Emulator(load_scenario("tijeras-azel", []))) as port:
        app = app_with(start=Choice(port=port, session=str(path), offers_unfinished=True))
        async with app.run_test(size=(100, 40)) as pilot:
            await until(pilot, lambda: isinstance(app.screen, WorkstationScreen))
            assert app.session_name == path.name
            await app.leave()
