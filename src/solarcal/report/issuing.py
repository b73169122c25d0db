"""Certificates written to a folder: every format asked for, and the zip for the office."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.report.certificate import (
    SourceFile,
    certificate_text,
    make_certificate,
    read_sources,
    signed_off,
)
from solarcal.report.office import office_zip
from solarcal.session.interchange import FillIn
from solarcal.station.analysing import FileAnalysis, analyse_files, read_files
from solarcal.station.sign_off import SignOff


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
    tolerance_deg: float | None = None,
    done_probability: float | None = None,
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
        tolerance_deg=tolerance_deg,
        done_probability=done_probability,
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
