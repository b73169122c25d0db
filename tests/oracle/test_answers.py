"""A change of the code that is no change of the physics changes no answer."""

import copy

import answers
import pytest

from solarcal.emulator.scenario import scenario_names

RECORDED = answers.load(answers.ANSWERS)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("answers")
    return {path.name: path for path in answers.write_sessions(folder)}


def test_every_saved_session_and_every_scenario_is_answered_about(files):
    assert set(files) == set(RECORDED)
    assert {f"scenario-{name}.jsonl" for name in scenario_names()} <= set(RECORDED)
    assert all(set(answer) == set(answers.COMMANDS) for answer in RECORDED.values())


@pytest.mark.parametrize("name", RECORDED)
def test_the_answers_are_the_recorded_ones(name, files, tmp_path):
    wrong = [
        f"{command}: {line}"
        for command, recorded in RECORDED[name].items()
        for line in answers.differences(
            recorded, answers.answer(files[name], command, tmp_path), command
        )
    ]
    assert not wrong, "\n".join(
        [f"{name} is answered otherwise (tests/oracle/answers.py):", *wrong[:40]]
    )


def test_a_change_beyond_the_tolerance_is_a_difference_and_an_addition_is_none():
    recorded = RECORDED["azel-good-day.jsonl"]["fit robust"]
    now = copy.deepcopy(recorded)
    now["something new"] = 1.0
    now["findings"].insert(0, {"kind": "something new", "number": 3.0})
    assert answers.differences(recorded, now, "fit robust") == []
    now["coefficients"]["P1"]["value"] += 2e-9
    now["verdict"]["state"] = "another"
    now["findings"].pop()
    lines = "\n".join(answers.differences(recorded, now, "fit robust"))
    assert ".coefficients.P1.value" in lines
    assert ".verdict.state" in lines
    assert ".findings: degeneracy is gone" in lines


def test_another_number_in_the_report_is_a_difference_and_another_wording_is_none():
    recorded = RECORDED["azel-good-day.jsonl"]["report"]
    assert answers.differences(recorded, recorded.replace("certificate", "sheet"), "report") == []
    changed = recorded.replace("1830 m", "1831 m")
    assert answers.differences(recorded, changed, "report") == [
        "the text does not say 1830 any more"
    ]
