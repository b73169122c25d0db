"""Certificates written to a folder: every format asked for, and the zip for the office.

The zip holds everything that is filed about a calibration, and checks itself.
"""

import io
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import msgspec

from solarcal.config import toml_text
from solarcal.errors import ConfigurationError
from solarcal.profiles import Profile
from solarcal.report.certificate import (
    SourceFile,
    certificate_text,
    make_certificate,
    read_sources,
    signed_off,
)
from solarcal.session.interchange import FillIn
from solarcal.session.records import Header
from solarcal.station.analysing import FileAnalysis, RuleChanges, analyse_files, read_files
from solarcal.station.sign_off import SignOff

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest a zip can tell: the archive must not depend on when it was packed."""

README = """\
The certificate, the files it rests on, the profile of site, unit and operator, and the checksums
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
    method: str | None = None,
    **changes: Unpack[RuleChanges],
) -> Issued:
    """Judge files and write the certificate in the format of each output's ending.

    The zip stands beside the first output and holds it.

    Raises
    ------
    SolarcalError
        A file cannot be read or fitted, was written to meanwhile, or an output cannot be written.
    """
    sources = read_sources(files)
    judged = analyse_files(
        read_files(files, fill_in),
        method=method,
        **changes,
    )
    if read_sources(files) != sources:
        raise ConfigurationError(
            "a session was written to meanwhile; the certificate would not match its checksum: "
            "do this again"
        )
    certificate = make_certificate(judged, sources)
    written = [
        SourceFile(path.name, certificate_text(certificate, path.suffix).encode())
        for path in outputs
    ]
    contents = [(path, source.content) for path, source in zip(outputs, written, strict=True)]
    if zip_too:
        archive = office_zip(written[0], sources, judged.header)
        contents.append((outputs[0].with_suffix(".zip"), archive))
    for path, content in contents:
        _write(path, content)
    return Issued(
        tuple(path for path, _ in contents), written[0].sha256, judged, signed_off(judged)
    )


def _write(path: Path, content: bytes) -> None:
    """Whole or not at all; an older certificate of the name is replaced."""
    beside = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.write_bytes(content)
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise ConfigurationError(f"{path} cannot be written: {error.strerror}") from None


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
        for file in (*files, SourceFile("SHA256SUMS", sums.encode())):
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
    )
    return toml_text(msgspec.to_builtins(profile))
