"""A screw thread between a free part (a lid, a bulb) and its host (a jar, a socket)."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

from lerobot_llakey.sim.mujoco_poses import body_pose
from lerobot_llakey.sim.world import World

THREAD_BIT = 4
"""Contact bit of what meets inside a thread: guides and nuts have it as contype, the part as conaffinity."""

_SEAT_OFFSET, _SEAT_HEIGHT, _SEAT_TILT = 0.004, 0.003, 0.15
"""Metres beside the axis, metres off the first turn, and radians of tilt at which the thread can still bite."""
_BITE_SPEED = 0.1
"""Radians a second of turning clockwise that make the thread bite."""
_LIFT_SPEED = 0.01
"""Metres a second of rising at which it does not bite: lifting a part off turns it a little."""
_GRIP_TURN = np.deg2rad(2.0)
"""Radians of turn below which the part can be lifted off again."""
_FRICTION = 0.6
"""Newton metres: more than the gripper's pull along the axis can turn, so the thread locks itself."""

_STIFF = (0.99, 0.999, 0.001, 0.5, 2)
FIRM: dict[str, tuple[float, ...]] = {"solref": (0.008, 1), "solimp": _STIFF}
"""Contact of guides, nuts and parts: the hand presses a light part hard against them, which must not give way."""


@dataclass
class ScrewThread:
    """A thread as a nut on its host: the nut turns and sinks together, and the part that bites moves with it.

    The nut, which is not drawn, has a hinge and a slide along the host's z axis, coupled by an equality constraint
    (``travel`` metres in ``angle`` radians). Its top carries the part that is set down on it. Turning the part
    clockwise there makes the thread bite: from then on a weld constraint holds it to the nut, where it was met, which
    leaves it the helix alone: it sinks by being turned, and no pull takes it off. Turned back to the start it comes
    free. The part itself is never moved but by MuJoCo's forces.

    Attributes:
        name: prefix of the nut's names in the model.
        part: name of the free body that is screwed in; its z axis is the thread's.
        travel: metres that the part sinks by.
        angle: radians of the whole thread.
    """

    name: str
    part: str
    travel: float
    angle: float
    _cache: _Ids | None = field(default=None, init=False, repr=False, compare=False)

    def add(self, spec: mujoco.MjSpec, host: mujoco.MjsBody, entry: tuple[float, float, float], seat: float) -> None:
        """Add the nut to a scene that has the host, and gets the part before it is compiled.

        Args:
            spec: the scene.
            host: the body with the thread, upright.
            entry: where the part's frame is on the first turn, in the host's frame (metres).
            seat: height of the part's inner ceiling in its own frame (metres), by which the nut carries it.
        """
        nut = host.add_body(name=self._nut, pos=entry, gravcomp=1.0)
        nut.add_joint(
            name=self._nut,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=(0, 0, -1),
            range=(-0.05, self.angle),
            limited=True,
            armature=0.02,
            damping=0.02,
            frictionloss=_FRICTION,
        )
        slide = f"{self._nut}_slide"
        nut.add_joint(name=slide, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=(0, 0, -1), armature=2.0, damping=1.0)
        nut.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=(0.009, 0.015, 0),
            pos=(0, 0, seat - 0.015),
            mass=0.02,
            group=4,
            contype=THREAD_BIT,
            conaffinity=0,
            friction=(0.2, 0.005, 0.0001),
            **FIRM,
        )
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=slide,
            name2=self._nut,
            data=(0, self.travel / self.angle, 0, 0, 0, 0, 0, 0, 0, 0, 0),
            solref=(0.01, 1),
            solimp=_STIFF,
        )
        spec.add_equality(
            name=self._bite,
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=self._nut,
            name2=self.part,
            active=False,
            data=(0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1),
            solref=(0.01, 1),
            solimp=_STIFF,
        )

    def start_in(self, world: World) -> None:
        """Begin an episode with the part screwed in; call it in a task's reset, after the host is placed."""
        data, ids = world.data, self._ids(world.model)
        data.qpos[ids.qpos] = self.angle, self.travel
        mujoco.mj_kinematics(world.model, data)
        world.place(self.part, body_pose(data, ids.nut))
        world.model.eq_data[ids.bite, 6:10] = (1.0, 0.0, 0.0, 0.0)
        data.eq_active[ids.bite] = True

    def engaged(self, world: World) -> bool:
        """Whether the thread holds the part."""
        return bool(world.data.eq_active[world.model.equality(self._bite).id])

    def turned(self, world: World) -> float:
        """Radians by which the part is screwed in."""
        return world.joint(self._nut) if self.engaged(world) else 0.0

    def seated(self, world: World) -> bool:
        """Whether the part sits on the thread, held by it or ready to be."""
        nut, part = world.data.body(self._nut), world.data.body(self.part)
        return _meet(nut.xpos, part.xpos, part.xmat)

    def before_step(self, world: World) -> None:
        """Let the thread bite or come free; call it before each time step."""
        data, ids = world.data, self._ids(world.model)
        inwards = -data.cvel[ids.part, 2] > _BITE_SPEED
        if data.eq_active[ids.bite]:
            if data.qpos[ids.qpos[0]] >= _GRIP_TURN or inwards:
                return
            data.eq_active[ids.bite] = False
        # A nut that carries nothing stands at the thread's start.
        data.qpos[ids.qpos] = data.qvel[ids.dofs] = 0.0
        lifted = data.cvel[ids.part, 5] > _LIFT_SPEED
        if inwards and not lifted and _meet(data.xpos[ids.nut], data.xpos[ids.part], data.xmat[ids.part]):
            part, nut = data.xmat[ids.part], data.xmat[ids.nut]
            heading = np.arctan2(part[3], part[0]) - np.arctan2(nut[3], nut[0])
            world.model.eq_data[ids.bite, 6:10] = (np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2))
            data.eq_active[ids.bite] = True

    def _ids(self, model: mujoco.MjModel) -> _Ids:
        """The thread's indices, looked up once for a model."""
        if self._cache is None or self._cache.model is not model:
            joints = [model.joint(name) for name in (self._nut, f"{self._nut}_slide")]
            self._cache = _Ids(
                model,
                model.equality(self._bite).id,
                model.body(self._nut).id,
                model.body(self.part).id,
                np.array([int(joint.qposadr[0]) for joint in joints]),
                np.array([int(joint.dofadr[0]) for joint in joints]),
            )
        return self._cache

    @property
    def _nut(self) -> str:
        return f"{self.name}_nut"

    @property
    def _bite(self) -> str:
        return f"{self.name}_bite"


@dataclass(frozen=True)
class _Ids:
    """Where a thread is in a model's arrays."""

    model: mujoco.MjModel
    bite: int
    nut: int
    part: int
    qpos: np.ndarray
    dofs: np.ndarray


def _meet(nut: np.ndarray, part: np.ndarray, axes: np.ndarray) -> bool:
    """Whether a part at a position (3,), with axes (9,), is where the thread of an upright nut (3,) can bite."""
    x, y, z = part - nut
    beside = x * x + y * y
    return bool(beside < _SEAT_OFFSET**2 and abs(z) < _SEAT_HEIGHT and axes[8] > np.cos(_SEAT_TILT))
