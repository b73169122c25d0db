"""The instruments about mirrors: heliostats, and two-mirror trackers."""

from dataclasses import replace

from solarcal.instruments.form import Field, Flag, Instrument
from solarcal.instruments.sun_instruments import (
    ELEVATION,
    LATITUDE,
    LONGITUDE,
    MOUNT,
    PICTURE,
    PICTURE_FLAGS,
    TIME,
)

_SUN = Field(
    "sun", "Sun az, zenith", "deg", example="180 40", hint="by time", count=2,
    metavar="AZIMUTH ZENITH", help="the Sun, instead of place and time",
)  # fmt: skip
_PLACE = (replace(LATITUDE, required=False), replace(LONGITUDE, required=False), ELEVATION)
_REFRACTION = Field(
    "refraction", "Refraction", default="hughes", choices=("hughes", "saemundsson", "none"),
    metavar="FORMULA",
    help="hughes (default; mean air of that elevation), saemundsson or none",
)  # fmt: skip
_TARGET = tuple(
    Field(
        f"target_{name}", f"Target {name}", "deg", example=example, flag="--target",
        metavar=name.upper(), help="the target from the hub",
    )
    for name, example in (("azimuth", "180"), ("zenith", "80"))
)  # fmt: skip
_DISTANCE = Field(
    "distance", "Target distance", "length", hint="none", metavar="D",
    help="distance to the target (circle: d)",
)  # fmt: skip


def _offset(*examples: str) -> tuple[Field, ...]:
    """The mirror's offsets; what the form shows at first."""
    return tuple(
        Field(
            name.lower(), name, "length", "0", example, flag="--offset", metavar=name.upper(),
            help="the mirror's offsets, in the unit of the distance",
        )
        for name, example in zip(
            ("AzimPivot_R", "PivotRefl_R", "PivotRefl_Z"), examples, strict=True
        )
    )  # fmt: skip


_HELIOSTATS = (
    Instrument(
        "heliostat-aim", "Heliostat", "Aim", "the mirror's normal, with the effect of its offset",
        "heliostat", "aim",
        (_SUN, *_TARGET, _DISTANCE, *_offset("", "", ""), *MOUNT, *_PLACE, TIME, _REFRACTION),
        "heliostat aim",
    ),
    Instrument(
        "heliostat-target", "Heliostat", "Targeting",
        "direction of the target, from normals with the beam on it",
        "heliostat", "target",
        (
            Field(
                "seen", "Sun, normal", hint="az zen n1 n2", count=4, repeat=4,
                metavar="SUN_AZ SUN_ZEN N1 N2",
                help="target: Sun and normal while the beam was on the target; as often as seen",
            ),
            Field(
                "read", "Normal read as", default="az zenith", choices=("az zenith", "AX1 AX2")
            ),
            *MOUNT, *_PLACE, _REFRACTION,
        ),
        "heliostat target",
        flags=(
            Flag(
                "--seen-at",
                "target: the same with the time instead of the Sun (needs --lat --lon)",
                to="seen", metavar="ISO N1 N2", repeat=True,
            ),
            Flag(
                "--axes", "N1 N2 are AX1 AX2 of --geometry, not azimuth, zenith",
                {"read": "AX1 AX2"},
            ),
        ),
    ),
    Instrument(
        "heliostat-drift", "Heliostat", "Drift", "of an uncorrected mirror offset over a day",
        "heliostat", "drift",
        (
            *_PLACE, TIME, *_TARGET, replace(_DISTANCE, example="120", hint=""),
            *_offset("0.12", "0", "0.35"), _REFRACTION,
        ),
        "heliostat drift",
    ),
    Instrument(
        "heliostat-circle", "Heliostat", "Mirror on a circle", "both roots, front and back",
        "heliostat", "circle",
        (
            Field(
                "angle", "Sun to target", "deg", example="22.5", metavar="DEG",
                help="circle: phi, between Sun and target",
            ),
            replace(_DISTANCE, example="5", hint=""),
            Field(
                "radius", "Circle's radius", "length", "1", metavar="R", help="circle: r (1)"
            ),
            Field("steps", "Bisection steps", default="no", choices=("no", "yes")),
        ),
        "heliostat circle",
        "",
        (Flag("--steps", "circle: the published bisection, step by step", {"steps": "yes"}),),
    ),
    Instrument(
        "heliostat-shift", "Heliostat", "Translation", "change of the target's direction",
        "heliostat", "shift",
        (
            Field(
                "by", "Moved by", "length", example="3", metavar="LENGTH",
                help="shift: length across the line of sight",
            ),
            replace(_DISTANCE, label="Distance", example="800", hint=""),
        ),
        "heliostat shift",
    ),
)  # fmt: skip


def _fov_field(
    name: str, label: str, unit: str, default: str, flag: str, metavar: str, help: str
) -> Field:
    return Field(
        name, label, unit, default, flag=flag, metavar=metavar, help=f"{help} (default {default})"
    )


_AXES = tuple(
    Field(
        f"t{axis}", f"Axis {axis} (AX{axis})", "deg", example=example, low=-most, high=most,
        metavar="DEG", help=f"axis {axis} (AX{axis})", required=True,
    )
    for axis, example, most in ((1, "0", 360), (2, "45", 180))
)  # fmt: skip
_FIXED_MIRROR = Field("mirror", "Fixed mirror", "normal", hint="none", count=3, repeat=2)
_MIRROR_FLAG = Flag(
    "--mirror",
    "normal of a fixed mirror, the tracker's side first (repeatable); write --mirror=-1,0,1 where "
    "it begins with a minus",
    to="mirror",
    metavar="X,Y,Z",
    repeat=True,
)

_TWO_MIRROR = (
    Instrument(
        "mirrors-point", "Two-mirror tracker", "Point", "axis angles for the Sun",
        "two_mirror", "point",
        (
            replace(_SUN, flag="--azimuth --zenith", metavar="DEG DEG",
                    help="of the Sun: azimuth from North over East, and zenith angle"),
            *(
                Field(
                    name, f"Base {name} ({axis})", "deg", "0", metavar="DEG",
                    help=f"turn of the base about {axis} (default 0)",
                )
                for name, axis in (("alpha", "z"), ("beta", "y"), ("gamma", "x"))
            ),
            *_PLACE, TIME, _REFRACTION,
        ),
        "two-mirror point",
    ),
    Instrument(
        "mirrors-trace", "Two-mirror tracker", "Trace", "the diode's signals as axis corrections",
        "two_mirror", "trace",
        (
            *(
                Field(
                    name, f"Signal {name.upper()}", example="1", flag="--signals",
                    metavar=name.upper(), help="of the four quadrants", required=True,
                )
                for name in "abcd"
            ),
            *_AXES,
            *(
                Field(
                    f"set{axis}", f"Set point e{axis}c", default="0", flag="--set-point",
                    metavar=f"E{axis}", help="where the diode's centre is (default 0 0)",
                )
                for axis in (1, 2)
            ),
            Field(
                "gain", "Gain", "1/rad", hint="disc", metavar="K",
                help="signal per radian (default: 4/(pi r) of the Sun)",
            ),
            _FIXED_MIRROR,
        ),
        "two-mirror trace",
        flags=(_MIRROR_FLAG,),
    ),
    Instrument(
        "mirrors-camera", "Two-mirror tracker", "Camera", "the disc in an image as corrections",
        "two_mirror", "camera",
        (
            Field(
                "image", "Image or folder", hint="a .pgm or .png", metavar="FILE|FOLDER",
                help="image of the disc, PGM or PNG; a folder: its newest complete image",
                required=True,
            ),
            *_AXES,
            Field(
                "aim", "Aim at pixel x, y", "pixel", hint="middle", count=2, metavar="X Y",
                help="the set point: x to the right, y down from the first pixel (default: the "
                "image's middle)",
            ),
            Field(
                "disc", "Disc's radius", "mrad", "4.65", low=0.1, high=100, flag="--disc-radius",
                metavar="MRAD", help="for the size of a pixel (default 4.65, the Sun's)",
            ),
            Field(
                "pixel", "or one pixel is", "mrad", hint="by the disc", low=1e-6, high=100,
                metavar="MRAD", help="a pixel's size, instead of the disc's radius",
            ),
            *PICTURE,
            _FIXED_MIRROR,
        ),
        "two-mirror camera",
        "image, disc (x, y, radius, sigma in pixels), aim, pixel_mrad, d1_mrad, d2_mrad, "
        "sigma_mrad, off_centre_mrad, correction1_deg, correction2_deg, correction1_sigma_deg, "
        "correction2_sigma_deg",
        (_MIRROR_FLAG, *PICTURE_FLAGS),
    ),
    Instrument(
        "mirrors-fov", "Two-mirror tracker", "Field of view", "diode and tracker against the Sun",
        "two_mirror", "fov",
        (
            _fov_field("diode", "Diode diameter", "mm", "6", "--diode-diameter", "MM",
                       "of the diode"),
            _fov_field("focal", "Focal length", "mm", "200", "--focal-length", "MM",
                       "of the lens before it"),
            _fov_field("tracker", "Tracker diameter", "m", "0.1", "--tracker-diameter", "M",
                       "of the tracker's mirrors as seen along the beam"),
            _fov_field("distance", "Tracker distance", "m", "5", "--distance", "M",
                       "from tracker to instrument"),
            _fov_field("sun", "Sun diameter", "mrad", "9.3", "--sun", "MRAD",
                       "the Sun's diameter"),
        ),
        "two-mirror fov",
    ),
)  # fmt: skip

MIRROR_INSTRUMENTS = (*_HELIOSTATS, *_TWO_MIRROR)
