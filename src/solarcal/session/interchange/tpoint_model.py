"""TPOINT model files (``.mod``), in and out.

caption
T   61   17.41   0.00   0.00     method, observations, sky rms (arcsec), refraction constants
  IA      -211.16   3.50         term, value, sigma, arcsec; =IA is fixed and has no sigma
END
"""

from dataclasses import dataclass
from pathlib import Path

from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_text, write_whole
from solarcal.session.interchange.altaz import plain_numbers

_FLAGS = "=&"


@dataclass(frozen=True, slots=True)
class TpointModel:
    """A published pointing model. Values and sigmas in arcsec; sigma None where it has none."""

    caption: str
    method: str
    observations: int | None
    sky_rms_arcsec: float | None
    names: tuple[str, ...]
    values: tuple[float, ...]
    sigmas: tuple[float | None, ...]


def read_tpoint_model(path: str | Path) -> TpointModel:
    """Read a model; whether the terms are known is the fit's to say.

    Raises
    ------
    InputFileError
        A line that is none of the format, named.
    """
    lines = [
        (number, line.split())
        for number, line in enumerate(read_text(path).splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith(("!", "#"))
    ]
    if len(lines) < 3:
        raise InputFileError(
            f"{path}: a TPOINT model has a caption, a line with method, observations and sky rms, "
            "and terms"
        )
    (_, caption), (at, summary) = lines[:2]
    numbers = plain_numbers(summary[1:])
    if not summary[0].isalpha() or len(numbers) < 2:
        raise InputFileError(
            f"{path}:{at}: the method, the number of observations and the sky rms come here"
        )
    terms: dict[str, tuple[float, float | None]] = {}
    ended = False
    for number, cells in lines[2:]:
        if cells[0].upper() == "END":
            ended = True
            break
        where = f"{path}:{number}"
        # A flag may stand apart from its term.
        name = cells[0].lstrip(_FLAGS) or (cells.pop(0) and cells[0] if len(cells) > 1 else "")
        if not name:
            raise InputFileError(f"{where}: no term after {cells[0][:5]!r}")
        values = plain_numbers(cells[1:])
        if not values or len(values) < len(cells) - 1 or len(values) > 2:
            raise InputFileError(f"{where}: a term, its value and its sigma in arcsec come here")
        if name.upper() in terms:
            raise InputFileError(f"{where}: term {name.upper()} is given twice")
        terms[name.upper()] = (values[0], values[1] if len(values) > 1 else None)
    if not terms:
        raise InputFileError(f"{path}: no term is in the model")
    if not ended:
        raise InputFileError(f"{path} has no END line: the model may have been cut short")
    return TpointModel(
        caption=" ".join(caption),
        method=summary[0],
        observations=int(numbers[0]) if numbers[0] == int(numbers[0]) else None,
        sky_rms_arcsec=numbers[1],
        names=tuple(terms),
        values=tuple(value for value, _ in terms.values()),
        sigmas=tuple(sigma for _, sigma in terms.values()),
    )


def write_tpoint_model(model: TpointModel, path: str | Path) -> None:
    """Write a model, four decimals of an arcsecond; a term without sigma is written as fixed.

    Raises
    ------
    ConfigurationError
        The file cannot be written.
    """
    if model.observations is None or model.sky_rms_arcsec is None:
        raise ConfigurationError("a TPOINT model needs the number of observations and the sky rms")
    lines = [
        model.caption,
        f"{model.method} {model.observations:5d} {model.sky_rms_arcsec:9.4f} {0.0:9.4f} {0.0:9.4f}",
    ]
    for name, value, sigma in zip(model.names, model.values, model.sigmas, strict=True):
        flag = "=" if sigma is None else " "
        spread = "" if sigma is None else f" {sigma:12.5f}"
        lines.append(f"{flag} {name:<8s} {value:+z14.4f}{spread}")
    write_whole(path, "\n".join([*lines, "END", ""]))
