"""Forward kinematics of an arm whose model is a URDF or an MJCF file, through MuJoCo, which reads both."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import mujoco
import numpy as np

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.files import reading
from lerobot_llakey.geometry import matrix_to_pose

_NEEDLESS = ("sensors", "keys", "actuators", "tendons", "equalities", "pairs", "excludes", "skins", "flexes", "geoms")
_ASSETS = ("meshes", "hfields", "materials", "textures")
"""Parts of a model that bear on no pose; meshes and textures lie in files of their own, which may be missing."""
_NAMES_SHOWN = 8
_TURNING, _ONE_NUMBER = mujoco.mjtJoint.mjJNT_HINGE, (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class Kinematics:
    """The joints from an arm's base to its tip, and what they make of the tip's pose.

    Attributes:
        path: of the model's file.
        joints: names of the moving joints, from base to tip.
        turning: (N,) bool, whether each is an angle; the others are lengths in metres.
        limits: (N, 2) radians or metres; infinite where the model has none.
    """

    path: Path
    joints: tuple[str, ...]
    turning: np.ndarray
    limits: np.ndarray
    _model: mujoco.MjModel
    _tip: tuple[str, int]

    def poses(self, values: np.ndarray) -> np.ndarray:
        """The tip's poses (T, 7) in the frame of the model's root link (URDF) or world (MJCF), as x y z qx qy qz qw.

        Args:
            values: (T, N) of the joints, in radians and metres.
        """
        data = mujoco.MjData(self._model)
        places = [self._model.joint(name).qposadr[0] for name in self.joints]
        kind, number = self._tip
        matrices = np.tile(np.eye(4), (len(values), 1, 1))
        for matrix, row in zip(matrices, values, strict=True):
            data.qpos[places] = row
            mujoco.mj_kinematics(self._model, data)
            at, turn = (data.site_xpos, data.site_xmat) if kind == "site" else (data.xpos, data.xmat)
            matrix[:3, 3], matrix[:3, :3] = at[number], turn[number].reshape(3, 3)
        return matrix_to_pose(matrices)


def read_kinematics(path: Path, tip: str) -> Kinematics:
    """Read an arm's model; its meshes and textures are not needed.

    Args:
        path: of a URDF or an MJCF file.
        tip: name of the link, body or site that is the hand.

    Raises:
        MissingFileError: if there is no such file.
        LlakeyError: if it is no model, has no such tip, or no joint or one of several numbers leads to it.
    """
    with reading(path, "URDF or MJCF file"):
        spec = mujoco.MjSpec.from_file(str(path))
        for kind in (*_NEEDLESS, *_ASSETS):
            for part in list(getattr(spec, kind)):
                spec.delete(part)
        spec.compiler.fusestatic = False  # else a URDF's fixed links, and with them the tip, are gone
        spec.compiler.boundmass, spec.compiler.boundinertia = 1e-3, 1e-6  # of links that came without
        spec.compiler.balanceinertia = True
        model = spec.compile()
    sites = [model.site(number).name for number in range(model.nsite)]
    bodies = [model.body(number).name for number in range(1, model.nbody)]
    if tip in sites:
        place, body = ("site", sites.index(tip)), int(model.site(tip).bodyid[0])
    elif tip in bodies:
        place, body = ("body", bodies.index(tip) + 1), bodies.index(tip) + 1
    else:
        raise LlakeyError(
            f"Expected --tip to name a link, body or site of {path}, got {tip!r}; {_nearest(tip, [*sites, *bodies])}."
        )
    numbers: list[int] = []
    while body:
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        numbers = [*range(first, first + count), *numbers]
        body = int(model.body_parentid[body])
    joints = tuple(model.joint(number).name for number in numbers)
    wrong = [name or "one without a name" for number, name in zip(numbers, joints, strict=True) if not name]
    wrong += [model.joint(number).name for number in numbers if model.jnt_type[number] not in _ONE_NUMBER]
    if wrong or not joints:
        came = f"{', '.join(wrong)} among them" if wrong else "none"
        raise LlakeyError(
            f"Expected named joints that turn or slide between the base of {path} and {tip}, got {came}; give the "
            "model of an arm whose base stands still, and a --tip that moves."
        )
    limited = np.array([bool(model.jnt_limited[number]) for number in numbers])
    return Kinematics(
        path,
        joints,
        np.array([model.jnt_type[number] == _TURNING for number in numbers]),
        np.where(limited[:, None], model.jnt_range[numbers], (-np.inf, np.inf)),
        model,
        place,
    )


def _nearest(tip: str, names: Iterable[str]) -> str:
    known = [name for name in names if name]
    near = get_close_matches(tip, known, n=3, cutoff=0.4)
    shown = near or known[-_NAMES_SHOWN:]
    return f"{'the nearest are' if near else 'there are'} {', '.join(shown) or 'no named ones'}"
