"""The pilot says what it will do, and then does just that."""

from dataclasses import replace
from typing import Any

import pytest

from lerobot_llakey.drive.pilot import ROW, Pilot
from lerobot_llakey.policies.hierarchy.decision import Said
from lerobot_llakey.rollout.actors import Agent

GOAL = "open the top drawer"


@pytest.fixture
def observation(make_env: Any) -> Any:
    env = make_env("open_drawer")
    yield env.reset(seed=3)[0]
    env.close()


def test_proposing_often_changes_nothing(pilot: Pilot, agent: Agent, script: Any, observation: Any) -> None:
    pilot.reset()
    proposals = [pilot.propose(GOAL, observation) for _ in range(6)]
    assert proposals == proposals[:1] * 6 and len(script.goals) == 1  # asked once
    _, step = pilot.act()
    assert step.instruction == proposals[0].instruction and (step.index, step.repeats) == (0, 0)
    pilot.propose(GOAL, observation)
    assert pilot.act()[1].repeats == 1 and len(agent.policy.log[ROW]) == 2


def test_unreadable_words_are_shown_with_what_takes_their_place(pilot: Pilot, script: Any, observation: Any) -> None:
    script.ask = lambda *arguments, **options: [Said("dance", "policy", 0.5)]
    pilot.reset()
    proposal = pilot.propose(GOAL, observation)
    assert (proposal.instruction, proposal.source) == ("raise the robotic arm", "fallback")
    assert (proposal.said, proposal.likelihood) == ("dance", None)
    assert pilot.act()[1].source == "fallback"


def test_a_person_comes_first_and_a_goal_reaches_the_policy(pilot: Pilot, script: Any, observation: Any) -> None:
    pilot.reset()
    pilot.corrections.change_task(ROW, "open the bottom drawer")
    assert pilot.propose(GOAL, observation).source == "policy" and script.goals == ["open the bottom drawer"]
    pilot.corrections.change_task(ROW, "")
    pilot.propose(GOAL, observation)
    pilot.corrections.change_task(ROW, "open the bottom drawer")
    pilot.propose(GOAL, observation)
    assert script.goals == ["open the bottom drawer", GOAL]  # what is known is not asked again
    pilot.corrections.say(ROW, "grab the moon")
    proposal = pilot.propose(GOAL, observation)
    assert (proposal.instruction, proposal.source) == ("grasp the moon", "person")
    step = pilot.act()[1]
    assert (step.instruction, step.source, step.task) == ("grasp the moon", "person", "open the bottom drawer")


def test_a_policy_without_a_hierarchy_is_refused(agent: Agent) -> None:
    with pytest.raises(ValueError, match="Expected a checkpoint of type 'llakey', got one of type 'llakey_action'"):
        policy = type("Action", (), {"name": "llakey_action"})()
        Pilot(replace(agent, policy=policy))
