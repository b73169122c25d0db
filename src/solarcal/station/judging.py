"""By what files are judged: what their sessions were judged by, or what is asked for instead."""

from collections.abc import Callable, Mapping, Sequence
from typing import TypedDict, Unpack

from solarcal.model.evidence.clocks import clock_sigma_s
from solarcal.model.finding import listed
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import Coefficients
from solarcal.session.records import Header
from solarcal.session.view import SessionView
from solarcal.site import BoltCircle
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, strictest


class RuleChanges(TypedDict, total=False):
    """What is asked for instead of what a session was judged by; None: no change."""

    tolerance_deg: float | None
    done_probability: float | None
    unmodelled: Mapping[str, float] | None


class Judging(RuleChanges, total=False):
    """How to judge files, and what is known instead of what their header knows; None: as it is."""

    method: str | None
    last_coefficients: Coefficients | None
    bolt_circle: BoltCircle | None


def stopping_rule(
    sessions: Sequence[SessionView],
    *,
    tolerance_deg: float | None = None,
    done_probability: float | None = None,
    unmodelled: Mapping[str, float] | None = None,
) -> StoppingRule:
    """The strictest of the sessions, its clock as well known as the worst of all, with changes."""
    rules = [session.header.rule for session in own_sessions(sessions)]
    rule = strictest(rules) if rules else DEFAULT_RULE
    clocks = [clock_sigma_s(session) for session in sessions]
    beside = rule.unmodelled.with_clock(max(clocks)) if clocks else rule.unmodelled
    return StoppingRule(
        rule.tolerance_deg if tolerance_deg is None else tolerance_deg,
        rule.probability if done_probability is None else done_probability,
        beside.changed(unmodelled or {}),
    )


def own_sessions(sessions: Sequence[SessionView]) -> Sequence[SessionView]:
    """Those of a unit, where there are any: an import has placeholders in its header."""
    return [one for one in sessions if not one.header.unit.imported] or sessions


def asked_for(
    sessions: Sequence[SessionView],
    rule: StoppingRule,
    method: str,
    last: Coefficients | None,
    bolt_circle: BoltCircle | None,
) -> tuple[str, ...]:
    """What is not as in the sessions, each with its value there: of the rule, and of the other
    options, which are None where they were not given."""
    own = stopping_rule(sessions)
    header = own_sessions(sessions)[0].header if sessions else None
    were = _widths(own)
    values = [
        ("tolerance, deg", rule.tolerance_deg, own.tolerance_deg),
        ("probability for done", rule.probability, own.probability),
        *((f"unmodelled {name}", width, were[name]) for name, width in _widths(rule).items()),
    ]
    said = [f"{name}: {now:g}, not {was:g}" for name, now, was in values if now != was]
    if method != DEFAULT_METHOD:
        said.append(f"method: {method}, not {DEFAULT_METHOD}")
    if last is not None and (header is None or last != header.last_coefficients):
        said.append("last coefficients: " + " ".join(f"{p:+z.6g}" for p in last.as_tuple()))
    if bolt_circle is not None and (header is None or bolt_circle != header.bolt_circle):
        said.append(f"bolt circle: {bolt_circle.words()}")
    return tuple(said)


def _widths(rule: StoppingRule) -> dict[str, float]:
    unmodelled = rule.unmodelled
    names = (name for name in unmodelled.__struct_fields__ if not name.endswith("_chance"))
    collimation, squareness = unmodelled.large_chances
    chances = {"large_chance": squareness, "large_collimation_chance": collimation}
    return {**{name: getattr(unmodelled, name) for name in names}, **chances}


def differences(sessions: Sequence[SessionView], **changes: Unpack[RuleChanges]) -> tuple[str, ...]:
    """Sentences on what the headers of the sessions differ in, and which counts.

    What is asked for instead is no difference, nor how well each session's clock is known.
    """
    own = own_sessions(sessions)
    asked = {"clock_s", *(changes.get("unmodelled") or {})}

    def widths(header: Header) -> str:
        left = (f"{name} {w:g}" for name, w in _widths(header.rule).items() if name not in asked)
        return ", ".join(left)

    def lean(header: Header) -> str:
        return "none" if header.inclinometer is None else header.inclinometer.words()

    first = f"that of {own[0].path} counts" if own else ""
    rows: list[tuple[str, Callable[[Header], str], str]] = [
        ("limits", lambda header: header.unit.limits.words(), first),
        ("inclinometer", lean, first),
        ("unmodelled errors", widths, "the largest of each counts"),
    ]
    if changes.get("tolerance_deg") is None:
        rows.append(("tolerance", lambda h: f"{h.tolerance_deg:g} deg", "the smallest counts"))
    if changes.get("done_probability") is None:
        of_done = "probability for done"
        rows.append((of_done, lambda h: f"{h.done_probability:g}", "the largest counts"))
    said = []
    for what, of, counts in rows:
        found: dict[str, list[str]] = {}
        for session in own:
            found.setdefault(of(session.header), []).append(session.path)
        if len(found) > 1:
            texts = "; ".join(f"{value} in {listed(paths)}" for value, paths in found.items())
            said.append(f"the sessions differ in {what} ({texts}): {counts}")
    return tuple(said)
