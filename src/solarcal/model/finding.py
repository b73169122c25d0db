"""What was found out about a tracker, or what these points cannot tell."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

Certainty = Literal["found", "not_determinable"]

Kind = Literal[
    "clock_offset",
    "clock_step",
    "clock_drift",
    "laptop_clock",
    "missed_counts",
    "unit_sun",
    "frozen",
    "backlash",
    "collimation",
    "nonperpendicularity",
    "cross_axis",
    "sag",
    "refraction",
    "unmodelled",
    "bad_point",
    "degeneracy",
    "moved",
    "branch",
    "time_stamps",
    "site",
    "geometry",
    "ideal_kind",
    "offsets",
    "counts",
    "limits",
    "answers",
    "another_unit",
    "contradiction",
    "restarted",
    "upload",
    "check_point",
    "not_held",
    "not_proven",
    "last_coefficients",
    "inclinometer",
    "step",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One cause, said in one sentence.

    Attributes
    ----------
    kind : ``cross_axis``: collimation or axes not square, which of them the points do not say;
        ``unmodelled``: a pattern that several causes would explain.
    subject : where: ``unit clock``, ``axis 1``, ``point 7``, ``collimation``.
    sentence : for the technician, with its number and, where there is one, the cure.
    certainty : ``found``, or ``not_determinable`` with these points: neither found nor excluded.
    number, sigma, unit : how large, and its standard deviation; None where there is no number.
    direct : seen (clocks, counts, read-outs), not inferred from residuals.
    labels : the points concerned.
    causes : the kinds that explain it about equally well, the best first; for a named cause itself.
    leaves_deg : residual rms on sky that each of ``causes`` would leave, in the same order.
    effect_deg : how much of the points' residual rms on sky it makes.
    """

    kind: Kind
    subject: str
    sentence: str
    certainty: Certainty = "found"
    number: float | None = None
    sigma: float | None = None
    unit: str = "deg"
    direct: bool = False
    labels: tuple[int, ...] = ()
    causes: tuple[str, ...] = ()
    leaves_deg: tuple[float, ...] = ()
    effect_deg: float | None = None

    def as_json(self) -> dict[str, Any]:
        """The contract's keys (``points`` are the labels concerned) and all the others."""
        document = asdict(self)
        return {**document, "points": list(self.labels)}


def listed(names: tuple[str, ...] | list[str], word: str = "and") -> str:
    """'a', 'a and b', 'a, b and c'."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"


MOST_NAMED = 6


def points_named(labels: tuple[int, ...]) -> str:
    """'point 3', 'points 3 and 4', 'points 1, 2, 3, 4, 5, 6 and 5 more'."""
    names = [str(label) for label in labels[:MOST_NAMED]]
    if len(labels) > MOST_NAMED:
        return f"points {', '.join(names)} and {len(labels) - MOST_NAMED} more"
    return f"point{'s' if len(labels) > 1 else ''} {listed(names)}"
