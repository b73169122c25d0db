"""The program's doors: where bytes of others come in, and what may come out.

A door takes bytes; it may raise nothing but ``SolarcalError``: one line without control characters
that names a place (the file, the option, the port). ``Door.enter`` holds it to that.
"""

import re
import struct
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from zlib import crc32

from solarcal.config import Settings, read_toml, toml_text
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import ProtocolError, SolarcalError, harmless
from solarcal.instruments.catalogue import BY_ID
from solarcal.optics.disc_image import PNG
from solarcal.profile_form import profile_from_form
from solarcal.profiles import Profile
from solarcal.session.interchange import read_table
from solarcal.session.interchange.tpoint_model import read_tpoint_model
from solarcal.session.lines import sealed, torn_marker
from solarcal.session.view import read_session, view_session
from solarcal.session.voids import live_records
from solarcal.tui.keys import checked_keymap
from solarcal.two_mirror.scenario import load_mirror_scenario, mirror_scenario_names
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.frames import LineBuffer, decode_reply, decode_request

PORT = "socket://nonsense:1"


class DoorBroken(AssertionError):
    """What came out of a door is not what may."""


@dataclass(frozen=True, slots=True)
class Door:
    """One of them.

    Attributes
    ----------
    share : its part of all cases, in hundredths: the cheap doors get most.
    good : what belongs in.
    goes_in : lets bytes in.
    places : one of these is named by every refusal.
    """

    name: str
    share: int
    good: Callable[[], tuple[bytes, ...]]
    goes_in: Callable[[bytes], None]
    places: tuple[str, ...] = ()

    def enter(self, content: bytes) -> bool:
        """Whether it was taken; refused otherwise, in proper words.

        Raises
        ------
        DoorBroken
            A refusal without a place, of several lines, or with control characters in it.
        """
        try:
            self.goes_in(content)
        except SolarcalError as refusal:
            said = str(refusal)
            if "\n" in said or harmless(said) != said:
                raise DoorBroken(f"{self.name}: not one clean line: {said!r}") from refusal
            if self.places and not any(place in said for place in self.places):
                raise DoorBroken(f"{self.name}: no place named: {said!r}") from refusal
            return False
        return True


@cache
def _folder() -> Path:
    """Where the files under test lie: in memory where the system has such a place."""
    memory = Path("/dev/shm")
    return Path(tempfile.mkdtemp(prefix="fuzz-", dir=memory if memory.is_dir() else None))


def _file(name: str, content: bytes) -> Path:
    path = _folder() / name
    path.write_bytes(content)
    return path


# -- the wire --------------------------------------------------------------------------------------

REQUESTS = (
    "OPEN 5C0FFEE5", "ID", "UNLOCK", "CLOCK", "CLOCK SET 20260603T090000.000", "SITE",
    "SITE SET 35.05000 -106.48000 1830.0 7.00", "STATUS", "PARAM axis1.drive",
    "PARAM axis1.drive rotary:100.000000", "PARAM update_range 0.10000", "MODE TRACK", "STOP",
    "STOW", "JOG 10.00000 40.00000", "OFFSET SET", "REF START", "REF", "COEF", "COEF STORED",
    "COEF SET 0.0512 -0.1200 0.3000 0.0411 0.000300 -0.000100 0.0000 0.0000", "STORE", "X TIME",
    "X SPEED 2.000", "X ADVANCE 1.5", "X SPOT", "X SKY", "X TRUTH", "X FAULT miss1:20", "LOCK",
)  # fmt: skip


def _sealed(body: bytes) -> bytes:
    return body + b"*%08X\r\n" % crc32(body)


def _requests() -> tuple[bytes, ...]:
    return tuple(f">{seq:04X} {text}".encode() for seq, text in enumerate(REQUESTS))


def _into_frames(content: bytes) -> None:
    """Raw and with a right checksum, as request and as reply, whole and in pieces."""
    for line in (content, _sealed(content)):
        for decode in (decode_request, decode_reply):
            try:
                decode(line)
            except ProtocolError as error:
                if harmless(str(error)) != str(error):
                    raise DoorBroken(f"frames: not harmless: {error!r}") from error
    buffer = LineBuffer()
    for start in range(0, len(content), 17):
        for line in buffer.feed(content[start : start + 17]):
            if len(line) > 252:
                raise DoorBroken(f"a line of {len(line)} characters was stored")


@cache
def _scenario() -> "object":
    return load_scenario("tijeras-azel")


def _into_unit(content: bytes) -> None:
    """A unit that hears it, unsealed and sealed: proper replies, whatever it is."""
    unit = Emulator(_scenario(), monotonic=lambda: 0.0)  # type: ignore[arg-type]
    unit.handle_input(_sealed(b">F001 UNLOCK"))
    for line in (content + b"\r\n", _sealed(content)):
        for reply in unit.handle_input(line):
            decode_reply(reply)


class _SpoiltUnit:
    """A line on which somebody answers from a list, with right checksums."""

    def __init__(self, answers: bytes) -> None:
        pairs = [line.split(b"\t", 1) for line in answers.split(b"\n") if b"\t" in line]
        self._answers = {pair[0]: pair[1] for pair in pairs}
        self._replies: list[bytes] = []

    def write(self, data: bytes) -> None:
        request = decode_request(data)
        text = request.text.encode()
        said = request.arguments[0].encode() if request.verb == "OPEN" else b"NO 11 unknown"
        fields = self._answers.get(text, said)
        head = b"<%04X " % request.seq
        self._replies.append(
            _sealed(head + (fields if fields.startswith(b"NO ") else b"OK " + fields)).rstrip()
        )

    def read_line(self, timeout_s: float) -> bytes | None:
        return self._replies.pop() if self._replies else None

    def close(self) -> None: ...


def _ask_everything(unit: SolarTrakUnit) -> None:
    unit.open()
    unit.site()
    unit.parameters()
    unit.status()
    unit.stored()
    unit.ref_check_result()
    if unit.emulation is not None:
        for ask in (unit.emulation.time, unit.emulation.spot, unit.emulation.sky):
            ask()
        unit.emulation.truth()


def _answers() -> tuple[bytes, ...]:
    """What an emulated unit answers to all of it."""
    emulator = Emulator(load_scenario("heliostat"))
    answers: list[bytes] = []

    class Listening:
        def __init__(self) -> None:
            self.replies: list[bytes] = []

        def write(self, data: bytes) -> None:
            replies = emulator.handle_input(data)
            self.replies += [reply.rstrip() for reply in replies]
            request, reply = decode_request(data), decode_reply(replies[0])
            if request.verb != "OPEN" and not reply.refused:
                answers.append(f"{request.text}\t{' '.join(reply.fields)}".encode())

        def read_line(self, timeout_s: float) -> bytes | None:
            return self.replies.pop(0) if self.replies else None

        def close(self) -> None: ...

    _ask_everything(SolarTrakUnit(Listening))
    return (b"\n".join(answers),)


def _into_driver(content: bytes) -> None:
    _ask_everything(
        SolarTrakUnit(lambda: _SpoiltUnit(content), port=PORT, timing=Timing(1.0, 1.0, 1, 1))
    )


# -- files -----------------------------------------------------------------------------------------


def _sessions() -> tuple[bytes, ...]:
    folder = Path(__file__).parent.parent / "sessions"
    lines = (folder / "azel-aborted-and-rejected.jsonl").read_bytes().splitlines(keepends=True)
    torn = b"".join(lines[:3]) + b'{"type":"no\n' + torn_marker(12) + b"".join(lines[3:6])
    # Short ones: damage then meets headers and every kind of record.
    kinds = {line.partition(b",")[0]: line for line in lines[1:]}
    first = lines[0] + b"".join(
        _numbered(line, seq)
        for seq, line in enumerate((line for line in lines if line in kinds.values()), start=1)
    )
    whole = (b"".join(lines[:9]), b"".join((*lines[:3], _numbered(lines[-1], 3))), first, torn)
    return (*whole, *map(_of_format_1, whole))


def _numbered(line: bytes, seq: int) -> bytes:
    return sealed(re.sub(rb'"seq":\d+', b'"seq":%d' % seq, line))


def _of_format_1(content: bytes) -> bytes:
    """Without checksums: damage then reaches the records."""
    older = re.sub(rb',"crc32c":"[0-9a-f]{8}"', b"", content)
    return older.replace(b'"format":2', b'"format":1')


def _into_session(content: bytes) -> None:
    path = _file("spoilt.jsonl", content)
    session = read_session(path)
    live_records(session.records)
    view_session(session.header, session.records)
    read_table(path)


CSV = b"""# geometry=azel
# remark, of no meaning
# lat_deg=35.05
# lon_deg=-106.48
# elevation_m=1830
# ideal=apparent
# target=180.0:85.0:100.0
utc,ax1_deg,ax2_deg,err1_deg,err2_deg,sigma_deg,status,approach1,approach2,note
2026-06-21T15:30:00Z,61.123,54.25,0.27,0.25,0.03,accepted,1,-1,"first, quoted"
,12.5,20.25,0.1,-0.3,0.03,,,,
2026-06-21T19:30:00Z,-10.0,14.25,0.2,0.15,0.03,rejected,-1,1,cloud
"""
TPOINT = b"""Rubin AuxTel, made up
: ALTAZ
: ROTNR
-30 14 40.68
210.3 45.2 210.25 45.18
123.456 60.5 123.46 60.52 7.1
350.0 33.3 350.01 33.31
END
"""
SEXAGESIMAL = b"""Made up, twelve columns
: ALTAZ
+35.05 2026 06 21.5 12.0 780.0 2700.0 0.3
085 40 02.2 +54 29 25.1 085 38 22.2 +54 32 45.1 ; cloud
;133 11 01.9 +57 10 35.0 133 09 21.9 +57 13 55.0
225 15 33.5 -00 56 55.7 225 13 53.5 -01 00 15.7
END
"""
PMFIT = b"""made up
A
-30.24
264.465524  28.162130 264.433446  28.271060
259.687217  29.877367 259.655032  29.985096 17.5
"""
OFFSETS = b"""# Location: MZS, Antarctica
# latitude: -74.7
# azimuth: of the Sun's centroid from ephemerides [deg]
# offset_az: observed azimuth - solar azimuth [deg]

map_id\ttimestamp\tazimuth\televation\toffset_az\toffset_el\ttemperature
a1\t2026-01-03T00:02:35Z\t14.66\t37.78\t-0.0829\t0.0700\tNaN
a2\t2026-01-03T00:32:35Z\t4.66\t38.00\tNaN\tNaN\t-2.5
"""
MODEL = b"""made up
T   61   17.4100   0.0000   0.0000
  IA      -211.1600    3.5000
& IE      -255.5500    2.5000
= TX       +60.0000
END
"""


def _into_csv(content: bytes) -> None:
    read_table(_file("spoilt.csv", content))


def _into_tpoint(content: bytes) -> None:
    read_table(_file("spoilt.dat", content))


def _into_offsets(content: bytes) -> None:
    read_table(_file("spoilt.tsv", content))


PAINT_TOWER = b"""{"power_plant_properties": {"ID": "X", "coordinates": [50.9, 6.4, 88.0]},
 "upper": {"coordinates": {"center": [50.9, 6.4, 130.0]}}}"""
PAINT_HELIOSTAT = b"""{"heliostat_position": [50.9007, 6.4002, 89.0], "kinematic_properties": {
 "actuators": [
  {"type_axis": "linear", "clockwise_axis_movement": false, "increment": 154166.7,
   "initial_stroke_length": 0.075, "offset": 0.34061, "pivot_radius": 0.3204,
   "initial_angle": -1.570796},
  {"type_axis": "linear", "clockwise_axis_movement": true, "increment": 154166.7,
   "initial_stroke_length": 0.075, "offset": 0.3479, "pivot_radius": 0.309,
   "initial_angle": 0.959931}]}}"""
PAINT_RECORD = b"""{"motor_position": {"Axis1MotorPosition": 31521, "Axis2MotorPosition": 48000},
 "target_name": "upper", "Sun_elevation": 41.5, "Sun_azimuth": -22.1,
 "focal_spot": {"HeliOS": [50.9, 6.4, 129.9], "UTIS": [50.9, 6.4, 130.1]}}"""


def _into_paint(content: bytes) -> None:
    """The bytes as each of the three files that belong together."""
    files = {"spoilt-record.json": PAINT_RECORD, "spoilt-heliostat.json": PAINT_HELIOSTAT,
             "spoilt-tower.json": PAINT_TOWER}  # fmt: skip
    refusals = []
    for spoilt in files:
        record, heliostat, tower = (
            _file(name, content if name == spoilt else good) for name, good in files.items()
        )
        try:
            read_table(record, heliostat=heliostat, tower=tower)
        except SolarcalError as refusal:
            refusals.append(refusal)
    if len(refusals) == len(files):
        raise refusals[0]


@cache
def _images() -> tuple[bytes, ...]:
    """A bright disc as each kind of image that is read."""
    width, height = 24, 20
    rows = [
        bytes(220 if (x - 12) ** 2 + (y - 10) ** 2 < 36 else 20 for x in range(width))
        for y in range(height)
    ]
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows), 0)))
    png = b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in (*parts, (b"IEND", b""))
    )
    size = f"{width} {height}\n255\n".encode()
    text = b"\n".join(b" ".join(b"%d" % grey for grey in row) for row in rows)
    return b"P5\n# made up\n" + size + b"".join(rows), b"P2\n" + size + text, PNG + png


def _into_image(content: bytes) -> None:
    values = {"image": str(_file("spoilt.png", content)), "t1": "20", "t2": "40"}
    camera = BY_ID["mirrors-camera"]
    camera.answer(camera.form(values, 0.0, {"image": "--image"}))


def _into_model(content: bytes) -> None:
    read_tpoint_model(_file("spoilt.mod", content))


PROFILE = b"""name = "default"
operator = "J. Smith"
pointing_device = "plate, 1 m"
tolerance_deg = 0.1
port = "socket://127.0.0.1:7777"
driver = "solartrak"
baudrate = 9600

[site]
latitude_deg = 35.05
longitude_deg = -106.48
elevation_m = 1830.0
name = "Tijeras"

[weather]
pressure_hpa = 812.0
temperature_c = 20.0

[inclinometer]
lean_north_deg = 0.1
lean_east_deg = -0.2
sigma_deg = 0.05
"""
SETTINGS = b"""theme = "phosphor"
profile = "default"

[last]
scenario = "tijeras-azel"
settings = ["truth.lean_deg=1.0"]
seed = 3

[lines."a-2026-06-03.jsonl"]
port = "/dev/ttyUSB0"
baudrate = 9600

[calculators.sunspot]
height = "24"
"""
KEYMAP = b'take_point = "f7,full_stop"\nstop = "s"\nref_check = "alt+f5"\n'


def _into_profile(content: bytes) -> None:
    read_toml(_file("spoilt.toml", content), Profile)


def _into_settings(content: bytes) -> None:
    settings = read_toml(_file("spoilt.toml", content), Settings)
    # What was read can be written and is the same again.
    import msgspec

    again = _file("again.toml", toml_text(msgspec.to_builtins(settings)).encode())
    if read_toml(again, Settings) != settings:
        raise DoorBroken("settings: written and read again they differ")


def _into_keymap(content: bytes) -> None:
    checked_keymap(read_toml(_file("keymap.toml", content), dict[str, str]))


FORM = b"""name\tdefault
operator\tJ. Smith
tolerance_deg\t0.1
port\tCOM3
baudrate\t9600
latitude_deg\t35.05
longitude_deg\t-106.48
elevation_m\t1830
pressure_hpa\t812
temperature_c\t15
lean_north_deg\t0.1
lean_east_deg\t0.2
lean_sigma_deg\t0.05
"""


def _into_form(content: bytes) -> None:
    pairs = (line.split("\t", 1) for line in content.decode(errors="replace").split("\n"))
    typed = {pair[0]: pair[1] for pair in pairs if len(pair) == 2}
    good = dict(line.split("\t") for line in FORM.decode().splitlines())
    profile_from_form({**dict.fromkeys(("pointing_device", "site_name"), ""), **good, **typed})


# -- scenarios -------------------------------------------------------------------------------------

SCENARIO = b"""extends = "southern"
start = "2026-12-21"
[site]
latitude_deg = -33.9
longitude_deg = 18.4
zone_west_h = -2.0
[unit]
drive1 = "rotary:100"
limits1_deg = [-120.0, 120.0]
coefficients = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
[truth]
lean_deg = 1.5
lean_bearing_deg = 45
P5 = 0.001
backlash1_deg = 0.2
sun = "precise"
missed_counts = [{ at = "+90min", axis = 2, counts = -40 }]
[plan]
points = 9
"""
SETS = (
    b"truth.lean_deg=1.2", b"start=2026-06-21T15:30:00Z", b"unit.drive1=rotary:100.0",
    b"unit.drive2=screwjack:2:3:0.1:20:1000:+", b"site.latitude_deg=-33.9",
    b'truth.missed_counts=[{at="+4h", axis=1, counts=300}]', b"unit.limits1_deg=[-100, 100]",
    b"unit.target=[180.0, 85.0, 100.0]", b"truth.refraction=none", b"plan.points=4",
)  # fmt: skip


def _scenarios() -> tuple[bytes, ...]:
    folder = resources.files("solarcal.emulator") / "scenarios"
    names = ("tropical", "heliostat")
    return (SCENARIO, *((folder / f"{name}.toml").read_bytes() for name in names))


def _into_scenario(content: bytes) -> None:
    scenario = load_scenario(_file("spoilt.toml", content))
    scenario.start_utc_s()


def _into_set(content: bytes) -> None:
    load_scenario("tijeras-azel", [content.decode(errors="replace")])


def _mirror_scenarios() -> tuple[bytes, ...]:
    folder = resources.files("solarcal.two_mirror") / "scenarios"
    return tuple((folder / f"{name}.toml").read_bytes() for name in mirror_scenario_names())


def _into_mirror_scenario(content: bytes) -> None:
    load_mirror_scenario(str(_file("spoilt.toml", content)))


DOORS: tuple[Door, ...] = (
    Door("frames", 21, _requests, _into_frames),
    Door("unit", 2, _requests, _into_unit),
    Door("driver", 4, _answers, _into_driver, (PORT, "the unit refused")),
    Door("session", 15, _sessions, _into_session, ("spoilt.jsonl",)),
    Door("csv", 12, lambda: (CSV,), _into_csv, ("spoilt.csv",)),
    Door("tpoint", 10, lambda: (TPOINT, SEXAGESIMAL), _into_tpoint, ("spoilt.dat",)),
    Door("pmfit", 2, lambda: (PMFIT,), _into_tpoint, ("spoilt.dat",)),
    Door("offsets", 3, lambda: (OFFSETS,), _into_offsets, ("spoilt.tsv",)),
    Door(
        "paint",
        2,
        lambda: (PAINT_RECORD, PAINT_HELIOSTAT, PAINT_TOWER),
        _into_paint,
        ("spoilt-",),
    ),
    Door("image", 1, _images, _into_image, ("--image",)),
    Door("model", 1, lambda: (MODEL,), _into_model, ("spoilt.mod",)),
    Door("profile", 8, lambda: (PROFILE,), _into_profile, ("spoilt.toml",)),
    Door("profile form", 6, lambda: (FORM,), _into_form, (":",)),
    Door("settings", 6, lambda: (SETTINGS,), _into_settings, ("spoilt.toml",)),
    Door("keymap", 3, lambda: (KEYMAP,), _into_keymap, ("keymap.toml",)),
    Door("scenario", 2, _scenarios, _into_scenario, ("spoilt.toml", "start ")),
    Door("--set", 1, lambda: SETS, _into_set, ("--set",)),
    Door("two-mirror scenario", 1, _mirror_scenarios, _into_mirror_scenario, ("spoilt.toml",)),
)
