"""``llakey annotate``: give your own recordings keyframes and instructions.

llakey annotate --repo_id=me/recordings --template=instructions.csv      # discover keyframes; fill in the file
llakey annotate --repo_id=me/recordings --instructions=instructions.csv \
    --output_repo_id=me/demonstrations --output_root=outputs/demonstrations
llakey annotate --repo_id=me/recordings --output_repo_id=me/demonstrations      # type the instructions

How the state is written: where its names do not tell, --state_names, --rotation, --gripper and --gripper_range do (the
same ones for the template and for the dataset); --calibration adds that of cameras that do not move.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

from lerobot.utils.constants import HF_LEROBOT_HOME

from lerobot_llakey import schema
from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.datasets.annotate import annotate, find_keyframes
from lerobot_llakey.datasets.camera_calibration import read_calibration
from lerobot_llakey.datasets.found import few_keyframes
from lerobot_llakey.datasets.keyframe_file import discovered, write_keyframes
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.datasets.wording import ask_instructions, read_instructions
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.folders import refuse_occupied
from lerobot_llakey.grammar import BASIC, Grammar
from lerobot_llakey.keyframes.rules import RuleSettings, parse_rules


@dataclass
class AnnotateConfig:
    """Options of ``llakey annotate``.

    Attributes:
        repo_id: your recordings, on the Hub or in the folder ``root``.
        root: their folder; by default LeRobot's home folder or the Hub.
        template: write a CSV file to fill in here, and nothing else.
        instructions: CSV or JSON file of instructions; they are asked for without it.
        output_repo_id: name of the demonstrations.
        output_root: their folder; by default LeRobot's home folder.
        state_names: of the state's numbers, in place of those that were recorded: [x,y,z,qw,qx,qy,qz,jaw,joint_1].
        rotation: how the hand's rotation is written where names do not tell: quaternion, quaternion_wxyz,
            rotation_vector, euler (roll, pitch, yaw in radians), euler_degrees or matrix (4x4, row by row).
        gripper: name of the number that is the gripper's opening, where it is called otherwise than "gripper".
        gripper_range: its values when closed and when open, as [0,100].
        calibration: YAML or JSON file with intrinsics and extrinsics by camera name.
        grammar: which texts are instructions: basic, free (any sentence), or a YAML file (docs/words.md).
        ignore_collision: whether the planner may touch things on the way to a keyframe.
        keyframes: rules that find keyframes: rest, waypoints, speed, or several as rest+waypoints (docs/own_arm.md).
        min_rest: seconds that the robot rests at a keyframe at least.
        arm_tolerance: radians that a resting joint may stray.
        position_tolerance: metres that a resting hand may stray, where no number of the state is named as a joint.
        rotation_tolerance: radians that it may turn.
        gripper_tolerance: share of its travel that a resting gripper may stray.
        path_tolerance: waypoints: metres by which straight lines between them may miss the hand's path.
        turn_tolerance: waypoints: degrees by which they may miss its rotation.
        speed_prominence: speed: by how much the hand is slower at a keyframe, as a share of the episode's high speed.
        merge_within: seconds within which keyframes of two rules, or two waypoints, are one.
    """

    repo_id: str
    root: Path | None = None
    template: Path | None = None
    instructions: Path | None = None
    output_repo_id: str | None = None
    output_root: Path | None = None
    state_names: list[str] | None = None
    rotation: str | None = None
    gripper: str | None = None
    gripper_range: list[float] = field(default_factory=lambda: [0.0, 1.0])
    calibration: Path | None = None
    grammar: str = BASIC
    ignore_collision: bool = True
    keyframes: str = "rest"
    min_rest: float = 0.2
    arm_tolerance: float = 0.01
    position_tolerance: float = 0.004
    rotation_tolerance: float = 0.02
    gripper_tolerance: float = 0.03
    path_tolerance: float = RuleSettings.path
    turn_tolerance: float = RuleSettings.turn
    speed_prominence: float = RuleSettings.prominence
    merge_within: float = RuleSettings.merge


@with_options
def run(config: AnnotateConfig) -> None:
    """Discover keyframes, then write the template or the annotated dataset."""
    if config.template is None and config.output_repo_id is None:
        raise LlakeyError("Expected a template or an output_repo_id, got neither; give --output_repo_id=user/name.")
    root = config.output_root or HF_LEROBOT_HOME / (config.output_repo_id or "")
    if config.template is None:
        refuse_occupied(root)  # before a person types anything
    grammar = Grammar.load(config.grammar)
    rules = parse_rules(config.keyframes)
    wording = (
        None if config.instructions is None or config.template else read_instructions(config.instructions, grammar)
    )
    source = open_dataset(config.repo_id, config.root)
    calibration = {}
    if config.calibration is not None:
        calibration = read_calibration(config.calibration, schema.cameras_of(source.features))
    found = find_keyframes(
        source,
        RuleSettings(
            config.min_rest,
            config.arm_tolerance,
            config.position_tolerance,
            config.rotation_tolerance,
            config.gripper_tolerance,
            config.path_tolerance,
            config.turn_tolerance,
            config.speed_prominence,
            config.merge_within,
        ),
        rules,
        None if wording is None else wording.keyframes,
        state_names=config.state_names,
        rotation=config.rotation,
        gripper=config.gripper,
        gripper_range=config.gripper_range,
    )
    count = sum(len(episode.keyframes) for episode in found)
    print(f"{count} keyframes in {len(found)} episodes")
    if advice := few_keyframes(found, rules):
        print(advice, file=sys.stderr)
    if config.template is not None:
        write_keyframes(config.template, found, {episode.episode: discovered(episode) for episode in found})
        print(f"to fill in: {config.template}")
        return
    assert config.output_repo_id is not None
    instructions = ask_instructions(found, grammar=grammar) if wording is None else wording.instructions
    annotate(
        source,
        found,
        instructions,
        root,
        config.output_repo_id,
        ignore_collision=config.ignore_collision,
        calibration=calibration,
        grammar=grammar,
    )
    print(f"demonstrations: {root}")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
