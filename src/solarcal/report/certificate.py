"""A calibration on paper: built once as renderables, written as html, md, svg or txt.

Nothing in it but the files it is made of and this program's version: the same files give the same
certificate to the last byte. The date of issue is written by the hand that signs.

It is issued to a folder in every format asked for; the zip for the office holds everything that is
filed about a calibration, and checks itself.
"""

import io
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import msgspec
import numpy as np

from solarcal import __version__
from solarcal.config import toml_text
from solarcal.errors import ConfigurationError
from solarcal.input_files import STANDARD_INPUT, read_bytes, reason_of, write_whole
from solarcal.profiles import Profile
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
from solarcal.report.markup import html_text, markdown_text, svg_text
from solarcal.session.interchange import FillIn
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.analysing import FileAnalysis, UnitFiles, analyse_files, read_files
from solarcal.station.judging import Judging
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
    """The files byte for byte; InputFileError where one cannot be read."""
    # In an archive, sha256sum would take a dash for its own standard input.
    names = ("standard-input" if str(path) == STANDARD_INPUT else path.name for path in paths)
    return tuple(
        SourceFile(name, read_bytes(path)) for name, path in zip(names, paths, strict=True)
    )


def signed_off(judged: FileAnalysis) -> SignOff:
    """The uploads and check points of the files, judged by their tolerance."""
    return sign_off(judged.sessions, judged.analysis)


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
        status=f"{after.sentence} Verdict: {judgement.verdict.words}.",
        sections=(
            subject_section(judged, header),
            verdict_section(judgement),
            after_section(judged, after),
            coefficients_section(judgement),
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
                ("file", "sha256"), tuple((source.name, source.sha256) for source in sources), "<<"
            ),
        ),
    )


_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest a zip can tell: the archive must not depend on when it was packed."""
_SUMS = "SHA256SUMS"
_HEAD_BYTES = 1000
"""Within so many every format says what it is."""

README = """\
The certificate, the files it uses, the profile of site, unit and operator, and the checksums
of all of them (sha256sum -c SHA256SUMS).
"""


@dataclass(frozen=True, slots=True)
class Issued:
    """What was written, the first certificate first, and what it says."""

    paths: tuple[Path, ...]
    sha256: str
    judged: FileAnalysis
    after: SignOff


def issue(
    files: Sequence[Path],
    fill_in: FillIn,
    outputs: Sequence[Path],
    *,
    zip_too: bool,
    judging: Callable[[UnitFiles], Judging] = lambda files: {},
) -> Issued:
    """Judge files and write the certificate in the format of each output's ending.

    The zip stands beside the first output and holds it. ``judging``: how, for the files read.

    Raises
    ------
    SolarcalError
        A file cannot be read or fitted, was written to meanwhile, or an output cannot be written,
        its ending being none of ``WRITERS`` among the reasons, or holds something else.
    """
    for output in outputs:
        if output.suffix.lower() not in WRITERS:
            raise ConfigurationError(
                f"{output}: a certificate is written as {', '.join(WRITERS)}; choose by the ending"
            )
    archives = [outputs[0].with_suffix(".zip")] if zip_too else []
    for path in (*outputs, *archives):
        _refuse_to_replace(path)
    sources = read_sources(files)
    read = read_files(files, fill_in)
    judged = analyse_files(read, **judging(read))
    if read_sources(files) != sources:
        raise ConfigurationError(
            "a session was written to meanwhile; the certificate would not match its checksum: "
            "do this again"
        )
    certificate = make_certificate(judged, sources)
    written = [
        SourceFile(path.name, WRITERS[path.suffix.lower()](certificate).encode())
        for path in outputs
    ]
    contents = [(path, source.content) for path, source in zip(outputs, written, strict=True)]
    contents += [(path, office_zip(written[0], sources, judged.header)) for path in archives]
    for path, content in contents:
        write_whole(path, content, make_folder=True)
    return Issued(
        tuple(path for path, _ in contents), written[0].sha256, judged, signed_off(judged)
    )


def _refuse_to_replace(path: Path) -> None:
    """A certificate of earlier points is replaced; a field book or a session by that name not."""
    try:
        ours = not path.is_file() or _is_certificate(path)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be replaced: {reason_of(error)}") from error
    if not ours:
        raise ConfigurationError(
            f"{path} exists and is not a certificate: it is not replaced; give another name"
        )


def _is_certificate(path: Path) -> bool:
    if path.suffix.lower() != ".zip":
        with path.open("rb") as file:
            return b"calibration certificate" in file.read(_HEAD_BYTES).lower()
    try:
        with zipfile.ZipFile(path) as archive:
            return _SUMS in archive.namelist()
    except (zipfile.BadZipFile, ValueError):
        return False


def office_zip(
    certificate: SourceFile, sources: Sequence[SourceFile], header: Header | None
) -> bytes:
    """The archive; the same inputs give the same bytes.

    Sources of one name (from several folders) are numbered.
    """
    files = [certificate]
    taken = {certificate.name.lower(), "profile.toml", "sha256sums", "readme.txt"}
    for source in sources:
        name, number = source.name, 1
        while name.lower() in taken:
            number += 1
            stem, dot, ending = source.name.rpartition(".")
            name = f"{stem}-{number}{dot}{ending}" if stem else f"{source.name}-{number}"
        taken.add(name.lower())
        files.append(SourceFile(name, source.content))
    if header is not None:
        files.append(SourceFile("profile.toml", session_profile_toml(header).encode()))
    files.append(SourceFile("README.txt", README.encode()))
    sums = "".join(f"{file.sha256}  {file.name}\n" for file in files)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in (*files, SourceFile(_SUMS, sums.encode())):
            entry = zipfile.ZipInfo(file.name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, file.content)
    return packed.getvalue()


def session_profile_toml(header: Header) -> str:
    """The profile a session was taken with, as its own file form.

    From the session, not from the machine that writes the zip: that may be another one.
    """
    imported = header.unit.imported
    profile = Profile(
        name=f"{header.unit.model} {header.unit.serial}"[:40].strip(),
        operator=header.operator,
        pointing_device=header.pointing_device,
        tolerance_deg=header.tolerance_deg,
        done_probability=header.done_probability,
        site=None if imported and header.unknown else header.site,
        weather=header.weather,
        last_coefficients=None
        if header.last_coefficients is None
        else header.last_coefficients.as_tuple(),
        bolt_circle=header.bolt_circle,
    )
    return toml_text(msgspec.to_builtins(profile))
