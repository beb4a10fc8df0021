"""The package as people use it: simulations, arrays, errors."""

import gc
import multiprocessing
import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time
import warnings

import myxo
import numpy as np
import pytest

SMALL = {"particles.count": 3000, "atlas.size": 128}


@pytest.fixture(scope="module")
def torus():
    with myxo.Simulation("torus", seed=7, settings=SMALL) as sim:
        yield sim.step(20)


def test_pictures_have_the_size_and_the_view_that_are_asked_for(torus):
    image = torus.render(120, 80)
    assert image.shape == (80, 120, 4) and image.dtype == np.uint8
    assert (image[..., 3] == 255).all() and image[..., :3].max() > 60
    clear = torus.render(120, 80, transparent=True)
    assert (clear[..., 3] < 30).any() and (clear[..., 3] == 255).any()
    relief = torus.render(120, 80, view="relief")
    assert (relief != image).any()
    assert (torus.render(120, 80) == image).all(), "a view is for one picture"
    smooth = torus.render(120, 80, passes=4)
    difference = np.abs(smooth.astype(int) - image.astype(int)).mean()
    assert 0 < difference < 3
    turned = torus.render(120, 80, settings={"camera.azimuth": 120})
    assert (turned != image).any()


def test_distances_are_shown_once_a_step_has_taken_them():
    settings = {**SMALL, "transfer.threshold": 0.01}
    with myxo.Simulation("trio", seed=7, settings=settings) as sim:
        for view in ("distance", "nearest"):
            with pytest.raises(ValueError, match="call step\\(\\) first"):
                sim.render(40, 30, view=view)
        sim.step()
        assert (sim.render(40, 30, view="distance") != sim.render(40, 30)).any()


def test_places_keep_their_digits_far_from_the_origin():
    """Near and far the same walk, on a mesh whose file has map coordinates and on an object that is put far away."""
    vertices, faces = tetrahedron()
    far = np.array([5_000_000.0, 3_000_000.0, 0.0])
    def grown(offset, position):
        scene = myxo.Scene(SMALL)
        scene.add("land", (vertices + offset, faces), position=list(position))
        with myxo.Simulation(scene, seed=7) as sim:
            sim.step(5)
            mesh, _ = sim.objects["land"].mesh
            pose = sim.objects["land"].pose
            world = mesh @ pose[:3, :3].T + pose[:3, 3]
            owned = sim.texel_object >= 0
            return sim.particles["position"], world, sim.texel_position[owned]
    near = grown(np.zeros(3), np.zeros(3))
    for offset, position in ((far, np.zeros(3)), (np.zeros(3), far)):
        for found, known in zip(grown(offset, position), near):
            assert found.dtype == np.float64
            assert np.abs(found - far - known).max() < 1e-5


def test_populations_have_rows_for_the_living():
    settings = {**SMALL, "particles.count": 300, "population.frequency": 1, "population.capacity": 2500}
    with myxo.Simulation("sphere", seed=7, settings=settings) as sim:
        assert sim.particles.shape == (300,)
        particles = sim.step(20).particles
        assert 300 < len(particles) <= 2500
        assert (np.abs(np.linalg.norm(particles["heading"], axis=1) - 1) < 1e-4).all()
        # Each of them has walked and left a deposit.
        assert sim.measures()["particles"] == len(particles) == sim.deposits.sum()


def test_arrays_agree_with_each_other(torus):
    side = torus["atlas.size"]
    trail, area, objects = torus.trail, torus.texel_area, torus.texel_object
    assert trail.shape == area.shape == objects.shape == (side, side)
    assert trail.dtype == np.float32 and trail.max() > 0
    assert torus.deposits.sum() == 3000
    owned = objects >= 0
    assert (torus.texel_triangle[owned] >= 0).all()
    assert np.isfinite(torus.texel_position[owned]).all() and np.isnan(torus.texel_position[~owned]).all()
    particles = torus.particles
    assert particles.shape == (3000,) and particles.dtype == myxo.PARTICLE
    lengths = np.linalg.norm(particles["heading"], axis=1)
    assert np.allclose(lengths, 1.0, atol=1e-3)
    # A particle lies where the texel under it does.
    column, row = np.floor(particles["texel"]).astype(int).T
    at = torus.texel_position[row, column]
    there = np.isfinite(at).all(axis=1)
    texel = np.sqrt(area[owned].mean())
    assert there.mean() > 0.9
    assert np.linalg.norm(at - particles["position"], axis=1)[there].max() < 4 * texel
    vertices, faces = torus.objects[0].mesh
    a, b, c = (vertices[faces[particles["triangle"], k]] for k in range(3))
    u, v = particles["uv"].T[..., None]
    assert np.allclose(a + u * (b - a) + v * (c - a), particles["position"], atol=1e-4)


def test_the_same_seed_gives_the_same_state_whatever_the_pieces():
    hashes = set()
    for pieces in ([12], [5, 7], [1] * 12):
        with myxo.Simulation("cube", seed=3, settings=SMALL) as sim:
            for count in pieces:
                sim.step(count)
                sim.render(40, 30)
            sim.validate()
            assert sim.steps == 12
            hashes.add(sim.state_hash)
    with myxo.Simulation("cube", seed=4, settings=SMALL) as sim:
        hashes.add(sim.step(12).state_hash)
    assert len(hashes) == 2


def test_a_checkpoint_and_exports_continue_and_can_be_read(tmp_path):
    with myxo.Simulation("pair", settings=SMALL) as sim:
        sim.step(6).save(tmp_path / "a.state")
        wanted = sim.step(6).state_hash
        sim.export(tmp_path / "a.npz")
        files = sim.export(tmp_path / "a.glb")
        trail, particles, deposits = sim.trail, sim.particles, sim.deposits
    assert files == [str(tmp_path / "a.glb")]
    with np.load(tmp_path / "a.npz") as arrays:
        assert str(arrays["state_hash"]) == wanted
        assert (arrays["trail"] == trail).all() and (arrays["deposit"] == deposits).all()
        for name in ("position", "heading", "object", "triangle", "uv", "texel", "pending"):
            assert (arrays[f"particle_{name}"] == particles[name]).all(), name
    with myxo.Simulation.resume(tmp_path / "a.state") as sim:
        assert sim.steps == 6 and sim.step(6).state_hash == wanted
    with pytest.raises(FileNotFoundError, match="none.state"):
        myxo.Simulation.resume(tmp_path / "none.state")


def test_a_scene_of_arrays_goes_on_with_the_values_of_its_checkpoint(tmp_path):
    """Catches values of the first run that are lost, or asked for again, and pictures that count as others in another process."""
    from myxo import _scene

    mask = np.linspace(0.2, 1.0, 32)[:, None] * np.ones(32)
    scene = myxo.Scene({"trail.decay": 0.9}).add("corner", tetrahedron())
    masked = {"particles.start_mask": mask}
    settings = {"atlas.size": 128, "particles.start": "mask", **masked}
    with myxo.Simulation(scene, particles=700, seed=5, settings=settings) as sim:
        sim["physarum.sensor_offset"] = 0.15
        sim.step(3).save(tmp_path / "a.state")
        wanted = sim.step(3).state_hash
        assert 'mesh = "memory:corner"' in sim.scene
    # As in another process.
    _scene._pictures.cleanup()
    _scene._pictures = None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with myxo.Simulation.resume(tmp_path / "a.state", scene, settings=masked) as sim:
            assert sim.steps == 3 and sim["seed"] == 5 and sim["particles.count"] == 700
            assert sim["physarum.sensor_offset"] == pytest.approx(0.15)
            assert sim.step(3).state_hash == wanted
        with myxo.Simulation.resume(tmp_path / "a.state", scene, settings={**masked, "trail.decay": 0.8}) as sim:
            assert sim["trail.decay"] == pytest.approx(0.8) and sim.step(3).state_hash != wanted
    with pytest.raises(ValueError, match="the scene here has 2 objects, and it was written with 1"):
        myxo.Simulation.resume(tmp_path / "a.state", myxo.Scene().add("a", tetrahedron()).add("b", tetrahedron()))
    with pytest.raises(ValueError, match="other meshes or scales"):
        vertices, faces = tetrahedron()
        myxo.Simulation.resume(tmp_path / "a.state", myxo.Scene().add("corner", (vertices + vertices[1], faces)), settings=masked)
    with pytest.raises(ValueError, match="mesh of `corner` was an array in Python: pass the scene to `Simulation.resume`"):
        myxo.Simulation.resume(tmp_path / "a.state")


def test_a_named_scene_that_differs_from_the_checkpoint_is_noted(tmp_path):
    with myxo.Simulation("cube", settings=SMALL) as sim:
        sim["trail.decay"] = 0.9
        sim.save(tmp_path / "a.state")
    with pytest.warns(RuntimeWarning, match="goes on from the checkpoint .*a.state: trail.decay = .*, which was 0.9"):
        myxo.Simulation.resume(tmp_path / "a.state", "cube", settings=SMALL).close()


def test_a_scene_of_arrays_leaves_python_as_files(tmp_path):
    """Catches a scene file whose meshes are nowhere, and meshes that are others when they are read."""
    vertices, faces = tetrahedron()
    # With a face that is dropped.
    faces = np.concatenate([[[1, 1, 2]], faces])
    scene = myxo.Scene().add("left one", (vertices / 3.0, faces)).add("right", "builtin:icosphere", position=[3, 0, 0])
    with myxo.Simulation(scene, seed=4, settings=SMALL) as sim:
        files = sim.export(tmp_path / "x.toml")
        assert files == [str(tmp_path / "x.toml"), str(tmp_path / "x_left_one.ply")]
        mesh = sim.objects["left one"].mesh
        wanted = sim.step(4).state_hash
    with myxo.Simulation(tmp_path / "x.toml") as sim:
        for found, known in zip(sim.objects["left one"].mesh, mesh):
            assert (found == known).all()
        assert sim.step(4).state_hash == wanted
        assert sim["seed"] == 4 and "x_left_one.ply" in sim.scene


def test_arrays_of_a_scene_may_change_afterwards():
    vertices, faces = tetrahedron()
    faces = faces.astype(np.int64)
    scene = myxo.Scene().add("a", (vertices, faces))
    vertices[:] = 7.0
    faces[:] = 0
    ((_, (kept, corners)),) = scene.meshes()
    assert (kept == tetrahedron()[0]).all() and (corners == tetrahedron()[1]).all()


def test_parameters_are_read_and_changed_while_it_runs():
    with myxo.Simulation("torus", settings=SMALL) as sim:
        sim["physarum.speed"] = 0.006
        assert sim["physarum.speed"] == pytest.approx(0.006)
        sim["physarum.sensor_angle"] = np.float32(30)
        sim.update({"trail.decay": 0.9, "picture.show": "relief"})
        assert sim["trail.decay"] == pytest.approx(0.9) and sim["picture.show"] == "relief"
        assert sim["object.0.scale"] == 1.0
        with pytest.raises(KeyError, match="do you mean `physarum.speed`"):
            sim["physarum.sped"] = 1
        with pytest.raises(ValueError, match="trail.decay"):
            sim.update({"physarum.speed": 0.01, "trail.decay": 7})
        assert sim["physarum.speed"] == pytest.approx(0.006), "all or nothing"
        with pytest.raises(ValueError, match="particles.count"):
            sim["particles.count"] = 10
        with pytest.raises(TypeError, match="object"):
            sim["trail.decay"] = object()
    keys = {row["key"] for row in myxo.parameters()}
    assert {"physarum.speed", "trail.decay"} <= keys
    assert "torus" in myxo.scenes() and "network" in myxo.presets()


def test_parameters_of_every_list_are_read_and_changed():
    """Would catch: keys of pulses that scene files have, and that are none of a simulation."""
    scene = {
        "object": [{"mesh": "builtin:cube"}],
        "food": [{"at": [0, 1, 0], "radius": 0.4}],
        "pulse": [{"at": [0, 0, 0], "speed": 0.01}, {"step": 3}],
    }
    with myxo.Simulation(scene, settings=SMALL) as sim:
        assert sim["pulse.0.speed"] == pytest.approx(0.01) and sim["pulse.1.step"] == 3
        sim["pulse.0.speed"] = 0.02
        sim.update({"pulse.1.width": 0.5, "food.0.radius": 0.3})
        assert sim["pulse.0.speed"] == pytest.approx(0.02) and sim["pulse.1.width"] == pytest.approx(0.5)
        assert sim["food.0.radius"] == pytest.approx(0.3)
        sim.step(5).validate()
        for key in ("pulse.2.speed", "pulse.0.sped"):
            with pytest.raises(KeyError, match=key):
                sim[key] = 0.01


def test_texts_stay_texts_whatever_they_look_like():
    scene = {"object": [{"mesh": "builtin:cube", "name": name} for name in ("1", "true")], "food": [{"object": "1", "at": [0, 1, 0]}]}
    with myxo.Simulation(scene, settings=SMALL) as sim:
        assert sim["food.0.object"] == "1"
        sim["food.0.object"] = "true"
        assert sim["food.0.object"] == "true"


def test_a_picture_that_is_too_large_says_what_to_do(torus):
    """Would catch: an error of the device that says nothing about the size of the picture."""
    # Large cards have room for it.
    if "llvmpipe" not in torus.device:
        pytest.skip("the device may have room for it")
    with pytest.raises(ValueError, match="a picture of 16384 x 16384 .*: use a smaller `width` or `height`"):
        torus.render(16384, 16384)
    assert torus.render(40, 30).shape == (30, 40, 4)


def tetrahedron():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    return vertices, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def test_meshes_are_arrays_and_poses_come_from_outside():
    vertices, faces = tetrahedron()
    scene = myxo.Scene({"trail": {"decay": 0.9}})
    scene.add("left", (vertices, faces)).add("right", "builtin:icosphere", position=[3, 0, 0])
    with myxo.Simulation(scene, settings=SMALL) as sim:
        assert list(sim.objects) == ["left", "right"] and sim["trail.decay"] == pytest.approx(0.9)
        found, corners = sim.objects["left"].mesh
        assert len(found) == 4 and len(corners) == 4
        assert {tuple(row) for row in found.round(5).tolist()} == {tuple(row) for row in vertices.tolist()}
        assert sim.objects["right"].pose[0, 3] == pytest.approx(3)
        pose = np.eye(4)
        pose[:3, 3] = [0, 2, 0]
        sim.objects["left"].pose = pose
        sim.step(3)
        assert np.allclose(sim.objects["left"].pose, pose)
        on_left = sim.particles[sim.particles["object"] == 0]
        assert on_left["position"][:, 1].min() >= 2 - 1e-5
        sim.objects["left"].pose = None
        assert np.allclose(sim.step().objects["left"].pose, np.eye(4))
        for wrong in (np.eye(3), 2 * np.eye(4), np.diag([2.0, 1, 1, 1])):
            with pytest.raises(ValueError, match="pose|rigid"):
                sim.objects["left"].pose = wrong
        with pytest.raises(KeyError, match="left, right"):
            sim.objects["middle"]
    as_dictionary = {"object": [{"mesh": (vertices, faces), "name": "a"}], "trail.decay": 0.8}
    with myxo.Simulation(as_dictionary, settings=SMALL) as sim:
        assert sim["trail.decay"] == pytest.approx(0.8) and list(sim.objects) == ["a"]


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        (np.zeros((4, 2)), [[0, 1, 2]], r"vertices of `m` have the shape \(4, 2\)"),
        (np.zeros((4, 3)), [[0, 1]], r"faces of `m` have the shape"),
        (np.zeros((4, 3)), [[0.5, 1, 2]], "integers"),
        (np.zeros((4, 3)), [[0, 1, 9]], "corner 9"),
        (np.zeros((4, 3)), [[0, 1, -1]], "corner -1"),
        (np.zeros((4, 3)), np.zeros((0, 3), int), "no triangles"),
        (np.zeros((4, 3)), [[0, 1, 2]], "none has an area"),
        (np.full((4, 3), np.nan), [[0, 1, 2]], "m"),
    ],
)
def test_bad_meshes_are_refused_in_a_sentence(vertices, faces, says):
    with pytest.raises((ValueError, TypeError), match=says) as raised:
        myxo.Simulation(myxo.Scene().add("m", (vertices, np.asarray(faces))), settings=SMALL)
    assert "\n" not in str(raised.value)


def test_bad_scenes_devices_and_pictures_are_refused(torus, tmp_path):
    with pytest.raises(ValueError, match="there is no scene `toros`, did you mean `torus`"):
        myxo.Simulation("toros")
    with pytest.raises(ValueError, match="particles.count"):
        myxo.Simulation("torus", particles=-1)
    for seed in (-1, 2**32):
        with pytest.raises(ValueError, match=f"a seed is from 0 to 4294967295, not {seed}"):
            myxo.Simulation("torus", seed=seed)
    with pytest.raises(TypeError, match="a seed is a whole number, not 1.5"):
        myxo.Simulation("torus", seed=1.5)
    with pytest.raises(TypeError, match="a scene is a name, a path, a dictionary or a myxo.Scene, not of the type int"):
        myxo.Simulation(3)
    with pytest.raises(TypeError, match="a number of steps is a whole number, not '3'"):
        torus.step("3")
    for missing in ({"scene": "nope.obj"}, {"scene": "nope.toml"}, {"scene": "torus", "preset": "nope.toml"}):
        with pytest.raises(FileNotFoundError, match="nope"):
            myxo.Simulation(**missing)
    with pytest.raises(myxo.DeviceError):
        myxo.Simulation("torus", settings=SMALL, device="no such device")
    with pytest.raises(TypeError, match="list of dictionaries"):
        myxo.Scene({"object": "torus"})
    with pytest.raises(ValueError, match="object 0 of the scene has no mesh"):
        myxo.Scene({"object": [{"name": "a"}]})
    with pytest.raises(ValueError, match="0 x 10"):
        torus.render(0, 10)
    with pytest.raises(ValueError, match="shiny"):
        torus.render(10, 10, view="shiny")
    with pytest.raises(ValueError, match="Distance cannot be shown"):
        torus.render(10, 10, view="distance")
    with pytest.raises(ValueError, match="-1"):
        torus.step(-1)
    with pytest.raises(ValueError, match="ending|a.xyz"):
        torus.export(tmp_path / "a.xyz")
    with pytest.raises(OSError):
        torus.save("/proc/none/a.state")


def test_a_closed_simulation_says_so_and_frees_its_device():
    sim = myxo.Simulation("torus", settings=SMALL)
    sim.close()
    sim.close()
    for use in (sim.step, lambda: sim.trail, lambda: sim.steps, lambda: sim.render(9, 9)):
        with pytest.raises(RuntimeError, match="closed"):
            use()
    assert "closed" in repr(sim) and sim._repr_png_() is None
    gc.collect()


def test_several_run_in_one_process_and_from_other_threads():
    sims = [myxo.Simulation("torus", seed=seed, settings=SMALL) for seed in (1, 2, 1)]
    threads = [threading.Thread(target=sim.step, args=(10,)) for sim in sims]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    first, second, third = [sim.state_hash for sim in sims]
    assert first == third != second
    for sim in sims:
        sim.close()


def test_other_threads_go_on_and_ctrl_c_ends_steps():
    sim = myxo.Simulation("torus", settings=SMALL)
    counted = []
    begun = time.monotonic()
    interrupt = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    ticks = threading.Thread(target=lambda: [counted.append(time.sleep(0.02)) for _ in range(30)])
    interrupt.start(), ticks.start()
    with pytest.raises(KeyboardInterrupt):
        sim.step(10**7)
    # All 30 ticks, 0.6 s, came before the interrupt; had the steps kept other threads waiting, few would have.
    assert len(counted) >= 25 and time.monotonic() - begun < 20
    ticks.join()
    done = sim.steps
    assert 0 < done < 10**7
    sim.step().validate()
    assert sim.steps == done + 1
    sim.close()


def test_ctrl_c_ends_the_set_up(tmp_path, monkeypatch):
    """Catches a constructor that goes on to its end, which is a layout of tens of seconds here."""
    # Nothing is cached there.
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    begun = time.monotonic()
    interrupt = threading.Timer(2.0, os.kill, (os.getpid(), signal.SIGINT))
    interrupt.start()
    with pytest.raises(KeyboardInterrupt):
        sim = myxo.Simulation("builtin:icosphere?subdivisions=8", settings={"particles.count": 1000, "atlas.size": 2048})
        # It was fast.
        sim.close()
        time.sleep(5)
    assert time.monotonic() - begun < 30
    interrupt.join()


# What a forked process has of the one before it.
INHERITED = []


def begins_its_own():
    myxo.Simulation("cube", settings=SMALL)


def steps_what_it_has():
    INHERITED[0].step()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no forks, or no safe ones")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_says_what_to_do(torus):
    """Catches a process that waits for threads that it has not, for ever."""
    INHERITED[:] = [torus]
    with multiprocessing.get_context("fork").Pool(1) as pool:
        for work in (begins_its_own, steps_what_it_has):
            with pytest.raises(RuntimeError, match=r"was forked .*: use multiprocessing.get_context\('spawn'\)"):
                pool.apply_async(work).get(timeout=60)
    INHERITED.clear()
    torus.validate()


def test_misspelled_attributes_are_refused(torus):
    for thing, name in ((torus, "trial"), (torus, "speed"), (torus.objects, "pose"), (torus.objects[0], "poses")):
        with pytest.raises(AttributeError, match=name):
            setattr(thing, name, 0.01)
    with pytest.raises(AttributeError):
        torus.objects[0].name = "other"
    assert torus.objects[0].name == "torus" and torus.objects["torus"].number == 0


def test_notebooks_show_the_picture_and_help_is_complete(torus):
    assert torus._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    assert "torus" in repr(torus) and "step" in repr(torus)
    for kind in (myxo.Simulation, myxo.Scene, myxo.Object, myxo.Objects):
        assert kind.__doc__
        for name in vars(kind):
            if not name.startswith("_"):
                assert getattr(kind, name).__doc__, f"{kind.__name__}.{name}"


def test_fields_can_be_set():
    """Catches fields that come back changed, gutters that keep old values, and values that no particle can bear."""
    settings = {"particles.count": 2000, "atlas.size": 64, "second_look.preset": "lace"}
    with myxo.Simulation("cube", settings=settings) as sim, myxo.Simulation("cube", settings=settings) as other:
        sim.step(4)
        other.step(4)
        before = other.state_hash
        other.trail = other.trail
        other.bias = other.bias
        assert other.state_hash == before
        with myxo.Simulation("cube", settings=settings) as untouched:
            assert other.step(6).state_hash == untouched.step(10).state_hash
        sim.trail = np.where(sim.texel_area > 0, 7.0, 0.0)
        assert (sim.trail[sim.texel_area > 0] == 7.0).all() and sim.measures()["mean_trail"] == pytest.approx(7.0)
        sim.validate()
        walls = np.zeros((64, 64), dtype=np.float32)
        walls[sim.texel_triangle >= 6] = myxo.NO_GO
        sim.bias = walls
        assert (sim.bias == walls)[sim.texel_area > 0].all()
        sim.second_look = 0.5 * (sim.texel_area > 0)
        assert (sim.second_look[sim.texel_area > 0] == 0.5).all()
        inside = sim.particles["triangle"] < 6
        sim.step(30)
        sim.validate()
        # Those that stood outside of the walls have not gone in.
        assert (sim.particles["triangle"][inside] < 6).mean() > 0.99
        assert sim.state_hash != other.step(24).state_hash
        for name, values, why in [
            ("trail", np.zeros((63, 64)), "(64, 64) is needed"),
            ("trail", np.full((64, 64), -1.0), "the trail is from 0"),
            ("trail", np.full((64, 64), np.nan), "the trail is from 0"),
            ("trail", np.full((64, 64), 1e30), "the trail is from 0"),
            ("bias", np.full((64, 64), 1e7), "a bias is from"),
            ("second_look", np.full((64, 64), 1.5), "a weight is from 0 to 1"),
            ("trail", np.zeros(64), "(texels, texels) is needed"),
        ]:
            with pytest.raises(ValueError, match=re.escape(why)):
                setattr(sim, name, values)
        # More than a brush paints, as strong deposits make it.
        other.trail = np.where(other.texel_area > 0, 3e6, 0.0)
        assert (other.trail[other.texel_area > 0] == 3e6).all()


def test_arrays_are_read_whatever_their_layout():
    """Catches members of tables, whose strides are no whole numbers of elements, and arrays that are not aligned."""
    from myxo import _scene

    def misaligned(array):
        other = np.frombuffer(b"\0" + array.tobytes(), array.dtype, offset=1).reshape(array.shape)
        assert not other.flags.aligned
        return other

    vertices, faces = tetrahedron()
    for read, given in zip(_scene.arrays_of((misaligned(vertices), misaligned(faces)), "m"), (vertices, faces)):
        assert read.flags.aligned and (read == given).all()
    values = np.arange(64 * 64, dtype=np.float32).reshape(64, 64)
    table = np.zeros((64, 64), dtype=[("flag", "u1"), ("trail", "<f4")])
    table["trail"] = values
    with myxo.Simulation("cube", settings={"particles.count": 500, "atlas.size": 64}) as sim:
        owned = sim.texel_area > 0
        for given in (table["trail"], misaligned(values)):
            sim.trail = np.zeros((64, 64))
            with pytest.raises(ValueError, match="not aligned"):
                sim._engine.set_field("trail", given)
            sim.trail = given
            assert (sim.trail == values)[owned].all()
        pose = np.eye(4)
        pose[:3, 3] = [0, 2, 0]
        with pytest.raises(ValueError, match="not aligned"):
            sim._engine.set_pose(0, misaligned(pose))
        sim.objects[0].pose = misaligned(pose)
        assert np.allclose(sim.step().objects[0].pose, pose)


def test_a_picture_of_a_map_is_whole_or_not_there():
    """Catches a picture that was cut short by a full disk and is taken for whole the next time."""
    from myxo import _scene

    noise = np.random.default_rng(1).integers(0, 256, (64, 64, 3))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(OSError):
            _scene._picture("areas.map", noise)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    path = _scene._picture("areas.map", noise)
    with open(path, "rb") as file:
        assert b"IEND" in file.read()[-12:]
    assert all(name.endswith(".png") for name in os.listdir(os.path.dirname(path)))


def test_maps_can_be_pictures():
    """Catches pictures that are upside down, and those that no file can hold."""
    mask = np.zeros((32, 32))
    mask[:16] = 1.0
    settings = {"particles.count": 500, "atlas.size": 64, "particles.start": "mask", "particles.start_mask": mask}
    with myxo.Simulation("plane", settings=settings) as sim:
        first = sim.particles["texel"]
    settings["particles.start_mask"] = mask[::-1]
    with myxo.Simulation("plane", settings=settings) as sim:
        assert not np.array_equal(first, sim.particles["texel"])
    scene = myxo.Scene({"particles.count": 100, "areas": {"map": np.zeros((4, 4, 3), dtype=np.uint8)}})
    scene.add("floor", "builtin:plane")
    with pytest.raises(ValueError, match="area map says nothing"):
        myxo.Simulation(scene)
    for bad, why in [(np.zeros((4, 4, 2)), "has the shape"), (np.full((4, 4), 2.0), "beyond 0 to 1"), (np.full((4, 4), 300), "beyond 0 to 255")]:
        with pytest.raises(ValueError, match=why):
            myxo.Simulation("plane", settings={"particles.start": "mask", "particles.start_mask": bad})


def test_measures_agree_with_a_graph_library():
    """Catches pieces and regions that are counted by other neighbours than is said."""
    import networkx

    with myxo.Simulation("plane", particles=20_000, settings={"atlas.size": 128}) as sim:
        sim.step(60)
        trail, owned, measures = sim.trail, sim.texel_area > 0, sim.measures()
    network = owned & (trail > np.float32(1.5 * measures["mean_trail"]))

    def parts(of, steps):
        graph = networkx.Graph()
        places = {tuple(place) for place in np.argwhere(of)}
        graph.add_nodes_from(places)
        for row, column in places:
            graph.add_edges_from(((row, column), other) for dr, dc in steps if (other := (row + dr, column + dc)) in places)
        return sum(len(part) >= 9 for part in networkx.connected_components(graph))

    sides = [(0, 1), (1, 0)]
    assert parts(network, [*sides, (1, 1), (1, -1)]) == measures["pieces"] > 1
    assert parts(owned & ~network, sides) == measures["regions"] > 1


def test_the_network_is_a_graph(torus, tmp_path):
    """Catches edges whose nodes do not exist, measures that a graph library does not find, and files that it does not read."""
    import networkx

    whole = torus.network()
    graph = networkx.MultiGraph()
    graph.add_nodes_from((number, node) for number, node in enumerate(whole["nodes"]))
    graph.add_edges_from((edge["from"], edge["to"], edge) for edge in whole["edges"])
    measures = whole["measures"]
    assert graph.number_of_nodes() == measures["nodes"] > 10
    assert networkx.number_connected_components(graph) == measures["parts"]
    assert graph.number_of_edges() - measures["nodes"] + measures["parts"] == measures["cycles"]
    assert [node["degree"] for node in whole["nodes"]] == [degree for _, degree in graph.degree()]
    assert {node["object"] for node in whole["nodes"]} == {"torus"}
    bridges = networkx.bridges(networkx.Graph(graph))
    single = [edge for edge in bridges if graph.number_of_edges(*edge) == 1]
    at_risk = sum(graph.edges[(*edge, 0)]["length"] for edge in single)
    assert measures["tolerance"] == pytest.approx(1 - at_risk / measures["length"])
    # Half of an outline is more than the line in its middle.
    assert 0 < measures["length"] < torus.measures()["length"]
    program = os.environ.get("MYXO_PROGRAM")
    if program is None:
        pytest.skip("MYXO_PROGRAM names no program")
    torus.save(tmp_path / "torus.state")
    file = tmp_path / "torus.graphml"
    command = [program, "network", "--resume", tmp_path / "torus.state", "--steps", "0", "--out", file]
    subprocess.run(command, check=True, capture_output=True)
    read = networkx.read_graphml(file, node_type=int, force_multigraph=True)
    assert sorted(read.edges()) == sorted(graph.edges()) and read.graph["state_hash"] == torus.state_hash
    assert sum(length for *_, length in read.edges(data="length")) == pytest.approx(measures["length"])
    assert read.nodes[3]["kind"] == graph.nodes[3]["kind"] and read.nodes[3]["x"] == graph.nodes[3]["place"][0]
