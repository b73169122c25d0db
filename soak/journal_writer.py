"""A program that writes to a journal as fast as it can, to be killed.

For every path read from stdin it forks: the child begins or resumes that session and says the
number of each record on stdout once ``append`` has returned. ``text_of`` tells what it wrote.
"""

import os
import random
import sys
from pathlib import Path

from solarcal.mount.drive import RotaryDrive
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.session.journal import Journal
from solarcal.session.records import Header, Note, UnitRecord
from solarcal.site import Site

UTC = "2026-06-21T15:30:00.000Z"
SITE = Site(35.05, -106.48, 1830.0)
HEADER = Header(
    utc=UTC,
    software="soak",
    unit=UnitRecord(
        model="SOAK",
        serial="0001",
        firmware="1",
        zone_west_h=7.0,
        drive1=RotaryDrive(counts_per_deg=100.0),
        drive2=RotaryDrive(counts_per_deg=100.0),
        limits=Limits(AxisLimits(-120.0, 120.0), AxisLimits(5.0, 88.0)),
        update_range_deg=0.1,
        reference1_deg=0.0,
        reference2_deg=85.0,
        tilt_decimals=4,
        scale_decimals=6,
        site=SITE,
    ),
    site=SITE,
    geometry="azel",
    ax1_centre_deg=0.0,
)


def text_of(seq: int) -> str:
    """What record ``seq`` says: mostly short, sometimes many pages, so that a kill can tear it."""
    length = 200_000 if seq % 7 == 3 else seq * 37 % 700
    return f"{seq}:" + "x" * length


def note(seq: int) -> Note:
    return Note(seq=seq, utc=UTC, text=text_of(seq))


def write_for_ever(path: Path, batches: random.Random) -> None:
    journal = Journal.resume(path) if path.exists() else Journal.create(path, HEADER)
    _say(0)
    while True:
        first = journal.next_seq
        journal.append_all([note(first + i) for i in range(batches.randint(1, 3))])
        _say(journal.next_seq - 1)


def _say(seq: int) -> None:
    os.write(sys.stdout.fileno(), f"{seq}\n".encode())


def main() -> None:
    for number, line in enumerate(sys.stdin):
        child = os.fork()
        if not child:
            os.write(sys.stdout.fileno(), f"child {os.getpid()}\n".encode())
            write_for_ever(Path(line.rstrip("\n")), random.Random(number))
        os.waitpid(child, 0)
        os.write(sys.stdout.fileno(), b"dead\n")


if __name__ == "__main__":
    main()
