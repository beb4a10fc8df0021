//! Exports equal the state: models, meshes, arrays and scene files hold the simulation's values.

mod npz;
mod picture;

use std::io::Cursor;
use std::path::Path;

use crate::common::{Gpu, TRIO, gpu, scene_of_several};
use glam::{DAffine3, DMat4, DQuat, DVec3, Vec2, Vec3};
use image::RgbImage;
use myxo::export::{Colors, Export, ExportFile, ExportOnTheWay, Format, Watch};
use myxo::gpu::Frames;
use myxo::mesh::Mesh;
use myxo::mesh::surface::NONE;
use myxo::scene::settings::{ColorMap, FoodSettings, ObjectSettings};
use myxo::scene::{Overrides, Scene};
use myxo::sim::paint::NO_GO_BELOW;
use myxo::sim::{Simulation, Snapshot};
use npz::Arrays;

/// A simulation after some steps.
struct Run {
    scene: Scene,
    simulation: Simulation,
    snapshot: Snapshot,
}

impl Run {
    fn of(gpu: &Gpu, scene: Scene, steps: u32) -> Self {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
        for _ in 0..steps {
            let mut rec = frames.begin().unwrap();
            simulation.record_step(&mut rec);
            frames.submit(rec).unwrap();
        }
        frames.wait_idle().unwrap();
        let snapshot = simulation.snapshot().unwrap();
        Self {
            scene,
            simulation,
            snapshot,
        }
    }

    fn export(&self) -> Export<'_> {
        Export::of(&self.scene, &self.simulation, &self.snapshot).unwrap()
    }

    fn bytes(&self, format: Format, colors: Colors) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        self.export().write(format, colors, &mut out).unwrap();
        out.into_inner()
    }
}

/// Three objects that touch, one of which turns, after some steps.
fn moving_trio(gpu: &Gpu) -> Run {
    let scene = scene_of_several(&TRIO, |settings| {
        settings.particles.count = 5000;
        settings.atlas.size = 256;
        settings.seed = 11;
        settings.objects[2].motion.spin = [0.0, 200.0, 0.0];
        settings.objects[2].motion.orbit = [0.0, 90.0, 0.0];
        settings.time.dt = 0.05;
    });
    Run::of(gpu, scene, 25)
}

/// The parts of a GLB, as the `gltf` crate reads and validates them.
fn parts(bytes: &[u8]) -> (gltf::Gltf, Vec<u8>) {
    let mut model = gltf::Gltf::from_slice(bytes).expect("it is valid glTF");
    let binary = model.blob.take().expect("everything is inside");
    (model, binary)
}

/// The texture of the base colour or of the emission.
fn texture_of(model: &gltf::Gltf, binary: &[u8], glows: bool) -> RgbImage {
    let material = model.materials().next().expect("there is a material");
    let base = material.pbr_metallic_roughness().base_color_texture();
    let texture = if glows {
        material.emissive_texture()
    } else {
        base
    };
    let image = texture.expect("there is a texture").texture().source();
    let gltf::image::Source::View { view, mime_type } = image.source() else {
        panic!("it is inside");
    };
    assert_eq!(mime_type, "image/png");
    let bytes = &binary[view.offset()..view.offset() + view.length()];
    image::load_from_memory(bytes).expect("a PNG").to_rgb8()
}

#[test]
fn a_model_has_every_object_at_its_pose_with_normals_and_trail() {
    let Some(gpu) = gpu() else { return };
    let run = moving_trio(&gpu);
    let setup = run.simulation.setup();
    let bytes = run.bytes(Format::Glb, Colors::Texture);
    assert_eq!(bytes, run.bytes(Format::Glb, Colors::Texture), "same bits");
    let (model, binary) = parts(&bytes);
    let poses = run.simulation.world_from_object();
    assert_ne!(poses[2], run.scene.world_from_object()[2], "it has moved");
    let texture = texture_of(&model, &binary, false);
    assert_eq!((texture.width(), texture.height()), (256, 256));

    let nodes: Vec<_> = model.nodes().filter(|node| node.mesh().is_some()).collect();
    assert_eq!(nodes.len(), 3);
    assert_eq!(model.cameras().count(), 1);
    for (object, node) in nodes.iter().enumerate() {
        assert_eq!(
            node.name(),
            Some(run.scene.settings.objects[object].name.as_str())
        );
        let columns = node.transform().matrix();
        let world_from_object = glam::Mat4::from_cols_array_2d(&columns);
        let expected = glam::Mat4::from(poses[object]);
        assert!(
            world_from_object.abs_diff_eq(expected, 1e-5),
            "object {object}"
        );
        let mesh = node.mesh().expect("only those are listed");
        let primitive = mesh.primitives().next().expect("it has triangles");
        let reader = primitive.reader(|_| Some(&binary));
        let positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
        let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
        let places: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!([normals.len(), places.len()], [positions.len(); 2]);
        let bounds = primitive.bounding_box();
        let range = setup.surface.objects[object];
        let first = range.triangles.0 as usize;
        assert_eq!(indices.len(), 3 * (range.triangles.1 as usize - first));
        for (corner, &index) in indices.iter().enumerate() {
            let (triangle, k) = (first + corner / 3, corner % 3);
            let vertex = setup.surface.corners[triangle][k] as usize;
            let index = index as usize;
            assert_eq!(positions[index], setup.surface.positions[vertex]);
            assert!(positions[index].cmpge(Vec3::from(bounds.min)).all());
            assert!(positions[index].cmple(Vec3::from(bounds.max)).all());
            assert!(normals[index].is_normalized());
            let [u, v] = [f32::from(k == 1), f32::from(k == 2)];
            let texel = setup.atlas.position_of(triangle as u32, u, v);
            let off = (256.0 * Vec2::from(places[index])).distance(texel);
            assert!(off < 0.05, "corner {corner}: {off} texels");
        }
    }
    // With vertex colours there is no texture, which would be multiplied with them.
    let (model, binary) = parts(&run.bytes(Format::Glb, Colors::Vertex));
    assert_eq!(model.images().count() + model.textures().count(), 0);
    let mesh = model.meshes().next().expect("the first object");
    let primitive = mesh.primitives().next().expect("it has triangles");
    let reader = primitive.reader(|_| Some(&binary));
    let colors: Vec<[f32; 4]> = reader.read_colors(0).unwrap().into_rgba_f32().collect();
    let trail = primitive.get(&gltf::Semantic::Extras("TRAIL".to_owned()));
    let trail = trail.expect("the trail is an attribute of its own");
    let view = trail.view().expect("it has values");
    let trail: &[f32] = bytemuck::cast_slice(&binary[view.offset()..view.offset() + view.length()]);
    assert_eq!(trail.len(), colors.len());
    let export = run.export();
    let paint = export.paint();
    for (&trail, color) in trail.iter().zip(&colors) {
        let expected = paint.color(trail, 0.0).min(Vec3::ONE).extend(1.0);
        assert!(glam::Vec4::from(*color).abs_diff_eq(expected, 1e-4));
    }
    assert!(trail.iter().any(|&trail| trail > 0.0));
    gpu.finish();
}

/// Read by the lines below and no crate: a header of text, then records.
#[test]
fn a_ply_has_world_positions_normals_colours_and_trail() {
    let Some(gpu) = gpu() else { return };
    let run = moving_trio(&gpu);
    let bytes = run.bytes(Format::Ply, Colors::Texture);
    let end = b"end_header\n";
    let begin = bytes
        .windows(end.len())
        .position(|window| window == end)
        .unwrap()
        + end.len();
    let header = std::str::from_utf8(&bytes[..begin]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\ncomment myxo "));
    let count = |what: &str| -> usize {
        let line = header
            .lines()
            .find_map(|line| line.strip_prefix(what))
            .unwrap();
        line.trim().parse().unwrap()
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let setup = run.simulation.setup();
    assert_eq!(faces, setup.surface.corners.len());
    const VERTEX: usize = 4 * 6 + 3 + 4 + 4;
    const FACE: usize = 1 + 3 * 4;
    assert_eq!(bytes.len() - begin, vertices * VERTEX + faces * FACE);

    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let integer = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let vector = |at: usize| Vec3::new(float(at), float(at + 4), float(at + 8));
    let poses = run.simulation.world_from_object();
    let export = run.export();
    let paint = export.paint();
    let mut brightest = 0.0_f32;
    for face in 0..faces {
        let at = begin + vertices * VERTEX + face * FACE;
        assert_eq!(bytes[at], 3);
        for k in 0..3 {
            let vertex = begin + VERTEX * integer(at + 1 + 4 * k) as usize;
            let object = setup.surface.triangles[face].object;
            let local = setup.surface.positions[setup.surface.corners[face][k] as usize];
            let world = poses[object as usize].transform_point3(local);
            assert!(vector(vertex).distance(world) < 1e-5);
            assert!(vector(vertex + 12).is_normalized());
            let trail = float(vertex + 27);
            assert_eq!(bytes[vertex + 24..vertex + 27], paint.srgb(trail, 0.0));
            assert_eq!(integer(vertex + 31), object);
            brightest = brightest.max(trail);
        }
    }
    assert!(brightest > 0.0);
    gpu.finish();
}

/// Would catch: a model or a mesh in the colours of the first look where the second one is.
#[test]
fn the_second_look_is_exported_in_its_own_colours() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO[..1], |settings| {
        settings.particles.count = 500;
        settings.atlas.size = 128;
        settings.picture.color_map = ColorMap::Ice;
        "spots".clone_into(&mut settings.second_look.preset);
    });
    let mut run = Run::of(&gpu, scene, 3);
    let files = [
        (Format::Glb, Colors::Texture),
        (Format::Glb, Colors::Vertex),
        (Format::Ply, Colors::Texture),
    ];
    let written = |export: &Export<'_>| {
        files.map(|(format, colors)| {
            let mut out = Cursor::new(Vec::new());
            export.write(format, colors, &mut out).unwrap();
            out.into_inner()
        })
    };
    let nowhere = written(&run.export());
    let in_its_colours = {
        let mut export = run.export();
        export.view.color_map = export.view.second_colors.expect("it has its own");
        written(&export)
    };
    run.snapshot.looks = vec![1.0; run.snapshot.trail.len()];
    let everywhere = written(&run.export());
    for (k, (format, colors)) in files.into_iter().enumerate() {
        let what = format!("{format:?}, {colors:?}");
        assert!(everywhere[k] == in_its_colours[k], "{what}");
        assert!(everywhere[k] != nowhere[k], "{what}");
    }
    gpu.finish();
}

#[test]
fn arrays_hold_the_state() {
    let Some(gpu) = gpu() else { return };
    let run = moving_trio(&gpu);
    let bytes = run.bytes(Format::Npz, Colors::Texture);
    assert_eq!(bytes, run.bytes(Format::Npz, Colors::Texture), "same bits");
    let arrays = Arrays::read(&bytes);
    let (setup, state) = (run.simulation.setup(), &run.snapshot);
    let (surface, atlas) = (&setup.surface, &setup.atlas);
    assert_eq!(arrays.all::<i64>("step", "<i8", &[]), [25]);
    assert_eq!(arrays.all::<i64>("seed", "<i8", &[]), [11]);
    assert_eq!(arrays.all::<i64>("layout_version", "<i8", &[]), [1]);
    assert_eq!(
        arrays.all::<f64>("time", "<f8", &[]),
        [run.simulation.time()]
    );
    assert_eq!(arrays.text("scene_name"), ["test"]);
    assert_eq!(arrays.text("version"), [env!("CARGO_PKG_VERSION")]);
    let commit = myxo::commit().unwrap_or_default();
    assert_eq!(arrays.text("commit"), [commit]);
    let info = gpu.ctx.info();
    assert_eq!(arrays.text("device"), [info.name.as_str()]);
    assert!(arrays.text("driver")[0].ends_with(&info.driver_version));
    let hash = format!("{:016x}", run.snapshot.hash());
    assert_eq!(arrays.text("state_hash"), [hash]);
    let names: Vec<_> = run
        .scene
        .settings
        .objects
        .iter()
        .map(|o| o.name.clone())
        .collect();
    assert_eq!(arrays.text("object_name"), names);
    assert_eq!(arrays.text("scene_toml"), [run.export().scene_file()]);

    let n = state.particles.len();
    let places = arrays.all::<[f32; 3]>("particle_position", "<f4", &[n, 3]);
    let headings = arrays.all::<[f32; 3]>("particle_heading", "<f4", &[n, 3]);
    let triangles = arrays.all::<i32>("particle_triangle", "<i4", &[n]);
    let objects = arrays.all::<i32>("particle_object", "<i4", &[n]);
    let uvs = arrays.all::<[f32; 2]>("particle_uv", "<f4", &[n, 2]);
    let texels = arrays.all::<[f32; 2]>("particle_texel", "<f4", &[n, 2]);
    let pending = arrays.all::<f32>("particle_pending", "<f4", &[n]);
    let poses = run.simulation.world_from_object();
    for (particle, motion) in state.particles.iter().zip(&state.motions) {
        let i = particle.id as usize;
        let t = particle.triangle as usize;
        let object = surface.triangles[t].object;
        assert_eq!((triangles[i], objects[i]), (t as i32, object as i32));
        assert_eq!(
            (uvs[i], pending[i]),
            ([particle.u, particle.v], motion.pending)
        );
        let [a, b, c] = surface.corners[t].map(|v| surface.positions[v as usize]);
        let pose = poses[object as usize];
        let place = pose.transform_point3(a + particle.u * (b - a) + particle.v * (c - a));
        assert!(place.distance(Vec3::from(places[i])) < 1e-5);
        // The heading: along the edge AB by p, at right angles by h.
        let p = (b - a).normalize();
        let h = ((c - a) - (c - a).dot(p) * p).normalize();
        let heading = pose.transform_vector3(motion.heading_p * p + motion.heading_h * h);
        assert!(
            heading.distance(Vec3::from(headings[i])) < 1e-3,
            "particle {i}"
        );
        let texel = atlas.position_of(particle.triangle, particle.u, particle.v);
        assert_eq!(texel, Vec2::from(texels[i]));
    }
    // Ids must differ from slots, otherwise the test could not see that rows are sorted.
    assert!(
        state
            .particles
            .iter()
            .enumerate()
            .any(|(slot, p)| slot as u32 != p.id)
    );

    let side = atlas.size as usize;
    let shape = [side, side];
    let trail = arrays.all::<f32>("trail", "<f4", &shape);
    let deposit = arrays.all::<u32>("deposit", "<u4", &shape);
    let density = arrays.all::<f32>("density", "<f4", &shape);
    let area = arrays.all::<f32>("texel_area", "<f4", &shape);
    let owner = arrays.all::<i32>("texel_triangle", "<i4", &shape);
    let texel_object = arrays.all::<i32>("texel_object", "<i4", &shape);
    let chart = arrays.all::<i32>("texel_chart", "<i4", &shape);
    let place = arrays.all::<[f32; 3]>("texel_position", "<f4", &[side, side, 3]);
    let distance = arrays.all::<f32>("distance", "<f4", &shape);
    let nearest = arrays.all::<i32>("nearest_triangle", "<i4", &shape);
    let distances = run
        .simulation
        .distances()
        .unwrap()
        .expect("there are several objects");
    let mut near = 0;
    for i in 0..side * side {
        let texel = i / side * atlas.pitch as usize + i % side;
        assert_eq!(
            (trail[i], deposit[i]),
            (state.trail[texel], state.deposits[texel])
        );
        assert_eq!(
            (density[i], area[i]),
            (atlas.density[texel], atlas.area[texel])
        );
        let Some((t, u, v)) = atlas.surface_point_of(texel as u32) else {
            assert_eq!([owner[i], texel_object[i], chart[i], nearest[i]], [-1; 4]);
            assert!(distance[i].is_nan() && place[i].iter().all(|x| x.is_nan()));
            continue;
        };
        let object = surface.triangles[t as usize].object;
        let expected = [t, object, atlas.chart[t as usize]].map(|x| x as i32);
        assert_eq!([owner[i], texel_object[i], chart[i]], expected);
        let [a, b, c] = surface.corners[t as usize].map(|v| surface.positions[v as usize]);
        let world = poses[object as usize].transform_point3(a + u * (b - a) + v * (c - a));
        assert!(world.distance(Vec3::from(place[i])) < 1e-5);
        assert_eq!(distance[i], distances.signed[texel]);
        match distances.nearest[texel] {
            NONE => assert_eq!(nearest[i], -1),
            triangle => {
                near += 1;
                assert_eq!(nearest[i], triangle as i32);
                assert_ne!(surface.triangles[triangle as usize].object, object);
            }
        }
    }
    assert!(near > 100, "{near} texels are near another object");

    let (v, t) = (surface.positions.len(), surface.corners.len());
    let vertices = arrays.all::<[f32; 3]>("vertex_position", "<f4", &[v, 3]);
    assert!(
        vertices
            .iter()
            .zip(&surface.positions)
            .all(|(a, b)| Vec3::from(*a) == *b)
    );
    let corners = arrays.all::<[i32; 3]>("triangle_vertices", "<i4", &[t, 3]);
    assert!(
        corners
            .iter()
            .zip(&surface.corners)
            .all(|(a, b)| a.map(|v| v as u32) == *b)
    );
    let matrices = arrays.all::<[f64; 16]>("world_from_object", "<f8", &[3, 4, 4]);
    for (rows, pose) in matrices.iter().zip(&poses) {
        let point = DVec3::new(0.3, -0.2, 0.5);
        let row = |r: usize| DVec3::from_slice(&rows[4 * r..]).dot(point) + rows[4 * r + 3];
        let expected = pose.transform_point3(point.as_vec3()).as_dvec3();
        assert!(DVec3::new(row(0), row(1), row(2)).distance(expected) < 1e-6);
    }
    gpu.finish();
}

#[test]
fn a_scene_without_steps_is_exported_too() {
    let Some(gpu) = gpu() else { return };
    let run = Run::of(&gpu, moving_scene_of_two(), 0);
    let arrays = Arrays::read(&run.bytes(Format::Npz, Colors::Texture));
    assert!(
        !arrays.names().contains(&"distance".to_owned()),
        "none were taken"
    );
    let trail = arrays.all::<f32>("trail", "<f4", &[128, 128]);
    assert!(trail.iter().all(|&trail| trail == 0.0));
    for format in [Format::Ply, Format::Toml] {
        assert!(run.bytes(format, Colors::Texture).len() > 500);
    }
    let (model, binary) = parts(&run.bytes(Format::Glb, Colors::Texture));
    let texture = texture_of(&model, &binary, false);
    let first = texture.get_pixel(0, 0);
    assert!(
        texture.pixels().all(|pixel| pixel == first),
        "bare everywhere"
    );
    gpu.finish();
}

/// Would catch: rows of dead particles, and columns whose rows are of different particles.
#[test]
fn dead_particles_have_no_rows() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO[..1], |settings| {
        settings.particles.count = 500;
        settings.atlas.size = 128;
        settings.feeding.scattered = 3;
        settings.population.frequency = 2;
        settings.population.capacity = 3000;
    });
    let run = Run::of(&gpu, scene, 12);
    let arrays = Arrays::read(&run.bytes(Format::Npz, Colors::Texture));
    let state = &run.snapshot;
    let n = state.living_count() as usize;
    assert!(n > 500 && n < 3000, "{n}");
    let ids = arrays.all::<i32>("particle_id", "<i4", &[n]);
    assert!(ids.windows(2).all(|pair| pair[0] < pair[1]));
    let triangles = arrays.all::<i32>("particle_triangle", "<i4", &[n]);
    let fed = arrays.all::<i32>("particle_fed", "<i4", &[n]);
    for (particle, motion) in state.particles.iter().zip(&state.motions) {
        let row = ids.binary_search(&(particle.id as i32));
        assert_eq!(row.is_err(), motion.is_dead());
        if let Ok(row) = row {
            let expected = (particle.triangle as i32, motion.fed() as i32);
            assert_eq!((triangles[row], fed[row]), expected);
        }
    }
    gpu.finish();
}

/// Painted areas and fed particles are exported as the state has them.
#[test]
fn areas_and_meals_are_in_the_arrays() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO[..1], |settings| {
        settings.particles.count = 2000;
        settings.atlas.size = 128;
        settings.feeding.scattered = 3;
        settings.feeding.size = 0.4;
        settings.areas.map = "builtin:maze".to_owned();
    });
    let run = Run::of(&gpu, scene, 12);
    let arrays = Arrays::read(&run.bytes(Format::Npz, Colors::Texture));
    let state = &run.snapshot;
    let fed = arrays.all::<i32>("particle_fed", "<i4", &[2000]);
    for (particle, motion) in state.particles.iter().zip(&state.motions) {
        assert_eq!(fed[particle.id as usize], motion.fed() as i32);
    }
    assert!(fed.iter().any(|&steps| steps > 0) && fed.contains(&0));
    let atlas = &run.simulation.setup().atlas;
    let side = atlas.size as usize;
    let bias = arrays.all::<f32>("area_bias", "<f4", &[side, side]);
    let no_go = arrays.all::<u8>("area_no_go", "|b1", &[side, side]);
    for (i, (bias, no_go)) in bias.into_iter().zip(&no_go).enumerate() {
        let kept = state.bias[i / side * atlas.pitch as usize + i % side];
        assert_eq!(*no_go == 1, kept < NO_GO_BELOW, "{kept}");
        assert_eq!(bias, if *no_go == 1 { 0.0 } else { kept });
    }
    assert!(no_go.contains(&1) && no_go.contains(&0));
    gpu.finish();
}

/// A map does not replace a picture of the same name, unless the replaced scene names that picture as its map.
#[test]
fn maps_of_areas_replace_no_other_picture() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO[..1], |settings| {
        settings.particles.count = 100;
        settings.atlas.size = 128;
        settings.areas.map = "builtin:maze".to_owned();
    });
    let run = Run::of(&gpu, scene, 1);
    let folder = tempfile::tempdir().unwrap();
    let [file, other, own] =
        ["x.toml", "x_areas.png", "x_areas_2.png"].map(|name| folder.path().join(name));
    std::fs::write(&other, "mine").unwrap();
    for _ in 0..2 {
        let export = ExportFile::create(&file).unwrap();
        let written = export.write(&run.export(), Colors::Texture).unwrap();
        assert_eq!(written.files, [file.clone(), own.clone()]);
        assert_eq!(std::fs::read(&other).unwrap(), b"mine");
        let again = Scene::load(&file, &Overrides::default()).unwrap();
        assert_eq!(Path::new(&again.settings.areas.map), own);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }
    // If no map can be written, the scene file is not written either.
    std::fs::remove_file(&own).unwrap();
    std::fs::create_dir(&own).unwrap();
    std::fs::write(&file, "map = \"x_areas_2.png\"\n").unwrap();
    let export = ExportFile::create(&file).unwrap();
    assert!(export.write(&run.export(), Colors::Texture).is_err());
    let before = std::fs::read_to_string(&file).unwrap();
    assert_eq!(before, "map = \"x_areas_2.png\"\n");
    gpu.finish();
}

fn moving_scene_of_two() -> Scene {
    scene_of_several(&TRIO[..2], |settings| {
        settings.particles.count = 300;
        settings.atlas.size = 128;
        settings.objects[1].motion.swing = [0.0, 0.0, 40.0];
    })
}

/// Two equal scenes, one of them far away, by the coordinates in a mesh's file and by the position of an object.
fn alike(by: DVec3) -> Scene {
    let ball = Mesh::builtin("builtin:icosphere?subdivisions=2").unwrap();
    let file = tempfile::Builder::new().suffix(".obj").tempfile().unwrap();
    let mut text = String::new();
    for position in &ball.positions {
        let [x, y, z] = (position.as_dvec3() + by).to_array();
        text += &format!("v {x} {y} {z}\n");
    }
    for corners in &ball.corners {
        let [a, b, c] = corners.map(|corner| corner + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    std::fs::write(file.path(), text).unwrap();
    let mut settings = moving_scene_of_two().settings;
    settings.objects[0] = ObjectSettings {
        name: "ball".to_owned(),
        mesh: file.path().to_str().unwrap().to_owned(),
        ..ObjectSettings::default()
    };
    settings.objects[1].position = (by + DVec3::new(1.25, 0.5, 0.0)).to_array();
    settings.foods.push(FoodSettings {
        object: "ball".to_owned(),
        at: (by + DVec3::Y).to_array(),
        ..FoodSettings::default()
    });
    Scene::from_settings("alike".to_owned(), settings, ".".into()).unwrap()
}

/// Exports have the scene's coordinates, in double precision where single is too coarse. Would catch: an
/// export that writes places as the device has them, counted from the scene's origin.
#[test]
fn exports_have_the_coordinates_of_a_scene_far_away() {
    let Some(gpu) = gpu() else { return };
    let far = DVec3::new(512_512.0, -1024.0, 5_412_352.0);
    let [near, afar] = [DVec3::ZERO, far].map(|by| Run::of(&gpu, alike(by), 12));
    assert_eq!(near.snapshot.hash(), afar.snapshot.hash());
    let [arrays, arrays_afar] =
        [&near, &afar].map(|run| Arrays::read(&run.bytes(Format::Npz, Colors::Texture)));

    let n = near.snapshot.particles.len();
    let foods = 1;
    for (name, count) in [("particle_position", n), ("food_position", foods)] {
        let places = arrays.all::<[f32; 3]>(name, "<f4", &[count, 3]);
        let places_afar = arrays_afar.all::<[f64; 3]>(name, "<f8", &[count, 3]);
        for (place, place_afar) in places.iter().zip(&places_afar) {
            let expected = Vec3::from(*place).as_dvec3() + far;
            assert_eq!(DVec3::from(*place_afar), expected, "{name}");
        }
    }
    let v = near.simulation.setup().surface.positions.len();
    let vertices = arrays_afar.all::<[f64; 3]>("vertex_position", "<f8", &[v, 3]);
    let objects = arrays_afar.all::<i32>("vertex_object", "<i4", &[v]);
    let poses = arrays_afar.all::<[[f64; 4]; 4]>("world_from_object", "<f8", &[2, 4, 4]);
    let near_poses = near.simulation.world_from_object();
    for (i, (vertex, object)) in vertices.iter().zip(objects).enumerate() {
        let local = near.simulation.setup().surface.positions[i];
        let expected = near_poses[object as usize]
            .transform_point3(local)
            .as_dvec3()
            + far;
        let pose = DMat4::from_cols_array_2d(&poses[object as usize]).transpose();
        let found = pose.transform_point3(DVec3::from(*vertex));
        assert!(found.distance(expected) < 1e-6, "{found}, not {expected}");
    }

    let nodes_of = |run: &Run| -> Vec<DVec3> {
        let bytes = run.bytes(Format::Glb, Colors::Vertex);
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        let nodes = json["nodes"].as_array().unwrap().iter();
        let number = |node: &serde_json::Value, k: usize| node["translation"][k].as_f64().unwrap();
        nodes
            .map(|node| DVec3::from([0, 1, 2].map(|k| number(node, k))))
            .collect()
    };
    // Two objects and the camera; the ball's coordinates are counted from its middle.
    let (nodes, nodes_afar) = (nodes_of(&near), nodes_of(&afar));
    assert_eq!(nodes.len(), 3);
    for (node, node_afar) in nodes.iter().zip(&nodes_afar) {
        let expected = *node + far;
        assert!(
            node_afar.distance(expected) < 1e-6,
            "{node_afar}, not {expected}"
        );
    }

    let ply = afar.bytes(Format::Ply, Colors::Vertex);
    let begin = ply
        .windows(11)
        .position(|word| word == b"end_header\n")
        .unwrap()
        + 11;
    assert!(
        ply[..begin]
            .windows(17)
            .any(|line| line == b"property double x")
    );
    let near_ply = near.bytes(Format::Ply, Colors::Vertex);
    let near_begin = near_ply
        .windows(11)
        .position(|word| word == b"end_header\n")
        .unwrap()
        + 11;
    // Three numbers of 8 or 4 bytes, and 23 bytes of other values.
    let rows = ply[begin..]
        .chunks(47)
        .zip(near_ply[near_begin..].chunks(35));
    let vertices = near.simulation.setup().surface.positions.len();
    for (row, near_row) in rows.take(vertices) {
        for (k, far) in far.to_array().into_iter().enumerate() {
            let x = f64::from_le_bytes(row[8 * k..8 * k + 8].try_into().unwrap());
            let near = f32::from_le_bytes(near_row[4 * k..4 * k + 4].try_into().unwrap());
            assert!(
                (x - far - f64::from(near)).abs() < 1e-6,
                "{x}, not {near} from {far}"
            );
        }
    }

    let text = afar.export().scene_file();
    assert!(text.contains("512513.25"), "where an object stands: {text}");
    gpu.finish();
}

/// A scene file of the state begins with the present poses of the objects, and their motion continues.
#[test]
fn a_scene_file_continues_from_the_present_poses() {
    let Some(gpu) = gpu() else { return };
    let mut run = Run::of(&gpu, moving_scene_of_two(), 37);
    let outside = DAffine3::from_rotation_translation(
        DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.1),
        DVec3::new(0.5, 0.25, -2.0),
    );
    run.simulation.set_pose(0, Some(outside)).unwrap();
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(file.path(), run.export().scene_file()).unwrap();
    let again = Scene::load(file.path(), &Overrides::default()).unwrap();
    assert_eq!(again.radius, run.scene.radius);
    for (expected, found) in run
        .simulation
        .world_from_object()
        .iter()
        .zip(again.world_from_object())
    {
        assert!(
            found.abs_diff_eq(*expected, 1e-4),
            "{found:?}, not {expected:?}"
        );
    }
    // 20 steps later, too.
    let now = run.simulation.time();
    let later = now + 20.0 * f64::from(run.scene.settings.time.dt);
    let expected = run.scene.world_from_object_at(later)[1];
    let went_on = Run::of(&gpu, again, 21);
    let found = went_on.simulation.world_from_object()[1];
    assert!(
        found.abs_diff_eq(expected, 1e-4),
        "{found:?}, not {expected:?}"
    );
    gpu.finish();
}

/// Would catch: a scene file with a time in single precision, with which objects jump after a long run, and one that cannot be read, for
/// its late time or for the name of its scene.
#[test]
fn a_scene_file_of_a_late_state_begins_at_its_time() {
    let Some(gpu) = gpu() else { return };
    let mut scene = moving_scene_of_two();
    scene.settings.time.start = 10_000_000.0;
    scene.name = "two\r\u{1b}[2J\nlines".to_owned();
    let run = Run::of(&gpu, scene, 2);
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(file.path(), run.export().scene_file()).unwrap();
    let again = Scene::load(file.path(), &Overrides::default()).unwrap();
    let time = run.simulation.time();
    assert!(time > 10_000_000.01, "{time}");
    assert_eq!(again.settings.time.start, time);
    gpu.finish();
}

#[test]
fn a_state_that_was_lost_on_its_way_is_not_waited_for() {
    let Some(gpu) = gpu() else { return };
    let run = Run::of(&gpu, moving_scene_of_two(), 1);
    let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let coming = ExportOnTheWay::record(&run.scene, &run.simulation, &mut rec).unwrap();
    frames.submit(rec).unwrap();
    gpu.ctx.pretend_lost();
    let error = coming.wait(&Watch::default()).err().expect("it is lost");
    assert!(error.to_string().contains("was lost before"), "{error}");
}

/// Would catch: a window that hangs when it closes, because a frame has failed after an export was recorded in it.
#[test]
fn a_state_whose_recording_was_dropped_is_not_waited_for() {
    let Some(gpu) = gpu() else { return };
    let run = Run::of(&gpu, moving_scene_of_two(), 1);
    let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let coming = ExportOnTheWay::record(&run.scene, &run.simulation, &mut rec).unwrap();
    drop(rec);
    let error = coming.wait(&Watch::default()).err();
    let error = error.expect("nothing was copied").to_string();
    assert!(error.contains("was dropped"), "{error}");
    gpu.finish();
}

#[test]
fn endings_say_what_a_file_is() {
    for (name, format) in [
        ("x.glb", Some(Format::Glb)),
        ("a b/X.PLY", Some(Format::Ply)),
        (".x.npz", Some(Format::Npz)),
        ("x.toml", Some(Format::Toml)),
        ("x.gltf", None),
        ("x", None),
        ("glb", None),
        (".glb", None),
    ] {
        assert_eq!(Format::of(Path::new(name)), format, "{name}");
    }
}
