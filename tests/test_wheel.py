"""The built wheel, in an environment of its own, is found by LeRobot's commands without being told where to look."""

import json
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

PRINT_HELP = """
import contextlib, io, json, sys
from lerobot.scripts import lerobot_eval, lerobot_train
mains = {"lerobot-train": lerobot_train.main, "lerobot-eval": lerobot_eval.main}
pages = {}
for option in sys.argv[1:]:
    command, choice = option.split()
    sys.argv = [command, choice, "--help"]
    with contextlib.redirect_stdout(io.StringIO()) as page, contextlib.suppress(SystemExit):
        mains[command]()
    pages[option] = page.getvalue()
import importlib.metadata, lerobot_llakey
installed = importlib.metadata.distribution("lerobot_policy_llakey")
simulator = sorted({"mujoco", "gym_hil", "ompl"} & set(sys.modules))
places = {"package": lerobot_llakey.__file__, "metadata": str(installed.locate_file(""))}
print(json.dumps({"pages": pages, "simulator": simulator, **places}))
"""

CHOICES = [
    "lerobot-train --policy.type=llakey",
    "lerobot-train --policy.type=llakey_action",
    "lerobot-train --policy.type=llakey_command",
    "lerobot-eval --env.type=llakey_sim",
]


def run(*command: str | Path, cwd: Path) -> str:
    """A command's standard output; what it wrote to standard error is shown where it fails."""
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built by the build backend itself: nothing is downloaded."""
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=ROOT)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def clean_python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of a new environment: the wheel, and links to all that is installed here save this project itself."""
    environment = tmp_path_factory.mktemp("clean")
    run(sys.executable, "-m", "venv", "--without-pip", environment, cwd=environment)
    others = environment / "others"
    others.mkdir()
    for installed in Path(sysconfig.get_path("purelib")).iterdir():
        if "llakey" not in installed.name:
            (others / installed.name).symlink_to(installed)
    (site_packages,) = environment.glob("lib/python*/site-packages")
    (site_packages / "others.pth").write_text(f"{others}\n")
    python = environment / "bin" / "python"
    install = ("uv", "pip", "install", "--quiet", "--offline", "--no-deps", "--python", python, wheel)
    run(sys.executable, "-m", *install, cwd=environment)
    return python


@pytest.fixture(scope="module")
def found(clean_python: Path) -> dict:
    """What LeRobot's commands say in the new environment: the help page of each choice, and where the package lies."""
    output = run("env", "COLUMNS=120", clean_python, "-I", "-c", PRINT_HELP, *CHOICES, cwd=clean_python.parent)
    return json.loads(output.splitlines()[-1])


def test_the_wheel_carries_the_package_the_discovery_module_and_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    page = "lerobot_llakey/labelling/static/page.js"
    assert {"lerobot_policy_llakey.py", "lerobot_llakey/schema.py", page} <= set(names)
    assert {name.partition("/")[0] for name in names} == {
        *("lerobot_llakey", "lerobot_policy_llakey.py", "lerobot_policy_llakey-0.1.0.dist-info")
    }


def test_the_metadata_keeps_the_name_that_discovery_looks_for(wheel: Path) -> None:
    metadata = zipfile.ZipFile(wheel).read("lerobot_policy_llakey-0.1.0.dist-info/METADATA").decode()
    assert "Name: lerobot_policy_llakey" in metadata.splitlines()


def test_package_and_metadata_come_from_the_wheel(found: dict, clean_python: Path) -> None:
    environment = clean_python.parent.parent
    assert Path(found["package"]).is_relative_to(environment / "lib")
    assert Path(found["metadata"]).is_relative_to(environment / "lib")


@pytest.mark.parametrize("choice", CHOICES)
def test_lerobots_commands_know_the_choice(choice: str, found: dict) -> None:
    option, name = choice.split()[1].split("=")
    listed = re.search(rf"{re.escape(option)} \{{([^}}]*)\}}", found["pages"][choice])
    assert listed and name in re.split(r"[,\s]+", listed[1])
    # Only the options of a registered choice are in its help page.
    own = {"--policy.type": "--policy.input_features", "--env.type": "--env.features_map"}[option]
    assert own in found["pages"][choice]


def test_registering_the_policies_imports_no_simulator(found: dict) -> None:
    assert found["simulator"] == []


def test_the_llakey_command_is_installed(clean_python: Path) -> None:
    assert "usage: llakey" in run(clean_python.parent / "llakey", "--help", cwd=clean_python.parent)
