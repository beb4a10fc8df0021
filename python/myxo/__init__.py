"""Physarum growing on the surfaces of 3D objects.

    import myxo

    sim = myxo.Simulation("torus", particles=200_000, seed=7)
    sim.step(400)
    image = sim.render(1280, 720, view="relief")    # (720, 1280, 4), uint8
    trail = sim.trail                               # (texels, texels), float32
    sim["physarum.speed"] = 0.006
    sim.save("torus.ckpt")

`Simulation` runs a scene: a built-in one, a file, a dictionary, or a `Scene` of meshes in memory. `sweep` runs one at many points of
its parameters, over processes or a cluster. `scenes`, `presets` and `parameters` list what there is. Errors of the library are exceptions
with one sentence that says what, where and what to do.
"""

from ._myxo import NO_GO, DeviceError, parameters, presets, scenes
from ._myxo import version as __version__
from ._points import grid, sample
from ._scene import Scene
from ._simulation import PARTICLE, Object, Objects, Simulation
from ._sweep import read_fields, read_study, read_sweep, sweep, to_dataset

__all__ = [
    "NO_GO",
    "PARTICLE",
    "DeviceError",
    "Object",
    "Objects",
    "Scene",
    "Simulation",
    "__version__",
    "grid",
    "parameters",
    "presets",
    "read_fields",
    "read_study",
    "read_sweep",
    "sample",
    "scenes",
    "sweep",
    "to_dataset",
]
