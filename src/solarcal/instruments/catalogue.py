"""All field calculators, in the order of the list; those about screwjacks and the sunspot device.

A new calculator is a declaration here, or beside its kind, and a function that answers it.
"""

from solarcal.instruments.form import Field, Flag, Instrument
from solarcal.instruments.mirror_instruments import MIRROR_INSTRUMENTS
from solarcal.instruments.sun_instruments import PICTURE, PICTURE_FLAGS, SUN_INSTRUMENTS

_HOLE = Field(
    "hole", "Do, hole diameter", "length", example="4", metavar="DO", help="diameter of the hole"
)
_HEIGHT = Field(
    "height", "H, plate to mirror", "length", example="500", metavar="H",
    help="orifice plate above the mirror",
)  # fmt: skip

_SCREWJACK = Instrument(
    "screwjack", "Drives and devices", "Screwjack", "SJP#1-3 from measured lengths",
    "screwjack", "screwjack",
    (
        Field("R1", "R1, axis to pivot", "length", metavar="LENGTH", help="axis to one pivot"),
        Field(
            "R2", "R2, axis to pivot", "length", metavar="LENGTH", help="axis to the other pivot"
        ),
        Field(
            "R3", "R3, tube offset", "length", "0", metavar="LENGTH",
            help="offset of the jack tube (0)",
        ),
        Field(
            "at", "angle, length", hint="deg length", count=2, repeat=4, metavar="ANGLE LENGTH",
            help="axis angle and the jack's length there; once for beta, twice to check it",
        ),
        Field(
            "pins", "Lengths are", default="centreline", choices=("centreline", "pin to pin")
        ),
        Field(
            "sense", "Angle, with length", default="grows", choices=("grows", "shrinks"),
            help="the axis angle grows (default) or shrinks with the jack's length",
        ),
        Field(
            "unit", "Unit of length", default="in", choices=("in", "mm", "cm", "m"),
            help="of the lengths (in)",
        ),
        Field(
            "counts", "Counts per length", hint="none", metavar="N",
            help="counts per unit of length, signed",
        ),
        Field(
            "limits", "Angles from, to", "deg", hint="all", count=2, metavar="LOW HIGH",
            help="axis angles of interest (default: all between the dead points, 5 deg inside)",
        ),
        Field(
            "reference", "Reference switch", "deg", hint="high limit", metavar="DEG",
            help="axis angle of the reference switch, where counts begin (default: the high limit)",
        ),
        Field(
            "wrong_R1", "R1 longer by", "length", hint="5 mm", metavar="LENGTH",
            help="show the effect of a longer R1 (default 5 mm longer)",
        ),
    ),
    "screwjack",
    "SJP1, SJP2, SJP3, beta_deg, betas_deg, beta_sigma_deg, spread_deg, consistent, "
    "length_residuals, angle_residuals_deg, explanations (name, change, rms), dead_points_deg, "
    "reach_deg, drive (as the unit's parameters; null without --counts), curve (angle_deg, "
    "length, counts), wrong_R1 (change, error_max_deg, left_max_deg, offset_deg, scale, "
    "angle_deg, error_deg, left_deg)",
    (Flag("--pin-to-pin", "the lengths are between the pins", {"pins": "pin to pin"}),),
)  # fmt: skip

_SUNSPOT = (
    Instrument(
        "sunspot", "Drives and devices", "Sunspot device", "pointing error from the spot",
        "sunspot", "error",
        (
            _HEIGHT, _HOLE,
            Field(
                "spot", "Ds, spot diameter", "length", example="13", metavar="DS",
                help="diameter of the spot",
            ),
            Field(
                "edge", "E, edge to edge", "length", example="4.5", metavar="E",
                help="edge of the hole to edge of the spot",
            ),
            Field(
                "edge_up", "E, upwards", "length", hint="not read", metavar="E",
                help="the same towards the plate's upper mark",
            ),
            Field(
                "turned", "E, turned by 180", "length", hint="not read", metavar="E",
                help="E at the same mark of the device after a rotation by 180 deg; gives its own "
                "misalignment",
            ),
        ),
        "sunspot",
        "error_deg, error_up_deg (null where not asked), sky_error_deg, even_rim, device_deg, "
        "tracker_deg (null without --turned)",
    ),
    Instrument(
        "sunspot-picture", "Drives and devices", "Sunspot picture", "E from a picture of the plate",
        "sunspot", "plate",
        (
            Field(
                "image", "Picture or folder", hint="a .pgm or .png", flag="--picture",
                metavar="FILE|FOLDER",
                help="picture of the plate (PGM, PNG) instead of --edge; a folder: its newest",
            ),
            _HEIGHT, _HOLE,
            Field(
                "hole_at", "Hole at pixel x, y", "pixel", hint="found", count=2, metavar="X Y",
                help="--picture: centre of the hole, if it is not a dark disc within the spot; "
                "needs --spot",
            ),
            Field(
                "spot", "Ds, spot diameter", "length", hint="by the hole",
                help="diameter of the spot", metavar="DS",
            ),
            *PICTURE,
        ),
        "sunspot --picture",
        "image, spot and hole (x, y, radius, sigma in pixels), pixel, spot_diameter, even_rim, "
        "edge, edge_up, edge_sigma, error_deg, error_up_deg, error_sigma_deg, sky_error_deg",
        PICTURE_FLAGS,
    ),
    Instrument(
        "sunspot-design", "Drives and devices", "Sunspot design", "its resolution and range",
        "sunspot", "design",
        (
            Field("from", "Begin with", default="its size", choices=("its size", "a resolution")),
            _HOLE,
            Field(
                "shift", "E is read to", "length", "0.5", metavar="E",
                help="--design: reading accuracy of E (0.5)",
            ),
            _HEIGHT,
            Field(
                "plate", "Plate diameter", "length", example="60", metavar="D",
                help="--design: diameter of the plate",
            ),
            Field("resolution", "wanted resolution", "deg", example="0.02"),
            Field("range", "wanted range", "deg", example="1.5"),
        ),
        "sunspot --design",
        "height, hole, plate, spot, even_rim, smallest_shift, resolution_deg, range_deg",
        (
            Flag("--resolution", "--design: wanted resolution, instead of --height",
                 {"from": "a resolution"}, "resolution", "DEG"),
            Flag("--range", "--design: wanted range, instead of --plate", {"from": "a resolution"},
                 "range", "DEG"),
        ),
    ),
)  # fmt: skip

INSTRUMENTS: tuple[Instrument, ...] = (*SUN_INSTRUMENTS, *MIRROR_INSTRUMENTS, _SCREWJACK, *_SUNSPOT)

BY_ID = {instrument.id: instrument for instrument in INSTRUMENTS}
