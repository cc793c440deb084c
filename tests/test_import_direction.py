"""The rooms of the package know one another only as the design allows, and one module alone spells feature names."""

import ast
import re
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "lerobot_llakey"

FOUNDATION = {"geometry", "schema"}
GRAMMAR = {"sentences", "grammar_overlap", "grammar_data", "grammar"}
WORDS = FOUNDATION | GRAMMAR | {"hand", "instructions", "hints", "keyframes"}
SHARED = {"parallel", "reporting", "rollout", "shards"}
EVALUATION = {"evaluation", "evaluation.abilities", "evaluation.protocol"}
POLICIES = {"policies.action", "policies.command", "policies.hierarchy"}
SIMULATOR = {"sim.mujoco_poses", "sim.arm", "sim.world", "sim.objects", "sim.tasks", "sim.perturbations"}

MAY_IMPORT: dict[str, set[str]] = {
    "schema": set(),
    "geometry": {"schema"},
    "hand": {"schema"},
    "sentences": set(),
    "grammar_overlap": set(),
    "grammar_data": {"grammar_overlap"},
    "grammar": {*GRAMMAR, "schema"},
    "instructions": GRAMMAR,
    "hints": GRAMMAR | {"instructions"},
    "keyframes": FOUNDATION,
    "errors": set(),
    "files": set(),
    "folders": set(),
    "bounds": set(),
    "saved": set(),
    # What the experts' recordings and anyone else's have in common.
    "labels": WORDS,
    "checks": WORDS | {"labels"},
    # The simulator, from below: the arm, a scene's state, things, tasks; then time, motion and the episode, which
    # perturbations strike; last what LeRobot and the datasets meet.
    "sim.mujoco_poses": FOUNDATION,
    "sim.arm": FOUNDATION | {"sim.mujoco_poses"},
    "sim.world": FOUNDATION | {"sim.mujoco_poses", "sim.arm"},
    "sim.objects": FOUNDATION | {"sim.mujoco_poses", "sim.arm", "sim.world"},
    "sim.tasks": WORDS | {"sim.mujoco_poses", "sim.arm", "sim.world", "sim.objects"},
    "sim.perturbations": FOUNDATION | {"sim.arm", "sim"},
    "sim": WORDS | {"labels"} | SIMULATOR,
    "policies": WORDS | {"saved"},
    "policies.action": WORDS | {"policies", "saved", "checks"},
    "policies.command": WORDS | {"policies", "saved", "checks"},
    "policies.hierarchy": WORDS | POLICIES | {"policies", "saved", "checks"},
    "datasets": WORDS | {"labels", "checks", "sim", "parallel", "shards"},
    "naming": WORDS | {"policies", "policies.command", "datasets"},
    "converters": WORDS | {"labels", "sim", "datasets", "parallel"},
    "parallel": {"ray_engine"},
    "ray_engine": set(),
    "shards": set(),
    "reporting": set(),
    "rollout": WORDS | {"saved", "reporting", "sim"},
    "inspection": WORDS | {"policies", "policies.action", "checks", "reporting"},
    "evaluation.abilities": WORDS | {"reporting", "policies", "policies.command", "datasets"},
    "evaluation.protocol": WORDS | SHARED | {"saved", "policies.hierarchy", "sim"},
    "evaluation": WORDS | SHARED | {"policies", "datasets", "evaluation.abilities", "evaluation.protocol"},
    "diagnostics": WORDS | POLICIES | SHARED | {"labels", "policies", "sim", "datasets"},
    "dagger": WORDS | {"sim", "datasets", "parallel", "rollout"},
    "serving": set(),
    "drive": WORDS | POLICIES | {"policies", "sim", "rollout", "serving"},
    "labelling": WORDS | {"datasets"},
    "sharing": WORDS | POLICIES | {"checks", "saved", "datasets"},
    "experiments": WORDS | POLICIES | SHARED | EVALUATION | {"checks", "sim", "datasets"},
    "cli": WORDS
    | POLICIES
    | SHARED
    | EVALUATION
    | {"saved", "labels", "checks", "policies", "sim", "datasets", "converters", "inspection", "diagnostics", "dagger"}
    | {"drive", "experiments", "labelling", "naming", "serving", "sharing"},
    # Importing the package registers its environment and its policies.
    "": POLICIES | {"policies", "saved", "sim"},
}
"""Each room, and the other rooms that it may import; who may import ``sim`` from outside may import all of it."""
for _room, _below in MAY_IMPORT.items():
    if "sim" in _below and not _room.startswith("sim"):
        _below |= SIMULATOR

EVERYWHERE = {"errors", "files", "folders", "bounds"}
"""What stands below every room."""

SIMULATOR_LIBRARIES = {"mujoco", "gym_hil", "ompl", "mink", "frankik"}

MODULES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py"))


def room_of(module: str) -> str:
    """The longest room that a module, named relative to the package ("sim.tasks.base"), belongs to."""
    parts = module.split(".") if module else []
    rooms = (".".join(parts[:length]) for length in range(len(parts), 0, -1))
    return next((room for room in rooms if room in MAY_IMPORT), parts[0] if parts else "")


def module_name(path: Path) -> str:
    """ "sim/tasks/base.py" -> "sim.tasks.base", "sim/__init__.py" -> "sim", "__init__.py" -> ""."""
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(source: str, module: str = "", is_package: bool = False) -> Iterator[str]:
    """Absolute names of everything that a source imports, at any depth (lazy imports inside functions too)."""
    package = ["lerobot_llakey", *(module.split(".") if module else [])]
    package = package if is_package else package[:-1]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = [*base, node.module] if node.module else base
            # "from lerobot_llakey import sim" names a room only together with what it imports.
            yield from (".".join([*base, alias.name]) for alias in node.names)


def rooms_imported(source: str, module: str, is_package: bool = False) -> set[str]:
    """The rooms of the package, other than its own, that a module's source imports."""
    inside = [name for name in imports_of(source, module, is_package) if name.startswith("lerobot_llakey.")]
    return {room_of(name.removeprefix("lerobot_llakey.")) for name in inside} - {room_of(module)} - EVERYWHERE


def forbidden_imports(source: str, module: str, is_package: bool = False) -> set[str]:
    """The rooms that a module's source imports although its own room must not know them."""
    return rooms_imported(source, module, is_package) - MAY_IMPORT[room_of(module)]


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_a_module_imports_only_rooms_below_its_own(path: Path) -> None:
    module = module_name(path)
    room = room_of(module)
    assert room in MAY_IMPORT, f"{path} stands in no room of the design; give it one in MAY_IMPORT."
    forbidden = forbidden_imports((PACKAGE / path).read_text(), module, path.name == "__init__.py")
    assert not forbidden, f"{path} imports {sorted(forbidden)}, which {room!r} must not know."


def circle_in(rooms: Mapping[str, set[str]]) -> list[str]:
    """Rooms that import one another in turn, the first one again at the end; empty where there are none."""
    try:
        TopologicalSorter(rooms).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def _whole(room: str) -> str:
    """The simulator as one room: its own hold together by modules, as the test of those says."""
    return "sim" if room.startswith("sim.") else room


def test_rooms_form_no_circle() -> None:
    rooms: dict[str, set[str]] = {}
    for path in MODULES:
        module, is_package = module_name(path), path.name == "__init__.py"
        imported = rooms_imported((PACKAGE / path).read_text(), module, is_package)
        rooms.setdefault(_whole(room_of(module)), set()).update(map(_whole, imported))
    rooms = {room: others - {room} for room, others in rooms.items()}
    allowed = {room: set(map(_whole, others)) - {room} for room, others in MAY_IMPORT.items() if room == _whole(room)}
    assert not circle_in(rooms) and not circle_in(allowed)
    assert len(rooms) > 20 and "sim" in rooms["rollout"]
    assert set(circle_in(rooms | {"sim": {"rollout"}})) == {"rollout", "sim"}


@pytest.mark.parametrize("path", [path for path in MODULES if path.parts[0] == "policies"], ids=str)
def test_policies_run_without_the_simulators_libraries(path: Path) -> None:
    imported = {name.partition(".")[0] for name in imports_of((PACKAGE / path).read_text())}
    assert not imported & SIMULATOR_LIBRARIES


@pytest.mark.parametrize(
    ("source", "module", "expected"),
    [
        ("from lerobot_llakey.sim.env import LlakeySimEnv", "policies.action.stage", {"sim"}),
        ("from lerobot_llakey import policies", "sim.env", {"policies"}),
        ("def f():\n    import lerobot_llakey.datasets.collect", "sim.env", {"datasets"}),
        ("from ..command import prompt", "policies.action.stage", {"policies.command"}),
        ("from .. import cli", "evaluation.report", {"cli"}),
        ("from . import base", "sim.tasks.open_drawer", set()),
        ("from lerobot_llakey import schema", "geometry", set()),
        ("import lerobot_llakey.geometry", "schema", {"geometry"}),
    ],
)
def test_an_import_against_the_arrows_is_found(source: str, module: str, expected: set[str]) -> None:
    assert forbidden_imports(source, module) == expected


FEATURE_NAME = re.compile(r"(observation|keyframe|episode)\.[\w.]*")


def spelled_feature_names(source: str) -> list[str]:
    """String literals (docstrings left out, pieces of f-strings included) that look like a feature name."""
    tree = ast.parse(source)
    loose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    literals = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in loose]
    return [node.value for node in literals if isinstance(node.value, str) and FEATURE_NAME.fullmatch(node.value)]


SPELLS = {Path("schema.py"), Path("datasets/upgrade.py")}
"""The data contract, and what knows the names of the first one."""


@pytest.mark.parametrize("path", [path for path in MODULES if path not in SPELLS], ids=str)
def test_only_the_schema_spells_feature_names(path: Path) -> None:
    names = spelled_feature_names((PACKAGE / path).read_text())
    assert not names, f"{path} spells {names}; take these from lerobot_llakey.schema."


def test_the_search_finds_the_schemas_own_names() -> None:
    names = spelled_feature_names((PACKAGE / "schema.py").read_text())
    assert {"observation.state", "observation.images.", "keyframe.is_keyframe", "episode.seed"} <= set(names)
    assert spelled_feature_names('"""observation.state"""') == []


NAMES = {module_name(path) for path in MODULES}


def imported_modules(path: Path) -> set[str]:
    """The package's modules that a module's source names in its imports, those for type checkers alone included."""
    names = imports_of((PACKAGE / path).read_text(), module_name(path), path.name == "__init__.py")
    inside = {name.removeprefix("lerobot_llakey.") for name in names if name.startswith("lerobot_llakey.")}
    return {name if name in NAMES else name.rpartition(".")[0] for name in inside} & NAMES


def circles(graph: dict[str, set[str]]) -> list[set[str]]:
    """The groups of modules that reach one another by imports."""
    reached = {}
    for module in graph:
        found, left = set[str](), [module]
        while left:
            left += (new := graph[left.pop()] - found)
            found |= new
        reached[module] = found
    groups = {frozenset(other for other in found if module in reached[other]) for module, found in reached.items()}
    return sorted((set(group) for group in groups if group), key=min)


def test_no_modules_import_one_another_in_a_circle() -> None:
    graph = {module_name(path): imported_modules(path) - {module_name(path)} for path in MODULES}
    found = circles(graph)
    assert not found, f"These import one another in a circle: {[sorted(group) for group in found]}."


def test_circles_are_found() -> None:
    graph = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set(), "e": {"f"}, "f": {"e"}, "g": {"a"}}
    assert circles(graph) == [{"a", "b", "c"}, {"e", "f"}]
