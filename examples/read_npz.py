#!/usr/bin/env python3
"""Reads what `myxo export SCENE --out FILE.npz` writes, prints what is in it, checks it, and plots it.

    myxo export torus --steps 400 --out torus.npz
    python3 examples/read_npz.py torus.npz torus_plots.png

docs/npz.md says what every array means. Needs Python 3.11 and numpy, and matplotlib for the plots:

    sudo apt-get install python3-numpy python3-matplotlib     (or: pip install numpy matplotlib)
"""

import sys


def missing(package):
    sys.exit(f"read_npz: {package} is missing; install it: "
             f"sudo apt-get install python3-{package}, or pip install {package}")


try:
    import tomllib
except ImportError:
    sys.exit("read_npz: this Python is too old; use Python 3.11 or later")
try:
    import numpy as np
except ImportError:
    missing("numpy")


def describe(data):
    """One line for each array."""
    for name in data.files:
        array = data[name]
        if array.ndim == 0:
            text = str(array)
            value = text if len(text) <= 40 else f"{len(text)} characters"
        elif array.dtype.kind == "f" and array.size:
            value = f"{np.nanmin(array):.6g} ... {np.nanmax(array):.6g}"
        else:
            value = ""
        print(f"{name:22} {str(array.dtype):7} {str(array.shape):18} {value}")


def has_one_a_cell(data):
    """Is there one particle a cell? Then particles that stay, because the cells before them are taken, leave no trail."""
    physarum = tomllib.loads(str(data["scene_toml"]))["physarum"]
    return physarum["model"] == "jones" or physarum["occupancy_rounds"] > 0


def check(data):
    """What holds in every state, by arrays alone: a reader that mixes something up fails here."""
    corners = data["vertex_position"][data["triangle_vertices"]]
    triangle, uv = data["particle_triangle"], data["particle_uv"]
    assert (data["triangle_object"][triangle] == data["particle_object"]).all()
    a, b, c = (corners[triangle, k] for k in range(3))
    local = a + uv[:, :1] * (b - a) + uv[:, 1:] * (c - a)
    pose = data["world_from_object"][data["particle_object"]]
    world = np.einsum("nij,nj->ni", pose[:, :3, :3], local) + pose[:, :3, 3]
    unit = float(data["scene_radius"])
    assert np.abs(world - data["particle_position"]).max(initial=0) < 1e-5 * unit
    length = np.linalg.norm(data["particle_heading"], axis=1)
    assert np.abs(length - 1).max(initial=0) < 1e-4
    # Every particle lies in the texel that its place in the atlas says.
    a, b, c = (data["triangle_texels"][triangle, k] for k in range(3))
    texel = a + uv[:, :1] * (b - a) + uv[:, 1:] * (c - a)
    assert np.abs(texel - data["particle_texel"]).max(initial=0) < 1e-2
    owned = data["texel_triangle"] >= 0
    assert (np.isfinite(data["texel_position"]).all(axis=2) == owned).all()
    assert (data["trail"] >= 0).all() and np.isfinite(data["trail"]).all()
    with_food = "food_object" in data.files
    if data["step"] > 0 and not with_food:
        count = data["deposit"].sum()
        assert count <= len(triangle), "no particle deposits twice a step"
        assert count == len(triangle) or has_one_a_cell(data), "each particle deposits once a step"
    if with_food:
        check_food(data, corners)
    print(f"checked: {len(triangle)} particles, {owned.sum()} texels with a surface")
    print(f"made by: myxo {data['version']} (commit {data['commit'] or 'unknown'}) on {data['device']}, "
          f"state hash {data['state_hash']}")


def check_food(data, corners):
    """Foods lie where their triangles are, and particles have not eaten more than there was."""
    triangle, uv, kind = data["food_triangle"], data["food_uv"], data["food_object"]
    assert (data["triangle_object"][triangle] == kind).all()
    a, b, c = (corners[triangle, k] for k in range(3))
    local = a + uv[:, :1] * (b - a) + uv[:, 1:] * (c - a)
    pose = data["world_from_object"][kind]
    world = np.einsum("nij,nj->ni", pose[:, :3, :3], local) + pose[:, :3, 3]
    assert np.abs(world - data["food_position"]).max() < 1e-5 * float(data["scene_radius"])
    amount, left = data["food_amount"], data["food_remaining"]
    assert (left <= amount).all() and ((left == -1) == (amount == -1)).all()
    if data["step"] > 0 and not has_one_a_cell(data):
        assert data["deposit"].sum() >= len(data["particle_uv"]), "fed ones count more than once"
    # A scent is no stronger than all that is left of all foods together.
    share = np.where(amount > 0, left / np.maximum(amount, 1), 1)
    strength = data["food_strength"] * np.minimum(share + 1 / 64, 1) * (share > 0)
    scent, slack = data["scent"], 1e-4 * np.abs(data["food_strength"]).sum()
    assert scent.max() <= strength.clip(min=0).sum() + slack
    assert scent.min() >= strength.clip(max=0).sum() - slack
    eaten = (amount - left)[amount > 0].sum()
    print(f"food: {len(amount)} foods and markers, {eaten} meals eaten, scent on {(scent != 0).sum()} texels")


def plot(data, picture):
    """The trail in the atlas; particles in space; where there are several objects, their distances."""
    try:
        import matplotlib
    except ImportError:
        missing("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    trail = np.where(data["texel_triangle"] >= 0, data["trail"], np.nan)
    with_distance = "distance" in data.files
    figure = plt.figure(figsize=(18 if with_distance else 12, 5.5), layout="constrained")
    figure.suptitle(f"{data['scene_name']}, step {data['step']}, seed {data['seed']}")
    columns = 3 if with_distance else 2

    axes = figure.add_subplot(1, columns, 1, title="trail in the atlas", xlabel="texels", ylabel="texels")
    top = np.nanpercentile(trail, 99.5) if np.isfinite(trail).any() else 1
    image = axes.imshow(trail, cmap="magma", vmin=0, vmax=max(top, 1e-9), interpolation="nearest")
    figure.colorbar(image, ax=axes, shrink=0.8, label="trail")

    axes = figure.add_subplot(1, columns, 2, projection="3d", title="particles, by the trail under them")
    position = data["particle_position"]
    some = np.linspace(0, len(position) - 1, min(len(position), 20_000)).astype(int)
    x, y, z = position[some].T
    column, row = data["particle_texel"][some].astype(int).T
    # y is up in myxo, z in matplotlib.
    axes.scatter(x, -z, y, c=data["trail"][row, column], s=1, cmap="magma", vmin=0, vmax=max(top, 1e-9))
    if "food_position" in data.files:
        # As large as what is left of them.
        amount, left = data["food_amount"], data["food_remaining"]
        share = np.where(amount > 0, left / np.maximum(amount, 1), 1)
        x, y, z = data["food_position"].T
        axes.scatter(x, -z, y, c="limegreen", edgecolors="black", s=10 + 90 * share, depthshade=False, label="food")
        axes.legend(loc="upper right")
    axes.set(xlabel="x", ylabel="-z", zlabel="y")
    axes.set_aspect("equal")

    if with_distance:
        axes = figure.add_subplot(1, columns, 3, title="signed distance to other objects", xlabel="texels")
        distance = data["distance"]
        reach = np.nanmax(np.abs(distance))
        image = axes.imshow(distance, cmap="coolwarm_r", vmin=-reach, vmax=reach, interpolation="nearest")
        figure.colorbar(image, ax=axes, shrink=0.8, label="world units")
    figure.savefig(picture, dpi=100)
    print(f"plotted: {picture}")


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: read_npz.py FILE.npz [PICTURE.png]")
    with np.load(sys.argv[1], allow_pickle=False) as data:
        describe(data)
        check(data)
        if len(sys.argv) == 3:
            plot(data, sys.argv[2])


if __name__ == "__main__":
    main()
