"""By what files are judged: what their sessions were judged by, or what is asked for instead."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TypedDict, Unpack

import msgspec

from solarcal.model.evidence.clocks import clock_sigma_s
from solarcal.model.finding import listed
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import Coefficients
from solarcal.session.view import SessionView
from solarcal.site import BoltCircle
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, Unmodelled


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


def stopping_rule(sessions: Sequence[SessionView], **changes: Unpack[RuleChanges]) -> StoppingRule:
    """The strictest of the sessions, its clock as well known as the worst of all, with changes."""
    rules = [session.header.rule for session in own_sessions(sessions)] or [DEFAULT_RULE]
    widths = [_widths(rule) for rule in rules]
    beside = rules[0].unmodelled
    if any(rule.unmodelled != beside for rule in rules):
        worst = {name: max(one[name] for one in widths) for name in widths[0]}
        worst["spot_deg"] = min(one["spot_deg"] for one in widths)
        beside = Unmodelled(**worst)
    if sessions:
        beside = beside.with_clock(max(clock_sigma_s(session) for session in sessions))
    least_deg = min(rule.tolerance_deg for rule in rules)
    return _changed(StoppingRule(least_deg, max(r.probability for r in rules), beside), changes)


def read_last(sessions: Sequence[SessionView]) -> SessionView:
    """The session whose inclinometer counts: the tower may have moved since an earlier one."""
    read = [one for one in own_sessions(sessions) if one.header.inclinometer is not None]
    return max(read, key=lambda one: one.header.utc) if read else sessions[0]


def own_sessions(sessions: Sequence[SessionView]) -> Sequence[SessionView]:
    """Those of a unit, where there are any: an import has placeholders in its header."""
    return [one for one in sessions if not one.header.unit.imported] or sessions


def _changed(rule: StoppingRule, changes: RuleChanges) -> StoppingRule:
    tolerance_deg, probability = changes.get("tolerance_deg"), changes.get("done_probability")
    return StoppingRule(
        rule.tolerance_deg if tolerance_deg is None else tolerance_deg,
        rule.probability if probability is None else probability,
        rule.unmodelled.changed(changes.get("unmodelled") or {}),
    )


def _widths(rule: StoppingRule) -> dict[str, float]:
    collimation, _ = rule.unmodelled.large_chances
    return {**msgspec.structs.asdict(rule.unmodelled), "large_collimation_chance": collimation}


def _named(rule: StoppingRule) -> dict[str, str]:
    """Each part of a rule with its value."""
    return {
        "tolerance": f"{rule.tolerance_deg:g} deg",
        "probability for done": f"{rule.probability:g}",
        **{f"unmodelled {name}": f"{width:g}" for name, width in _widths(rule).items()},
    }


def asked_for(
    sessions: Sequence[SessionView],
    rule: StoppingRule,
    method: str,
    last: Coefficients | None,
    bolt_circle: BoltCircle | None,
) -> tuple[str, ...]:
    """What is not as in the sessions, the rule with its values there; ``last`` and ``bolt_circle``
    are None where they were not given."""
    header = own_sessions(sessions)[0].header if sessions else None
    own = {**_named(stopping_rule(sessions)), "method": DEFAULT_METHOD}
    now = {**_named(rule), "method": method}
    said = [f"{name} {now[name]}, not {was}" for name, was in own.items() if now[name] != was]
    if last is not None and (header is None or last != header.last_coefficients):
        said.append("last coefficients " + " ".join(f"{p:+z.6g}" for p in last.as_tuple()))
    if bolt_circle is not None and (header is None or bolt_circle != header.bolt_circle):
        said.append(f"bolt circle {bolt_circle.words()}")
    return tuple(said)


def differences(sessions: Sequence[SessionView], changes: RuleChanges) -> Iterator[str]:
    """Sentences on what the headers of the sessions differ in, and which counts.

    What is asked for instead is no difference, nor how well each session's clock is known.
    """
    own = own_sessions(sessions)
    if not own:
        return
    found: dict[str, dict[str, list[str]]] = {}
    for session in own:
        header, lean = session.header, session.header.inclinometer
        values = _named(_changed(header.rule, changes))
        del values["unmodelled clock_s"]
        values["limits"] = header.unit.limits.words()
        values["inclinometer"] = "none" if lean is None else lean.words()
        last = header.last_coefficients
        held = () if last is None else last.as_tuple()
        values["last coefficients"] = " ".join(f"{p:+z.6g}" for p in held) or "none"
        for what, value in values.items():
            found.setdefault(what, {}).setdefault(value, []).append(session.path)
    counting = {"limits": own[0], "last coefficients": own[0], "inclinometer": read_last(own)}
    for what, files in found.items():
        if len(files) > 1:
            texts = "; ".join(f"{value} in {listed(paths)}" for value, paths in files.items())
            which = counting.get(what)
            counts = "the strictest counts" if which is None else f"that of {which.path} counts"
            yield f"the sessions differ in {what} ({texts}): {counts}"
