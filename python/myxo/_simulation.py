"""A simulation, and what it consists of."""

from __future__ import annotations

import json
import operator
import os
import warnings
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._myxo import Engine, encode_png
from ._scene import Scene, in_order, source, with_files

PARTICLE = np.dtype(
    [
        ("position", "<f8", 3),
        ("heading", "<f4", 3),
        ("texel", "<f4", 2),
        ("uv", "<f4", 2),
        ("triangle", "<i4"),
        ("object", "<i4"),
        ("pending", "<f4"),
        ("fed", "<i4"),
    ],
    align=True,
)
"""A row of `Simulation.particles`.

`position` in world units, `heading` a unit vector in the world, `texel` column and row in the texture, `uv` the weights of the
triangle's corners 1 and 2, `triangle` and `object` counted from 0, `pending` world units of the walk that are left for the next
step, `fed` steps for which the particle is still fed; 0 if it is hungry.
"""


class Simulation:
    """A scene that grows.

    Parameters
    ----------
    scene
        The name of a built-in scene (`myxo.scenes()`), the path of a scene file or a model, a dictionary as for `myxo.Scene`,
        or a `myxo.Scene`.
    particles
        How many there are; the same as the key `particles.count`.
    seed
        Of all random numbers; equal seeds give equal states, bit by bit, on every device.
    preset
        The name of a look (`myxo.presets()`), or the path of one. It lies over the scene.
    settings
        Values of parameters (`myxo.parameters()`), by dotted keys. They lie over scene and preset.
    device
        A number or a part of the name of the device; the best one if it is left out.

    Raises
    ------
    ValueError
        If the scene, a key or a value cannot be used.
    TypeError
        If the scene or the seed is of another type.
    FileNotFoundError
        If a file is missing.
    DeviceError
        If there is no device, or it has too little memory.
    RuntimeError
        If this process was forked from one in which the package had begun its work.
    """

    # A misspelled attribute is refused.
    __slots__ = ("__weakref__", "_engine")

    def __init__(
        self,
        scene: str | os.PathLike[str] | Mapping[str, Any] | Scene,
        *,
        particles: int | None = None,
        seed: int | None = None,
        preset: str | None = None,
        settings: Mapping[str, Any] | None = None,
        device: str | int | None = None,
    ) -> None:
        self._engine = _engine(scene, particles, seed, preset, settings, device, None)

    @classmethod
    def resume(
        cls,
        path: str | os.PathLike[str],
        scene: str | os.PathLike[str] | Mapping[str, Any] | Scene | None = None,
        *,
        settings: Mapping[str, Any] | None = None,
        device: str | int | None = None,
    ) -> Simulation:
        """Goes on from a checkpoint, with its own scene unless another one is given.

        Parameters
        ----------
        path
            The checkpoint.
        scene
            The scene again, if its meshes are arrays or its maps pictures: a `Scene` or a dictionary. Meshes, maps and masks are taken from
            it; everything else is as it was when the checkpoint was written. Or a name or a path, in place of the checkpoint's own scene.
            A warning lists the values in which it differs.
        settings
            Values of parameters that lie over those of the scene.
        device
            As for `Simulation`.

        Raises
        ------
        ValueError
            If the file is no checkpoint, or one of another scene.
        """
        self = cls.__new__(cls)
        self._engine = _engine(scene, None, None, None, settings, device, path)
        # What is set here is known.
        notes = [note for note in self._engine.notes() if note.partition(" = ")[0] not in (settings or {})]
        if notes:
            text = f"goes on from the checkpoint {os.fspath(path)}: {'; '.join(notes)}"
            warnings.warn(text, RuntimeWarning, stacklevel=2)
        return self

    # Growing

    def step(self, count: int = 1) -> Simulation:
        """Takes `count` steps, waits for them, and returns the simulation. Other threads go on meanwhile; Ctrl-C ends it after
        the step that runs.
        """
        count = _whole(count, "a number of steps")
        if count < 0:
            raise ValueError(f"a number of steps is 0 or more, not {count}")
        self._engine.step(count)
        return self

    @property
    def steps(self) -> int:
        """Steps that are done."""
        return self._engine.step_count()

    @property
    def time(self) -> float:
        """Seconds of the objects' motion."""
        return self._engine.time()

    # Pictures

    def render(
        self,
        width: int = 1280,
        height: int = 720,
        *,
        view: str | None = None,
        transparent: bool = False,
        passes: int = 1,
        settings: Mapping[str, Any] | None = None,
    ) -> NDArray[np.uint8]:
        """A picture of the present state: (height, width, 4), sRGB, straight alpha.

        Parameters
        ----------
        width, height
            Pixels.
        view
            What is drawn, as by `picture.show`: `surface` (the trail on the lit surface), `relief`, `glow`, `particles`, `headings`,
            `density`, `wireframe`, `charts`, `distance`, `nearest` or `atlas`.
        transparent
            Leaves out the background.
        passes
            Draws it so many times and takes the mean, for smooth fine lines.
        settings
            Values of `camera` and `picture` keys for this picture alone.

        Raises
        ------
        ValueError
            If a value is not allowed, the scene cannot be shown in this view, or the device has no room for so many pixels.
        """
        values = dict(settings or {})
        if view is not None:
            values["picture.show"] = view
        return self._engine.render(width, height, values, transparent, passes)

    def _repr_png_(self) -> bytes | None:
        if self._engine.is_closed():
            return None
        return encode_png(self.render(640, 400, passes=4))

    # State

    @property
    def trail(self) -> NDArray[np.float32]:
        """The trail, (texels, texels), in trail units from 0 to 1e29; a copy of the present state. It can be set, from the next step on."""
        return self._engine.trail()

    @trail.setter
    def trail(self, values: ArrayLike) -> None:
        self._set_field("trail", values)

    @property
    def bias(self) -> NDArray[np.float32]:
        """What sensors read on top of the trail, (texels, texels), trail units from -1e6 to 1e6, and `myxo.NO_GO` where particles may not
        go. It can be set, from the next step on, and lies over the areas of the scene.
        """
        return self._engine.field("bias")

    @bias.setter
    def bias(self, values: ArrayLike) -> None:
        self._set_field("bias", values)

    @property
    def second_look(self) -> NDArray[np.float32]:
        """How much the second look counts (key `second_look.preset`), (texels, texels), 0 to 1. It can be set, from the next step on."""
        return self._engine.field("second_look")

    @second_look.setter
    def second_look(self, values: ArrayLike) -> None:
        self._set_field("second_look", values)

    def _set_field(self, name: str, values: ArrayLike) -> None:
        array = in_order(values, np.float32)
        if array.ndim != 2:
            raise ValueError(f"the field has the shape {array.shape}: (texels, texels) is needed")
        self._engine.set_field(name, array)

    @property
    def deposits(self) -> NDArray[np.uint32]:
        """How many particles were counted on each texel in the last step, (texels, texels)."""
        return self._engine.deposits()

    @property
    def particles(self) -> NDArray[np.void]:
        """All particles, (particles,), of the type `myxo.PARTICLE`; row i is the one with the id i in every step. Where their number
        changes (`population.frequency`), the living ones in the order of their ids.
        """
        rows: NDArray[np.void] = np.empty(self._engine.living_count(), PARTICLE)
        self._engine.fill_particles(rows.view(np.uint8))
        return rows

    @property
    def texel_area(self) -> NDArray[np.float32]:
        """The area of surface in each texel, (texels, texels), world units squared."""
        return self._engine.texel_areas()

    @property
    def texel_object(self) -> NDArray[np.int32]:
        """The object of each texel, (texels, texels); -1 where there is none."""
        return self._engine.texel_objects()

    @property
    def texel_triangle(self) -> NDArray[np.int32]:
        """The triangle of each texel, (texels, texels); -1 where there is none."""
        return self._engine.texel_triangles()

    @property
    def texel_position(self) -> NDArray[np.float64]:
        """The place of each texel in world units, (texels, texels, 3); not a number where there is none."""
        return self._engine.texel_positions()

    @property
    def objects(self) -> Objects:
        """The objects, by name or number."""
        return Objects(self._engine)

    @property
    def radius(self) -> float:
        """The scene radius, in world units: the unit of lengths in settings."""
        return self._engine.sizes()[0]

    def measures(self) -> dict[str, Any]:
        """Measures of the network: `particles` (those alive), `mean_trail`, `covered` (share of the surface), `on_network` (share of
        the particles), `length` (scene radii), `pieces`, `regions`, `below`, and `objects`, the first few for each object by its name.
        """
        text, parts = self._engine.measures()
        measures: dict[str, Any] = json.loads(text)
        keys = ("particles", "mean_trail", "covered", "length")
        names = self._engine.object_names()
        measures["objects"] = {name: dict(zip(keys, part)) for name, part in zip(names, parts)}
        return measures

    def network(self) -> dict[str, Any]:
        """The network as a graph: `nodes` and `edges`, lists of dictionaries, and `measures` of them. Lengths are in scene radii.

        A node has its `kind` (junction, end, spot, loop, or through for a food on a line), the name of its `object`, its `place` in world
        coordinates, its `degree`, the network's `width` there, and the numbers of the `foods` that it reaches. An edge has `from` and `to`,
        numbers of nodes, `length`, `width`, the mean `trail`, and `points` along it. Places and points, too, are in scene radii: times
        `sim.radius` they are world units. `measures["foods"]`, None if fewer than two are reached, has `pairs`: the distances of each two
        foods, over the `surface` and along the `network`.

            network = sim.network()
            graph = networkx.MultiGraph()
            graph.add_nodes_from(enumerate(network["nodes"]))
            graph.add_edges_from((edge["from"], edge["to"], edge) for edge in network["edges"])
        """
        whole: dict[str, Any] = json.loads(self._engine.network())
        names = self._engine.object_names()
        for node in whole["nodes"]:
            node["object"] = names[node["object"]]
        return whole

    @property
    def state_hash(self) -> str:
        """A hash of particles, trail, paint, food and pulses, 16 hexadecimal digits; equal on every device for one scene, seed and step."""
        return self._engine.state_hash()

    def validate(self) -> None:
        """Checks that no particle is lost or doubled, and that every value is possible.

        Raises
        ------
        ValueError
            That says what is wrong.
        """
        self._engine.validate()

    # Parameters

    def __getitem__(self, key: str) -> Any:
        """The value of a parameter, such as `sim["physarum.speed"]`, or of one of an object, a food or a pulse, such as
        `sim["object.0.scale"]` or `sim["pulse.0.speed"]`.
        """
        return self._engine.get(key)

    def __setitem__(self, key: str, value: Any) -> None:
        """Changes a parameter from the next step or picture on.

        Raises
        ------
        KeyError
            If there is no such parameter; it names the nearest.
        ValueError
            If the value is not allowed, or the parameter can only be set at the start.
        """
        self._engine.set({key: value})

    def update(self, values: Mapping[str, Any]) -> None:
        """Changes several parameters together, or none if one is wrong."""
        self._engine.set(dict(values))

    # Files

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint, from which `Simulation.resume` and the program go on to the same states."""
        self._engine.save(path)

    def export(self, path: str | os.PathLike[str], *, vertex_colors: bool = False) -> list[str]:
        """Writes the state by the ending of `path`: `.glb` (a model with the trail as texture, or with vertex colours), `.ply`,
        `.npz` (all arrays) or `.toml` (a scene file; meshes that are arrays are written beside it, as `NAME_OBJECT.ply`). Returns the
        files that were written.
        """
        return [os.fspath(file) for file in self._engine.export(path, vertex_colors)]

    @property
    def scene(self) -> str:
        """The scene as the text of a scene file, with the values of now. A mesh that is an array is `memory:NAME` there, which no program
        can read: `export` writes it as a file.
        """
        return self._engine.scene_text()

    # The device

    @property
    def device(self) -> str:
        """The name of the device that computes, and its driver."""
        _, device, driver = self._engine.names()
        return f"{device}, {driver}"

    def close(self) -> None:
        """Frees the device. Everything but `close` is an error afterwards."""
        self._engine.close()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._engine.is_closed():
            return "<myxo.Simulation, closed>"
        name, device, _ = self._engine.names()
        particles = self._engine.living_count()
        _, triangles, side = self._engine.sizes()
        return (
            f"<myxo.Simulation {name}: step {self.steps}, {particles:,} particles, {triangles:,} triangles, "
            f"{side} x {side} texels, on {device}>"
        )


class Object:
    """One object of a simulation."""

    __slots__ = ("__weakref__", "_engine", "_name", "_number")

    def __init__(self, engine: Engine, number: int, name: str) -> None:
        self._engine = engine
        self._number = number
        self._name = name

    @property
    def number(self) -> int:
        """Its number, counted from 0."""
        return self._number

    @property
    def name(self) -> str:
        """Its name."""
        return self._name

    @property
    def pose(self) -> NDArray[np.float64]:
        """World from scaled object coordinates, (4, 4), rows first; in the last step, or as it was set since."""
        pose: NDArray[np.float64] = self._engine.poses()[self.number]
        return pose

    @pose.setter
    def pose(self, pose: ArrayLike | None) -> None:
        """Sets the pose from the next step on; it turns and moves, and does not scale. None gives it back to the scene."""
        matrix = None if pose is None else in_order(pose, np.float64)
        if matrix is not None and matrix.shape != (4, 4):
            raise ValueError(f"a pose is a matrix of shape (4, 4), not {matrix.shape}")
        self._engine.set_pose(self.number, matrix)

    @property
    def mesh(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Vertices (n, 3) in scaled object coordinates, which `pose` takes to the world, and faces (m, 3), as the simulation has them:
        joined and repaired."""
        vertices, faces, ranges = self._engine.surface()
        first, end = ranges[self.number]
        own = (faces[:, 0] >= first) & (faces[:, 0] < end)
        return vertices[first:end], faces[own] - first

    def __repr__(self) -> str:
        return f"<myxo.Object {self.number}: {self.name}>"


class Objects(Mapping[str, Object]):
    """The objects of a simulation, by name; by number, too."""

    __slots__ = ("__weakref__", "_engine")

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def __getitem__(self, key: str | int) -> Object:
        names = self._engine.object_names()
        if isinstance(key, str):
            if key not in names:
                raise KeyError(f"there is no object `{key}`: the scene has {', '.join(names)}")
            return Object(self._engine, names.index(key), key)
        number = range(len(names))[key]
        return Object(self._engine, number, names[number])

    def __iter__(self) -> Iterator[str]:
        return iter(self._engine.object_names())

    def __len__(self) -> int:
        return len(self._engine.object_names())

    def __repr__(self) -> str:
        return f"<myxo.Objects: {', '.join(self)}>"


def _engine(
    scene: str | os.PathLike[str] | Mapping[str, Any] | Scene | None,
    particles: int | None,
    seed: int | None,
    preset: str | None,
    settings: Mapping[str, Any] | None,
    device: str | int | None,
    resume: str | os.PathLike[str] | None,
) -> Engine:
    values = with_files(settings or {})
    if particles is not None:
        values["particles.count"] = particles
    if seed is not None:
        seed = _whole(seed, "a seed")
        if not 0 <= seed < 2**32:
            raise ValueError(f"a seed is from 0 to {2**32 - 1}, not {seed}")
    device = None if device is None else str(device)
    if scene is None:
        return Engine(None, None, [], "", preset, values, seed, device, resume)
    return Engine(*source(scene, preset, values), seed, device, resume)


def _whole(value: Any, what: str) -> int:
    """A whole number, also one of NumPy."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is a whole number, not {value!r}") from None
