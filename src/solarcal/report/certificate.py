"""A calibration on paper: built once as renderables, written as html, md, svg or txt.

Nothing in it but the files it is made of and this program's version: the same files give the same
certificate to the last byte. The date of issue is written by the hand that signs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np

from solarcal import __version__
from solarcal.errors import ConfigurationError
from solarcal.input_files import read_bytes
from solarcal.report.blocks import Certificate, Facts, Section, Signatures, Table, plain_text
from solarcal.report.certificate_sections import (
    after_section,
    coefficients_section,
    evidence_section,
    forecast_section,
    points_section,
    subject_section,
    verdict_section,
)
from solarcal.report.judgement import STATE_WORDS
from solarcal.report.markup import html_text, markdown_text, svg_text
from solarcal.session.points import PointTable
from solarcal.station.analysing import FileAnalysis
from solarcal.station.sign_off import SignOff, sign_off
from solarcal.timescale import format_utc

WRITERS: dict[str, Callable[[Certificate], str]] = {
    ".html": html_text,
    ".md": markdown_text,
    ".svg": svg_text,
    ".txt": plain_text,
}


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A file a certificate rests on, as it was read."""

    name: str
    content: bytes

    @property
    def sha256(self) -> str:
        return sha256(self.content).hexdigest()


def read_sources(paths: Sequence[Path]) -> tuple[SourceFile, ...]:
    """The files byte for byte.

    Raises
    ------
    InputFileError
        One of them cannot be read.
    """
    sources = []
    for path in paths:
        sources.append(SourceFile(path.name, read_bytes(path)))
    return tuple(sources)


def signed_off(judged: FileAnalysis) -> SignOff:
    """The uploads and check points of the files, judged by their tolerance."""
    return sign_off(judged.sessions, judged.tolerance_deg)


def make_certificate(judged: FileAnalysis, sources: Sequence[SourceFile]) -> Certificate:
    """The certificate of files already judged; ``sources`` are the same files' bytes."""
    judgement = judged.of_the_controller()
    after = signed_off(judged)
    header = judged.header
    unit = judged.table.unit or "unit not named"
    days = _days(judged.table)
    return Certificate(
        title="Calibration certificate",
        subject=f"{unit}, {judged.table.geometry}, {days}",
        status=f"{'SIGNED OFF' if after.signed_off else 'Not signed off'}: {after.reason}. "
        f"Verdict: {STATE_WORDS[judgement.verdict.state]}.",
        sections=(
            subject_section(judged, header),
            verdict_section(judgement),
            after_section(judged, after),
            coefficients_section(judgement.solution),
            points_section(judged),
            forecast_section(judgement, judged.tolerance_deg),
            *evidence_section(judged),
            _origin_section(judged, sources),
            Section("Signatures", (Signatures(("Technician", "Accepted for the owner")),)),
        ),
    )


def _days(table: PointTable) -> str:
    times = table.accepted().utc_s
    days = sorted({format_utc(float(time), 0)[:10] for time in times[np.isfinite(times)]})
    if not days:
        return "date not known"
    return days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}"


def _origin_section(judged: FileAnalysis, sources: Sequence[SourceFile]) -> Section:
    written_by = sorted({session.header.software for session in judged.sessions})
    return Section(
        "Where this comes from",
        (
            Facts(
                (
                    ("made by", f"solarcal {__version__}"),
                    *((("sessions written by", ", ".join(written_by)),) if written_by else ()),
                )
            ),
            Table(
                ("file", "sha256"),
                tuple((source.name, source.sha256) for source in sources),
                "<<",
            ),
        ),
    )


def certificate_text(certificate: Certificate, ending: str) -> str:
    """The certificate in the format of a file name's ending.

    Raises
    ------
    ConfigurationError
        Another ending.
    """
    writer = WRITERS.get(ending.lower())
    if writer is None:
        raise ConfigurationError(
            f"a certificate is written as {', '.join(WRITERS)}; {ending or 'no ending'} is none "
            "of them"
        )
    return writer(certificate)
