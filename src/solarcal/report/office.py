"""Everything the office files about a calibration, in one zip that checks itself."""

import io
import zipfile
from collections.abc import Sequence

import msgspec

from solarcal.config import toml_text
from solarcal.profiles import Profile
from solarcal.report.certificate import SourceFile
from solarcal.session.records import Header

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest a zip can tell: the archive must not depend on when it was packed."""

README = """\
The certificate, the files it rests on, the profile of site, unit and operator, and the checksums
of all of them (sha256sum -c SHA256SUMS).
"""


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
