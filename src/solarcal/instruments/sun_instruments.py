"""The instruments about the Sun: where it is, its day and year, what a collector catches."""

from dataclasses import replace

from solarcal.instruments.form import Field, Flag, Instrument

GEOMETRIES = ("azel", "tiltroll-ew", "tiltroll-ns", "polar")

LATITUDE = Field(
    "lat", "Latitude", "deg N", low=-90, high=90, required=True,
    metavar="DEG", help="latitude, positive north",
)  # fmt: skip
LONGITUDE = Field(
    "lon", "Longitude", "deg EAST", low=-180, high=360, required=True,
    metavar="DEG", help="longitude, positive EAST",
)  # fmt: skip
ELEVATION = Field(
    "elevation", "Elevation", "m", "0", low=-500, high=9000,
    metavar="M", help="metres above sea (default 0)",
)  # fmt: skip
PLACE = (LATITUDE, LONGITUDE, ELEVATION)
"""On the form filled from the connected unit's session, else from the profile."""

TIME = Field(
    "at", "Time (UTC)", hint="now", metavar="ISO",
    help="date and time like 2026-06-21T15:30:00Z or with an offset like -07:00; UTC where it has "
    "none (default: now by this computer's clock)",
)  # fmt: skip
MOUNT = (
    Field(
        "geometry", "Mount", default="azel", choices=GEOMETRIES,
        metavar="NAME", help="azel (default), tiltroll-ew, tiltroll-ns or polar",
    ),
    Field(
        "centre", "Centre of AX1", "deg", hint="by site", low=-360, high=360, flag="--ax1-centre",
        metavar="DEG",
        help="centre of the branch of AX1 (default 0; 180 for azel south of the equator)",
    ),
)  # fmt: skip
DUT1 = Field(
    "dut1", "UT1 - UTC", "s", "0", low=-1, high=1, metavar="S",
    help="UT1 - UTC in seconds, for the precise model (default 0)",
)  # fmt: skip
_TARGET = Field(
    "target", "Target", default="sun", choices=("sun", "moon"), metavar="TARGET",
    help="sun (default) or moon, with its phase",
)  # fmt: skip
PICTURE = (
    Field(
        "rotated", "Picture rotated by", "deg", "0", low=-360, high=360, metavar="DEG",
        help="the picture shows the device rotated clockwise by this (default 0)",
    ),
    Field("mirrored", "Picture mirrored", default="no", choices=("no", "yes")),
    Field(
        "threshold", "Edge brightness", "0..1", hint="half-way", low=0, high=1, metavar="B",
        help="brightness of the disc's edge, 0 to 1 (default: half-way between background and "
        "disc)",
    ),
)  # fmt: skip
PICTURE_FLAGS = (Flag("--mirrored", "the picture is mirrored left to right", {"mirrored": "yes"}),)
_LIMITS = (
    *(
        Field(
            f"limits{axis}", f"AX{axis} from, to", "deg", hint="anywhere", count=2,
            metavar="LOW HIGH", help=f"limits of axis {axis}, deg (default: none)",
        )
        for axis in (1, 2)
    ),
    Field(
        "lowest", "Sun counts from", "deg", "0", low=-90, high=89, metavar="DEG",
        help="lowest airless elevation of the Sun that counts (default 0)",
    ),
)  # fmt: skip
_COLLECTOR = (
    Field(
        "collector", "Collector", default="level",
        choices=("level", "tilted", "normal", "tracking", "one axis"),
    ),
    Field("tilt", "tilted by", "deg", example="30", low=0, high=180),
    Field(
        "facing", "towards azimuth", "deg", hint="equator", low=-360, high=360, metavar="DEG",
        help="azimuth from North through East for --tilt (default: the equator's side)",
    ),
    Field("vector", "normal, axis", "N E U", example="1 0 0", count=3),
)  # fmt: skip
_COLLECTOR_FLAGS = (
    Flag(
        "--normal", "collector: fixed, facing this North East Up vector of any length",
        {"collector": "normal"}, "vector", "N E U", "collector",
    ),
    Flag(
        "--tilt", "collector: fixed, tilted from level towards --facing (default: level)",
        {"collector": "tilted"}, "tilt", "DEG", "collector",
    ),
    Flag(
        "--tracking", "collector: faces the Sun on two axes", {"collector": "tracking"},
        exclusive="collector",
    ),
    Flag(
        "--axis", "collector: turns about this axis alone; 1 0 0 is a North-South trough",
        {"collector": "one axis"}, "vector", "N E U", "collector",
    ),
)  # fmt: skip

SUN_INSTRUMENTS = (
    Instrument(
        "sun", "The Sun", "Sun position", "azimuth, elevation, axis angles",
        "sun", "sun",
        (
            *PLACE, TIME,
            _TARGET,
            Field(
                "model", "Model", default="precise",
                choices=("precise", "solartrak", "solartrak+", "noaa"),
                metavar="MODEL", help="solartrak, solartrak+, noaa or precise (default)",
            ),
            *MOUNT,
            Field(
                "refraction", "Refraction", default="none",
                choices=("none", "hughes", "saemundsson"),
                metavar="FORMULA", help="none (default), hughes or saemundsson",
            ),
            Field(
                "pressure", "Station pressure", "hPa", hint="mean air", metavar="HPA",
                help="STATION pressure for the refraction (default: the mean at that elevation)",
            ),
            Field(
                "temperature", "Temperature", "C", "15", metavar="C",
                help="air temperature for the refraction (default 15)",
            ),
            DUT1,
        ),
        "sun",
        "utc, model, azimuth_deg, zenith_deg, elevation_deg, declination_deg, "
        "equation_of_time_min, solar_time, geometry, ax1_deg, ax2_deg; with --target moon: target, "
        "utc, azimuth_deg, zenith_deg, elevation_deg, distance_km, semidiameter_deg, phase_deg, "
        "illuminated, waxing, usable, geometry, ax1_deg, ax2_deg",
    ),
    Instrument(
        "sun-compare", "The Sun", "Two Sun models", "worst and rms difference over years",
        "sun", "compare",
        (
            *PLACE,
            Field(
                "models", "Models", default="noaa,precise", metavar="A,B",
                help="compare: the two models (noaa,precise)",
            ),
            Field(
                "from_year", "From year", "", "1990", low=1900, high=2100, flag="--from",
                metavar="YEAR", help="compare: from the start of this year (1990)",
            ),
            Field(
                "to_year", "To year", "", "2020", low=1900, high=2100, flag="--to",
                metavar="YEAR", help="compare: to the end of this year (2020)",
            ),
        ),
        "sun compare",
        "models, from_year, to_year, positions, altitude_worst_deg, altitude_rms_deg, "
        "azimuth_worst_deg, azimuth_rms_deg, cross_worst_deg (azimuth on the sky), cross_rms_deg, "
        "years (year, altitude_worst_deg, cross_worst_deg)",
    ),
    Instrument(
        "day", "The Sun", "Day", "sunrise, noon, sunset; hours within limits",
        "day", "day",
        (
            *PLACE, TIME, _TARGET, *MOUNT, *_LIMITS,
            Field(
                "every", "Table every", "min", hint="none", low=1, high=720, metavar="MIN",
                help="rows of the table, minutes (1 to 720; --table alone: 30)",
            ),
            Field(
                "method", "Method", default="precise", choices=("precise", "noaa"),
                metavar="METHOD",
                help="precise: root finding on the precise Sun (default); noaa: NOAA's formulas "
                "(some minutes)",
            ),
            Field(
                "altitude", "Rises at altitude", "deg", hint="-0.833", low=-89, high=89,
                metavar="DEG",
                help="airless altitude of the Sun's centre at rise and set (default -0.8333; noaa "
                "-0.833)",
            ),
            Field("chart", "Chart", default="no", choices=("no", "yes"), on_form=False),
            replace(DUT1, on_form=False),
        ),
        "day",
        "utc, method, altitude_deg, sunrise_utc, transit_utc, sunset_utc (null where there is "
        "none), transit_elevation_deg (airless), daylight_h, polar (day, night or null), "
        "solar_time, equation_of_time_min; with limits: within_limits (hours, spans_utc, "
        "crosses_branch); with --table: table; with --target moon: target, utc, moonrise_utc, "
        "transit_utc, moonset_utc, transit_elevation_deg, phase_deg, illuminated, waxing, "
        "usable_utc (from, to; null where it is not high and bright enough), table",
        (
            Flag("--table", "a table of the Sun through the day", {"every": "30"}),
            Flag("--chart", "a text chart of elevation and azimuth", {"chart": "yes"}),
        ),
    ),
    Instrument(
        "year", "The Sun", "Year", "the Sun month by month, hours within limits",
        "year", "year",
        (
            *PLACE,
            Field(
                "year", "Year", hint="this year", low=1960, high=2099, metavar="YEAR",
                help="1960 to 2099 (default: this year)",
            ),
            *_COLLECTOR, *MOUNT, *_LIMITS,
        ),
        "year",
        "year, latitude_deg, longitude_deg, collector, months (date, sunrise_utc, transit_utc, "
        "sunset_utc, daylight_h, transit_elevation_deg, polar, within_limits_h, energy_percent), "
        "whole_year (daylight_h, within_limits_h, energy_percent)",
        _COLLECTOR_FLAGS,
    ),
    Instrument(
        "energy", "The Sun", "Collector energy", "for the moment, the day and the year (SUNCALC)",
        "year", "energy",
        (
            Field(
                "lat", "Latitude", "deg N", "42", low=-90, high=90, metavar="DEG",
                help="latitude, north positive (42)",
            ),
            Field("day", "Days after equinox", "d", "91", low=0, high=366),
            Field("date", "or the date", hint="YYYY-MM-DD"),
            Field(
                "time", "Solar time", "h", "12", metavar="H",
                help="solar time in hours (12, noon)",
            ),
            *_COLLECTOR,
            Field(
                "error", "Pointing error", "deg", hint="none", flag="--pointing-error",
                metavar="DEG", help="loss by this error over the day",
            ),
            Field(
                "turbidity", "Linke turbidity", "", "3", low=1, high=10, metavar="TL",
                help="Linke turbidity of the air: 2 very clean, 3 clean (default), 5 hazy",
            ),
            Field(
                "height", "Height of the site", "m", "0", low=-500, high=9000, metavar="M",
                help="metres above sea, for the clear-sky estimate (0)",
            ),
            Field(
                "acceptance", "Half acceptance", "deg", hint="none", metavar="DEG",
                help="half acceptance angle of a concentrator: share of the Sun's disc inside it "
                "with --pointing-error",
            ),
        ),
        "energy",
        "latitude_deg, day, solar_time_h, collector, sun (north, east, up, elevation_deg, "
        "high_sun_deg, sunrise_bearing_deg from East towards North, never_sets), daylight_h, "
        "dawn_h, dusk_h, due_east_h, due_west_h, percent (moment, day in SUNCALC's 100 steps, "
        "day_integrated, year, seasons), irradiance (outside_w_m2, moment and day outside the air, "
        "clear_sky_w_m2, clear_sky_kwh_m2, turbidity), pointing (null without --pointing-error)",
        (
            *_COLLECTOR_FLAGS,
            Flag("--day", "days after the March equinox (91)", to="day", metavar="DAYS",
                 exclusive="when"),
            Flag("--date", "date, converted to days after the March equinox before it", to="date",
                 metavar="YYYY-MM-DD", exclusive="when"),
        ),
    ),
)  # fmt: skip
