//! Areas that attract, repel or may not be entered, as a picture of the whole texture: the areas of a scene at its start, and the form in
//! which painted areas are saved.
//!
//! | colour | value |
//! | --- | --- |
//! | green, 0 to full | 0 to `strength` trail units are added to sensor readings |
//! | blue, 0 to full | as much is subtracted |
//! | red, by more than half beyond green and blue | particles do not enter ([`NO_GO`]) |
//! | black, white, grey, transparent | nothing |

use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};

use super::texture_map;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::NONE;
use crate::plain_text::Shown as _;
use crate::scene::BUILTIN;
use crate::scene::builtin::MAPS;
use crate::scene::settings::AreaSettings;
use crate::whole_file::write_whole;

/// The bias of texels that no particle may enter.
pub const NO_GO: f32 = -1e9;
/// Below this a bias is that of a no-go area; gutters may mix it with others. `shaders/include/no_go.glsl` has the same.
pub const NO_GO_BELOW: f32 = 0.5 * NO_GO;
/// Upper bound on trail and bias. The negative of it is the lower bound on bias outside of no-go areas.
pub const GREATEST: f32 = 1e6;

/// Its name in messages.
const WHAT: &str = "area map";

/// All of a colour.
const FULL: f32 = u16::MAX as f32;

/// A picture of areas.
#[derive(Clone, Debug)]
pub struct AreaMap {
    path: PathBuf,
    pixels: ImageBuffer<Rgba<u16>, Vec<u16>>,
}

impl AreaMap {
    /// Reads a PNG: a file, or `builtin:NAME` for one that comes with the program.
    ///
    /// # Errors
    /// When there is no such file or name, it is no picture, or it has more pixels than maps for an atlas of this size may have.
    pub fn open(path: &Path, atlas_size: u32) -> Result<Self> {
        let name = path.to_str().and_then(|path| path.strip_prefix(BUILTIN));
        let picture = match name {
            Some(name) => texture_map::decode(path, WHAT, builtin(name)?, atlas_size),
            None => texture_map::read(path, WHAT, atlas_size),
        }?;
        Ok(Self::of(path, picture))
    }

    /// As [`open`](Self::open), for a PNG in memory; `path` is its name in messages.
    ///
    /// # Errors
    /// When it is no picture, or it has more pixels than maps for an atlas of this size may have.
    pub fn from_bytes(path: &Path, bytes: &[u8], atlas_size: u32) -> Result<Self> {
        let picture = texture_map::decode(path, WHAT, bytes, atlas_size)?;
        Ok(Self::of(path, picture))
    }

    fn of(path: &Path, picture: DynamicImage) -> Self {
        Self {
            path: path.to_owned(),
            pixels: picture.into_rgba16(),
        }
    }

    /// The bias, one value per texel, gutters filled. An owned texel has the value of the pixel at its centre.
    ///
    /// # Errors
    /// When the picture has no areas.
    pub fn bias(&self, atlas: &Atlas, strength: f32) -> Result<Vec<f32>> {
        let mut says_something = false;
        let bias = texture_map::field_of(atlas, self.pixels.dimensions(), |x, y| {
            let pixel = *self.pixels.get_pixel(x, y);
            says_something |= value(pixel, 1.0) != 0.0;
            value(pixel, strength)
        });
        if !says_something {
            return Err(Error::Invalid(format!(
                "{}: the area map says nothing wherever the texture holds a triangle: paint green, blue or red on black, where \
                 `myxo atlas SCENE --out FILE.png` draws what you mean",
                self.path.shown()
            )));
        }
        Ok(bias)
    }
}

/// The map of this name that comes with the program.
fn builtin(name: &str) -> Result<&'static [u8]> {
    let found = MAPS.iter().find(|(known, _)| *known == name);
    found.map(|(_, bytes)| *bytes).ok_or_else(|| {
        let known: Vec<&str> = MAPS.iter().map(|(known, _)| *known).collect();
        Error::Invalid(format!(
            "areas.map: there is no built-in map \"{name}\"; there is {}",
            known.join(", ")
        ))
    })
}

/// Texels that triangles own.
fn owned(atlas: &Atlas) -> impl Iterator<Item = u32> {
    let owners = (0u32..).zip(&atlas.owner);
    let owned = owners.filter(|(_, owner)| **owner != NONE);
    owned.map(|(texel, _)| texel)
}

fn value(Rgba([red, green, blue, alpha]): Rgba<u16>, strength: f32) -> f32 {
    let seen = f32::from(alpha) / FULL;
    let [red, green, blue] = [red, green, blue].map(|part| seen * f32::from(part) / FULL);
    if red - green.max(blue) > 0.5 {
        return NO_GO;
    }
    strength * (green - blue)
}

/// 16 bits a colour.
pub type AreaPicture = ImageBuffer<Rgb<u16>, Vec<u16>>;

/// A picture of areas, and the strength of a full colour in it; none if there are no visible areas.
#[must_use]
pub fn picture_of(bias: &[f32], atlas: &Atlas) -> Option<(AreaPicture, f32)> {
    let values = || owned(atlas).filter_map(|texel| bias.get(texel as usize).copied());
    if values().all(|value| value == 0.0) {
        return None;
    }
    let painted = values().filter(|value| *value >= -GREATEST);
    let strength = painted.map(f32::abs).fold(0.0, f32::max).min(GREATEST);
    let mut pixels = ImageBuffer::new(atlas.size, atlas.size);
    for texel in owned(atlas) {
        let value = bias[texel as usize];
        let part = |value: f32| (FULL * (value / strength).clamp(0.0, 1.0)).round() as u16;
        let color = if value < NO_GO_BELOW {
            [u16::MAX, 0, 0]
        } else {
            [0, part(value), part(-value)]
        };
        pixels.put_pixel(texel % atlas.pitch, texel / atlas.pitch, Rgb(color));
    }
    // With no-go areas alone, the strength has no effect.
    let usual = AreaSettings::default().strength;
    Some((pixels, if strength > 0.0 { strength } else { usual }))
}

/// Writes areas as a PNG that [`AreaMap`] reads, and returns the strength for it. If there are no visible areas, writes nothing and returns
/// none.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, bias: &[f32], atlas: &Atlas) -> Result<Option<f32>> {
    let Some((pixels, strength)) = picture_of(bias, atlas) else {
        return Ok(None);
    };
    write_picture(path, &pixels)?;
    Ok(Some(strength))
}

fn write_picture(path: &Path, pixels: &AreaPicture) -> Result<()> {
    write_png(path, |file| pixels.write_to(file, ImageFormat::Png))
}

/// The map of areas that belongs to a scene file: `NAME_areas.png` beside it.
#[must_use]
pub fn map_beside(scene_file: &Path) -> PathBuf {
    let mut name = scene_file.file_stem().unwrap_or_default().to_owned();
    name.push("_areas.png");
    scene_file.with_file_name(name)
}

/// The map of areas for a scene file: `NAME_areas.png` beside it or, if that is another scene's file, with the next free number.
#[must_use]
pub fn map_for(scene_file: &Path) -> PathBuf {
    let first = map_beside(scene_file);
    let before = std::fs::read_to_string(scene_file).unwrap_or_default();
    let is_ours = |map: &PathBuf| {
        let name = map.file_name().unwrap_or_default().to_string_lossy();
        !map.exists() || before.contains(&format!("\"{name}\""))
    };
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    let others = (2..).map(|number| first.with_file_name(format!("{stem}_{number}.png")));
    let mut maps = std::iter::once(first.clone()).chain(others);
    maps.find(is_ours).unwrap_or(first.clone())
}

/// The name by which a scene file has the map beside it.
///
/// # Errors
/// When it is not Unicode: text, as scene files are, would name another file.
pub fn name_beside(map: &Path) -> Result<String> {
    let name = map.file_name().unwrap_or_default();
    name.to_str().map(str::to_owned).ok_or_else(|| {
        Error::Invalid(format!(
            "{}: the map of the scene's areas is named after the scene file, which cannot say this name, because it is not Unicode: choose \
             another name for the scene",
            map.shown()
        ))
    })
}

/// The area settings for a scene file of this path. The present areas are written [beside it](map_for), so that both stay
/// together. Returns that file, too, if there is one.
///
/// # Errors
/// When it cannot be written, or its name [is not Unicode](name_beside).
pub fn keep_beside(
    scene_file: &Path,
    bias: &[f32],
    atlas: &Atlas,
) -> Result<(AreaSettings, Option<PathBuf>)> {
    let Some((pixels, strength)) = picture_of(bias, atlas) else {
        return Ok((AreaSettings::default(), None));
    };
    let path = map_for(scene_file);
    let map = name_beside(&path)?;
    write_picture(&path, &pixels)?;
    Ok((AreaSettings { map, strength }, Some(path)))
}

/// Writes attracting areas as a mask for [starts](super::start::Mask), and returns their texels. Texels with at least the median strength
/// are white, weaker ones are proportionally darker. None if nothing attracts.
///
/// # Errors
/// When the file cannot be written.
pub fn write_mask(path: &Path, bias: &[f32], atlas: &Atlas) -> Result<Option<Vec<u32>>> {
    let value = |texel: u32| bias.get(texel as usize).copied().unwrap_or(0.0);
    let texels: Vec<u32> = owned(atlas).filter(|texel| value(*texel) > 0.0).collect();
    if texels.is_empty() {
        return Ok(None);
    }
    let mut values: Vec<f32> = texels.iter().map(|texel| value(*texel)).collect();
    let middle = values.len() / 2;
    let (_, white, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    let white = *white;
    let mut pixels = GrayImage::new(atlas.size, atlas.size);
    for &texel in &texels {
        // At least 1, so that weak attraction is kept.
        let light = (255.0 * value(texel) / white).round().clamp(1.0, 255.0) as u8;
        pixels.put_pixel(texel % atlas.pitch, texel / atlas.pitch, Luma([light]));
    }
    write_png(path, |file| pixels.write_to(file, ImageFormat::Png))?;
    Ok(Some(texels))
}

fn write_png(
    path: &Path,
    write: impl FnOnce(&mut std::io::Cursor<Vec<u8>>) -> image::ImageResult<()>,
) -> Result<()> {
    let io = Error::io("write", path);
    let mut bytes = std::io::Cursor::new(Vec::new());
    write(&mut bytes).map_err(|error| io(std::io::Error::other(error)))?;
    write_whole(path, bytes.get_ref()).map_err(io)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::settings::Settings;
    use crate::sim::Setup;
    use crate::sim::field::fill_gutters;

    fn atlas() -> Atlas {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 61;
        "builtin:cube".clone_into(&mut settings.objects[0].mesh);
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        Setup::new(&scene).unwrap().atlas.clone()
    }

    fn painted(atlas: &Atlas) -> Vec<f32> {
        let mut bias = vec![0.0; atlas.owner.len()];
        for (k, texel) in owned(atlas).enumerate() {
            bias[texel as usize] = [0.0, 3.0, -40.0, NO_GO, 80.0][k % 5];
        }
        fill_gutters(&atlas.seams, &mut bias);
        bias
    }

    #[test]
    fn what_is_written_is_read() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let path = folder.path().join("areas.png");
        let bias = painted(&atlas);
        let strength = write(&path, &bias, &atlas).unwrap().unwrap();
        assert_eq!(strength, 80.0);
        let again = AreaMap::open(&path, 61).unwrap().bias(&atlas, strength);
        for (texel, (was, is)) in bias.iter().zip(again.unwrap()).enumerate() {
            // Gutters may mix no-go areas with others.
            let near = 2e-5 * was.abs().max(strength);
            assert!((was - is).abs() <= near, "{was} became {is} at {texel}");
        }
        // With twice the strength.
        let twice = AreaMap::open(&path, 61)
            .unwrap()
            .bias(&atlas, 160.0)
            .unwrap();
        let texel = owned(&atlas).nth(4).unwrap();
        assert_eq!(twice[texel as usize], 160.0);
    }

    #[test]
    fn only_what_may_not_be_entered_has_a_strength_as_well() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let path = folder.path().join("walls.png");
        let mut bias = vec![0.0; atlas.owner.len()];
        assert_eq!(write(&path, &bias, &atlas).unwrap(), None);
        assert!(!path.exists(), "there is nothing to be written");
        let wall = owned(&atlas).nth(7).unwrap();
        bias[wall as usize] = NO_GO;
        let usual = AreaSettings::default().strength;
        assert_eq!(write(&path, &bias, &atlas).unwrap(), Some(usual));
        let again = AreaMap::open(&path, 61)
            .unwrap()
            .bias(&atlas, usual)
            .unwrap();
        assert!(owned(&atlas).all(|texel| again[texel as usize] == bias[texel as usize]));
    }

    /// Would catch: a scene file that names another map than the one beside it, and a map that is written for nothing.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_map_whose_name_no_scene_file_can_have_is_refused() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;

        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let file = folder.path().join(OsStr::from_bytes(b"\xff.toml"));
        let problem = keep_beside(&file, &painted(&atlas), &atlas).unwrap_err();
        let problem = problem.to_string();
        assert!(
            problem.contains("is not Unicode: choose another"),
            "{problem}"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        // Without areas there is no map.
        let bare = vec![0.0; atlas.owner.len()];
        let (settings, map) = keep_beside(&file, &bare, &atlas).unwrap();
        assert_eq!((settings, map), (AreaSettings::default(), None));
    }

    #[test]
    fn colours_say_what_they_are() {
        let full = u16::MAX;
        for ([red, green, blue, alpha], wanted) in [
            ([0, 0, 0, full], 0.0),
            ([full, full, full, 0], 0.0),
            ([0, full, 0, full], 10.0),
            ([0, 0, full, full], -10.0),
            // Violet, as repulsion is drawn.
            ([full, 0, full, full], -10.0),
            ([full, 0, 0, full], NO_GO),
            ([full / 3, 0, 0, full], 0.0),
            ([full, 0, 0, full / 3], 0.0),
            ([full, full, full, full], 0.0),
            ([full, full - 99, full - 99, full], 0.0),
        ] {
            assert_eq!(value(Rgba([red, green, blue, alpha]), 10.0), wanted);
        }
    }

    /// The layout of the atlas may be the lowest layer of a map: its colours make no walls.
    #[test]
    fn the_colours_of_a_layout_are_no_walls() {
        for [red, green, blue] in [
            [176, 119, 87],
            [219, 149, 149],
            [199, 165, 108],
            [173, 113, 141],
            [244, 242, 235],
            [255, 196, 84],
        ] {
            let color = [red, green, blue].map(|part: u16| part * 257);
            let [red, green, blue] = color;
            assert!(value(Rgba([red, green, blue, u16::MAX]), 1.0) > NO_GO_BELOW);
        }
    }

    #[test]
    fn without_strength_walls_are_left() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let path = folder.path().join("areas.png");
        write(&path, &painted(&atlas), &atlas).unwrap();
        let bias = AreaMap::open(&path, 61).unwrap().bias(&atlas, 0.0).unwrap();
        let owned = || owned(&atlas).map(|texel| bias[texel as usize]);
        assert!(owned().all(|value| value == 0.0 || value == NO_GO));
        assert!(owned().any(|value| value == NO_GO));
    }

    #[test]
    fn maps_of_another_size_are_read_at_the_centres_of_texels() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let path = folder.path().join("half.png");
        let left = ImageBuffer::from_fn(2, 1, |x, _| Rgb([0u8, 255 * (1 - x as u8), 0]));
        left.save(&path).unwrap();
        let bias = AreaMap::open(&path, 61).unwrap().bias(&atlas, 5.0).unwrap();
        for texel in owned(&atlas) {
            let is_left = 2 * (texel % atlas.pitch) + 1 < atlas.size;
            assert_eq!(bias[texel as usize], if is_left { 5.0 } else { 0.0 });
        }
    }

    #[test]
    fn masks_are_white_where_it_attracts_as_usual() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let path = folder.path().join("mask.png");
        let mut bias = vec![0.0; atlas.owner.len()];
        assert_eq!(write_mask(&path, &bias, &atlas).unwrap(), None);
        let some: Vec<u32> = owned(&atlas).take(6).collect();
        for (&texel, value) in some.iter().zip([2.0, -5.0, 4.0, NO_GO, 4.0, 900.0]) {
            bias[texel as usize] = value;
        }
        let taken = write_mask(&path, &bias, &atlas).unwrap().unwrap();
        assert_eq!(taken, [some[0], some[2], some[4], some[5]]);
        let mask = image::open(&path).unwrap().into_luma8();
        let light = |texel: u32| mask.get_pixel(texel % atlas.pitch, texel / atlas.pitch).0[0];
        let lights: Vec<u8> = some.iter().map(|texel| light(*texel)).collect();
        assert_eq!(lights, [128, 0, 255, 0, 255, 255]);
    }

    #[test]
    fn what_is_wrong_with_a_map_is_said() {
        let (atlas, folder) = (atlas(), tempfile::tempdir().unwrap());
        let said = |name: &str| {
            let map = AreaMap::open(&folder.path().join(name), 61);
            let said = map.and_then(|map| map.bias(&atlas, 1.0)).unwrap_err();
            said.to_string()
        };
        assert!(said("none.png").contains("none.png"));
        let builtin = AreaMap::open(Path::new("builtin:maize"), 61).unwrap_err();
        assert!(builtin.to_string().contains("there is maze"), "{builtin}");
        std::fs::write(folder.path().join("text.png"), "green").unwrap();
        assert!(said("text.png").contains("text.png: the area map must be a PNG"));
        GrayImage::new(4, 4)
            .save(folder.path().join("black.png"))
            .unwrap();
        let text = said("black.png");
        assert!(
            text.contains("black.png: the area map says nothing"),
            "{text}"
        );
    }
}
