"""Nine groceries of RLBench's cupboard: boxes, cans and a bottle, told apart by shape and by the colours of the label.

Standing or lying, all are small enough for the hand from any side, but for the height of crackers and sugar.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from lerobot_llakey.sim.objects.screw_thread import FIRM
from lerobot_llakey.sim.world import Colour

_MASS = 0.1
_PROUD = 0.0006
"""Metres by which a label stands out of what it is stuck on."""
_WHITE, _SILVER = (0.95, 0.95, 0.92), (0.75, 0.76, 0.78)


@dataclass(frozen=True)
class Good:
    """One thing to put away; its body's frame is in its middle, z up.

    Attributes:
        name: in words.
        size: half its extent along x, y and z in metres; x and y are the radius of a round one.
        colour: RGB in 0..1 of the body.
        label: colour of the band around it.
        band: lower and upper edge of the band, as parts of the height.
        round: whether it is a can or a bottle.
        cap: colour of the lid, or of a bottle's nozzle.
        nozzle: whether it is a bottle.
    """

    name: str
    size: tuple[float, float, float]
    colour: Colour
    label: Colour
    band: tuple[float, float]
    round: bool = False
    cap: Colour | None = None
    nozzle: bool = False

    @property
    def body(self) -> str:
        return self.name.replace(" ", "_")

    def half_extent(self, direction: np.ndarray) -> float:
        """Half the extent along a unit vector (3,) given in the body's frame."""
        x, y, z = np.abs(direction)
        across = np.hypot(x, y) * self.size[0] if self.round else x * self.size[0] + y * self.size[1]
        return float(across + z * self.size[2])


GOODS: tuple[Good, ...] = (
    Good("crackers", (0.029, 0.018, 0.042), (0.80, 0.05, 0.05), (1.00, 0.80, 0.05), (0.45, 0.80)),
    Good("chocolate jello", (0.029, 0.018, 0.023), (0.28, 0.14, 0.06), _WHITE, (0.35, 0.65)),
    Good("strawberry jello", (0.029, 0.018, 0.023), (1.00, 0.35, 0.60), _WHITE, (0.35, 0.65)),
    Good("soup", (0.025, 0.025, 0.033), (0.85, 0.08, 0.08), _WHITE, (0.0, 0.48), round=True, cap=_SILVER),
    Good("tuna", (0.030, 0.030, 0.017), (0.10, 0.45, 0.95), _WHITE, (0.30, 0.60), round=True, cap=_SILVER),
    Good("spam", (0.030, 0.021, 0.026), (0.05, 0.08, 0.45), (1.00, 0.85, 0.10), (0.30, 0.75)),
    Good(
        "coffee", (0.029, 0.029, 0.033), (0.40, 0.22, 0.10), (0.10, 0.65, 0.60), (0.20, 0.60), True, (0.05, 0.05, 0.05)
    ),
    Good("mustard", (0.022, 0.022, 0.030), (1.00, 0.80, 0.05), (0.10, 0.40, 0.15), (0.25, 0.60), True, nozzle=True),
    Good("sugar", (0.024, 0.018, 0.036), _WHITE, (1.00, 0.80, 0.05), (0.35, 0.75)),
)
"""In RLBench's order: a good's place is its variation."""


def add_good(spec: mujoco.MjSpec, good: Good) -> mujoco.MjsBody:
    """Add a good as a free body."""
    body = spec.worldbody.add_body(name=good.body, pos=(0, 0, 1))
    body.add_freejoint(name=good.body)
    shape = mujoco.mjtGeom.mjGEOM_CYLINDER if good.round else mujoco.mjtGeom.mjGEOM_BOX
    # Firm, and more so than the table: a hand that presses on a thing so light must not press it through.
    touch: dict[str, object] = {"friction": (0.8, 0.01, 0.0001), "solmix": 100.0, **FIRM}
    if good.round:
        # What lies on its side comes to rest within a few centimetres.
        touch |= {"condim": 6, "friction": (0.8, 0.01, 0.005)}
    body.add_geom(type=shape, size=_size(good, good.size), mass=_MASS, rgba=(*good.colour, 1), **touch)
    # The label runs around the longest axis: over the top of a flat box, where most cameras see it.
    along = 2 if good.round else int(np.argmax(good.size))
    low, high = ((2 * edge - 1) * good.size[along] for edge in good.band)
    size, middle = np.array(good.size) + _PROUD, np.zeros(3)
    size[along], middle[along] = (high - low) / 2, (low + high) / 2
    _show(body, shape, _size(good, tuple(size)), middle, good.label)
    if good.nozzle:
        _add_nozzle(body, good)
    elif good.cap is not None:
        _show(body, shape, (0.85 * good.size[0], 0.002, 0), (0, 0, good.size[2]), good.cap)
    return body


def _add_nozzle(body: mujoco.MjsBody, good: Good) -> None:
    """A bottle's shoulder and nozzle; only the body below is ever touched, standing or lying."""
    radius, height = good.size[0], good.size[2]
    cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
    _show(body, cylinder, (0.75 * radius, 0.004, 0), (0, 0, height + 0.004), good.colour)
    _show(body, cylinder, (0.40 * radius, 0.007, 0), (0, 0, height + 0.015), (0.90, 0.10, 0.05))


def _show(
    body: mujoco.MjsBody, shape: mujoco.mjtGeom, size: tuple[float, ...], middle: ArrayLike, colour: Colour
) -> None:
    body.add_geom(type=shape, size=size, pos=middle, rgba=(*colour, 1), contype=0, conaffinity=0, mass=0)


def _size(good: Good, size: tuple[float, float, float]) -> tuple[float, float, float]:
    """MuJoCo's size of a box, or of a cylinder: radius and half height."""
    return (size[0], size[2], 0.0) if good.round else size
