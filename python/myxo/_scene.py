"""Scenes whose meshes are arrays."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
import threading
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._myxo import encode_png

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]


class Scene:
    """A scene that is put together in Python: objects, and the keys of a scene file.

        scene = myxo.Scene(preset="network")
        scene.add("ball", (vertices, faces), position=[0, 1, 0])
        scene.add("floor", "builtin:plane", scale=3.0)
        sim = myxo.Simulation(scene, particles=100_000)

    Parameters
    ----------
    keys
        A scene file as a dictionary, nested (`{"trail": {"decay": 0.9}}`) or with dotted keys (`{"trail.decay": 0.9}`).
        The objects under `"object"` may have arrays as their `"mesh"`, as in `add`. Maps and masks (`areas.map`,
        `second_look.map`, `particles.start_mask`, an object's `start.mask`) may be pictures, (rows, columns) of lightness or
        (rows, columns, 3 or 4) of colours, as integers to 255 or as numbers from 0 to 1.
    preset
        The name of a built-in preset, or the path of one.
    folder
        Where relative paths of meshes and maps begin.
    """

    def __init__(
        self,
        keys: Mapping[str, Any] | None = None,
        *,
        preset: str | None = None,
        folder: str | os.PathLike[str] = "",
    ) -> None:
        table = nested(keys or {})
        objects = table.pop("object", [])
        if not isinstance(objects, (list, tuple)):
            raise TypeError("the key `object` of a scene is a list of dictionaries, one for each object")
        self.preset = preset
        self.folder = os.fspath(folder)
        self._keys = table
        self._objects: list[dict[str, Any]] = []
        self._meshes: list[tuple[str, Arrays] | None] = []
        for number, entry in enumerate(objects):
            entry = dict(entry)
            mesh = entry.pop("mesh", None)
            if mesh is None:
                raise ValueError(f"object {number} of the scene has no mesh")
            self.add(entry.pop("name", ""), mesh, **entry)

    def add(self, name: str, mesh: Any, **keys: Any) -> Scene:
        """Adds an object, and returns the scene.

        Parameters
        ----------
        name
            Its name; empty for the name of its mesh.
        mesh
            `builtin:NAME`, the path of a model, vertices (n, 3) and faces (m, 3) as a pair of arrays, or a mesh of trimesh or
            PyVista. Vertices are in the object's own coordinates. Faces count vertices from 0. Arrays are copied.
        keys
            Keys of an `[[object]]`: `position`, `rotation` (degrees), `scale`, `texel_weight`, `start`, ...

        Raises
        ------
        ValueError
            If an array has another shape.
        """
        if isinstance(mesh, (str, os.PathLike)):
            self._meshes.append(None)
            path = os.fspath(mesh)
        else:
            number = len(self._objects)
            label = name or f"object {number}"
            places, corners = arrays_of(mesh, label)
            # What becomes of the arrays later changes no object.
            self._meshes.append((label, (places.copy(), corners.copy())))
            # No path: the mesh is in memory.
            path = f"memory:{label}"
        entry = nested(keys)
        entry["mesh"] = path
        if name:
            entry["name"] = name
        self._objects.append(entry)
        return self

    def table(self) -> dict[str, Any]:
        """The scene as a dictionary, as a scene file has it."""
        return with_files({**self._keys, "object": [dict(entry) for entry in self._objects]})

    def meshes(self) -> list[tuple[str, Arrays] | None]:
        """For each object, its name and arrays, or None if its mesh is a file or built in."""
        return list(self._meshes)

    def __repr__(self) -> str:
        return f"<myxo.Scene of {len(self._objects)} objects>"


class _Folder:
    """A temporary folder that goes with the process that made it. A forked process that ends leaves it."""

    def __init__(self) -> None:
        self.name = tempfile.mkdtemp(prefix="myxo-")
        self._owner = os.getpid()
        atexit.register(self.cleanup)

    def cleanup(self) -> None:
        """Removes it."""
        if os.getpid() == self._owner:
            shutil.rmtree(self.name, ignore_errors=True)


# Pictures of maps, as files, as long as the process runs.
_pictures: _Folder | None = None
_making_folder = threading.Lock()


def with_files(table: Mapping[str, Any]) -> dict[str, Any]:
    """A dictionary in which pictures of maps and masks are files."""
    whole: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            whole[key] = with_files(value)
        elif isinstance(value, (list, tuple)) and value and all(isinstance(item, Mapping) for item in value):
            whole[key] = [with_files(item) for item in value]
        elif key.rpartition(".")[2] in ("map", "mask", "start_mask") and getattr(value, "ndim", 0) > 0:
            whole[key] = _picture(key, np.asarray(value))
        else:
            whole[key] = value
    return whole


def is_picture(value: Any) -> bool:
    """Is it the path of such a file?"""
    return _pictures is not None and isinstance(value, str) and os.path.dirname(value) == _pictures.name


def _picture(key: str, array: NDArray[Any]) -> str:
    """The path of a picture with these pixels."""
    global _pictures
    if array.ndim == 2:
        array = np.repeat(array[:, :, None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] not in (3, 4) or array.size == 0:
        raise ValueError(f"the picture `{key}` has the shape {array.shape}: (rows, columns), or (rows, columns, 3 or 4) for colours")
    if array.dtype == bool or np.issubdtype(array.dtype, np.floating):
        array = np.asarray(array, dtype=np.float64)
        if not (np.isfinite(array).all() and array.min() >= 0.0 and array.max() <= 1.0):
            raise ValueError(f"the picture `{key}` has numbers beyond 0 to 1")
        array = np.round(255.0 * array)
    elif array.min() < 0 or array.max() > 255:
        raise ValueError(f"the picture `{key}` has integers beyond 0 to 255")
    pixels = np.full((*array.shape[:2], 4), 255, dtype=np.uint8)
    pixels[:, :, : array.shape[2]] = array
    with _making_folder:
        if _pictures is None:
            _pictures = _Folder()
        folder = _pictures.name
    content = encode_png(pixels)
    path = os.path.join(folder, f"{hashlib.sha256(content).hexdigest()[:16]}.png")
    if not os.path.exists(path):
        part = tempfile.NamedTemporaryFile(dir=folder, delete=False)
        try:
            with part:
                part.write(content)
            os.replace(part.name, path)
        except BaseException:
            os.unlink(part.name)
            raise
    return path


class SceneArguments(NamedTuple):
    """A scene as the compiled part takes it: a name or a path; or keys, meshes and a folder; the preset, and what is set."""

    scene: str | os.PathLike[str] | None
    text: dict[str, Any] | None
    meshes: list[tuple[str, Arrays] | None]
    folder: str
    preset: str | None
    settings: dict[str, Any]


def source(
    scene: str | os.PathLike[str] | Mapping[str, Any] | Scene, preset: str | None, settings: dict[str, Any]
) -> SceneArguments:
    """A scene as the compiled part takes it. `preset` takes the place of that of a `Scene`."""
    if isinstance(scene, (str, os.PathLike)):
        return SceneArguments(scene, None, [], "", _checked(preset), settings)
    if not isinstance(scene, (Scene, Mapping)):
        raise TypeError(f"a scene is a name, a path, a dictionary or a myxo.Scene, not of the type {type(scene).__name__}")
    made = scene if isinstance(scene, Scene) else Scene(scene)
    chosen = _checked(made.preset if preset is None else preset)
    return SceneArguments(None, made.table(), made.meshes(), made.folder, chosen, settings)


def _checked(preset: Any) -> str | None:
    if preset is None or isinstance(preset, str):
        return preset
    raise TypeError(f"preset is a text, the name of a preset or the path of one, not {preset!r}")


def nested(keys: Mapping[str, Any]) -> dict[str, Any]:
    """A dictionary whose dotted keys are dictionaries within."""
    table: dict[str, Any] = {}
    for key, value in keys.items():
        *sections, last = key.split(".")
        place = table
        for section in sections:
            place = place.setdefault(section, {})
            if not isinstance(place, dict):
                raise ValueError(f"the key `{key}` lies within `{section}`, which has a value")
        if isinstance(value, Mapping):
            value = nested(value)
            if isinstance(place.get(last), dict):
                place[last].update(value)
                continue
        place[last] = value
    return table


def in_order(values: ArrayLike, dtype: type[np.generic]) -> NDArray[Any]:
    """An array as the compiled part reads it: of this type, aligned, one row after the other."""
    return np.require(values, dtype, ["C", "A", "E"])


def arrays_of(mesh: Any, label: str) -> Arrays:
    """Vertices and faces of a pair of arrays, or of a mesh of trimesh or PyVista."""
    if hasattr(mesh, "regular_faces"):
        mesh = mesh if getattr(mesh, "is_all_triangles", True) else mesh.triangulate()
        vertices, faces = mesh.points, mesh.regular_faces
    elif hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        vertices, faces = mesh.vertices, mesh.faces
    else:
        try:
            vertices, faces = mesh
        except (TypeError, ValueError):
            raise TypeError(
                f"the mesh of `{label}` is a {type(mesh).__name__}: use a name, a path, a pair of arrays (vertices, faces), "
                "or a mesh of trimesh or PyVista"
            ) from None
    places = in_order(vertices, np.float64)
    corners = np.asarray(faces)
    if not (np.issubdtype(corners.dtype, np.integer) or corners.size == 0):
        raise TypeError(f"the faces of `{label}` are {corners.dtype}: they are numbers of vertices, integers")
    for array, what in ((places, "vertices"), (corners, "faces")):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"the {what} of `{label}` have the shape {array.shape}: (n, 3) is needed")
    return places, in_order(corners, np.int64)
