"""``llakey annotate``: give your own recordings keyframes and instructions.

llakey annotate --repo_id=me/recordings --template=instructions.csv      # discover keyframes; fill in the file
llakey annotate --repo_id=me/recordings --instructions=instructions.csv \
    --output_repo_id=me/demonstrations --output_root=outputs/demonstrations
llakey annotate --repo_id=me/recordings --instructions=skills.yaml --output_repo_id=me/demonstrations
llakey annotate --repo_id=me/recordings --output_repo_id=me/demonstrations      # type the instructions

How the state is written: where its names do not tell, --state_names, --rotation, --gripper and --gripper_range do (the
same ones for the template and for the dataset). --urdf and --tip give the hand's pose where joints alone were recorded,
--calibration that of cameras that do not move, and --depth depth from files.
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
from lerobot_llakey.datasets.depth_files import find_depth
from lerobot_llakey.datasets.found import few_keyframes
from lerobot_llakey.datasets.joint_poses import ArmModel
from lerobot_llakey.datasets.keyframe_file import discovered, write_keyframes
from lerobot_llakey.datasets.opening import open_dataset
from lerobot_llakey.datasets.sequences import YAML_SUFFIXES, read_sequences
from lerobot_llakey.datasets.skill_instructions import SUBTASK, from_sequences, from_subtasks
from lerobot_llakey.datasets.wording import ask_instructions, read_instructions
from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.folders import refuse_occupied
from lerobot_llakey.grammar import BASIC, Grammar
from lerobot_llakey.keyframes.rules import RuleSettings, parse_rules
from lerobot_llakey.naming.chat import CHAT, ChatOptions, from_chat


@dataclass
class AnnotateConfig:
    """Options of ``llakey annotate``.

    Attributes:
        repo_id: your recordings, on the Hub or in the folder ``root``.
        root: their folder; by default LeRobot's home folder or the Hub.
        template: write a CSV file to fill in or, with --instructions, to look through, and nothing else.
        instructions: where they come from: a CSV or JSON file, one a keyframe; a YAML file of skills, one list for each
            number of keyframes (docs/own_arm.md); subtask, for the rows that lerobot-annotate wrote; chat, for a chat
            model's; without it, they are asked for.
        chat: which chat model names the actions.
        output_repo_id: name of the demonstrations.
        output_root: their folder; by default LeRobot's home folder.
        state_names: of the state's numbers, in place of those that were recorded: [x,y,z,qw,qx,qy,qz,jaw,joint_1].
        rotation: how the hand's rotation is written where names do not tell: quaternion, quaternion_wxyz,
            rotation_vector, euler (roll, pitch, yaw in radians), euler_degrees or matrix (4x4, row by row).
        gripper: name of the number that is the gripper's opening, where it is called otherwise than "gripper".
        gripper_range: its values when closed and when open, as [0,100].
        urdf: URDF or MJCF file of the arm, for recordings of joints alone; gives the hand's pose.
        tip: name of the model's link, body or site that is the hand.
        joint_names: of the recorded numbers that are the joints from base to tip, where the model calls them otherwise.
        joint_unit: of joints that turn: radians or degrees.
        calibration: YAML or JSON file with intrinsics and extrinsics by camera name.
        depth: folder of 16-bit PNGs in millimetres, CAMERA/episode_000/frame_000000.png, for cameras without depth.
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
    instructions: str | None = None
    chat: ChatOptions = field(default_factory=ChatOptions)
    output_repo_id: str | None = None
    output_root: Path | None = None
    state_names: list[str] | None = None
    rotation: str | None = None
    gripper: str | None = None
    gripper_range: list[float] = field(default_factory=lambda: [0.0, 1.0])
    urdf: Path | None = None
    tip: str | None = None
    joint_names: list[str] | None = None
    joint_unit: str = "radians"
    calibration: Path | None = None
    depth: Path | None = None
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
    if config.instructions == CHAT and config.template is None:
        raise LlakeyError(
            "Expected --template with --instructions=chat, as a model's words want to be looked through, got none; "
            "give --template=FILE.csv, correct the file, and give it as --instructions=FILE.csv."
        )
    root = config.output_root or HF_LEROBOT_HOME / (config.output_repo_id or "")
    if config.template is None:
        refuse_occupied(root)  # before a person types anything
    grammar = Grammar.load(config.grammar)
    rules = parse_rules(config.keyframes)
    file = None if config.instructions in (None, SUBTASK, CHAT) else Path(str(config.instructions))
    tasks = read_sequences(file, grammar) if file is not None and file.suffix in YAML_SUFFIXES else None
    wording = None if file is None or tasks is not None or config.template else read_instructions(file, grammar)
    source = open_dataset(config.repo_id, config.root)
    calibration = {}
    if config.calibration is not None:
        calibration = read_calibration(config.calibration, schema.cameras_of(source.features))
    depth = None if config.depth is None else find_depth(config.depth, source.meta)
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
        _arm(config),
        state_names=config.state_names,
        rotation=config.rotation,
        gripper=config.gripper,
        gripper_range=config.gripper_range,
    )
    count = sum(len(episode.keyframes) for episode in found)
    print(f"{count} keyframes in {len(found)} episodes")
    if advice := few_keyframes(found, rules):
        print(advice, file=sys.stderr)
    instructions = None if wording is None else wording.instructions
    if tasks is not None:
        instructions = from_sequences(found, tasks)
    elif config.instructions == SUBTASK:
        instructions = from_subtasks(source, found)
    elif config.instructions == CHAT:
        instructions = from_chat(source, found, config.chat, grammar)
    if config.template is not None:
        known = instructions or {}
        keyframes = {episode.episode: discovered(episode, known.get(episode.episode)) for episode in found}
        write_keyframes(config.template, found, keyframes)
        print(f"to fill in: {config.template}")
        return
    assert config.output_repo_id is not None
    if instructions is None:
        instructions = ask_instructions(found, grammar=grammar)
    annotate(
        source,
        found,
        instructions,
        root,
        config.output_repo_id,
        ignore_collision=config.ignore_collision,
        calibration=calibration,
        depth=depth,
        grammar=grammar,
    )
    print(f"demonstrations: {root}")


def _arm(config: AnnotateConfig) -> ArmModel | None:
    given = {"urdf": config.urdf, "tip": config.tip, "joint_names": config.joint_names}
    given["joint_unit"] = None if config.joint_unit == "radians" else config.joint_unit
    named = [f"--{name}={value}" for name, value in given.items() if value is not None]
    if not named:
        return None
    if config.urdf is None or config.tip is None:
        raise LlakeyError(f"Expected --urdf and --tip together, got {' and '.join(named)} alone; give both.")
    return ArmModel(config.urdf, config.tip, config.joint_names, config.joint_unit)


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()
