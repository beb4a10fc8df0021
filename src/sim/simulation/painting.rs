//! Brushes on the running simulation: dabs are recorded between steps; and areas can be restored.

use std::ops::Range;

use glam::UVec2;

use super::super::kept::copy_on_device;
use super::super::kernels::{
    ExchangeSeamsArgs, ExchangeSeamsParams, PaintArgs, PaintParams, TeleportArgs,
};
use super::super::paint::{
    Brush, Dab, DabTexel, GREATEST, MOST_TEXELS, NO_GO, NO_GO_BELOW, Painted, PaintedField, Places,
    Repainted,
};
use super::super::plan::Means;
use super::super::state::{bias_of, looks_of, unlooked, unpainted};
use super::super::texture::Texture;
use super::super::types::Particle;
use super::painter::Painter;
use super::{Simulation, pipelines_of, tables_of};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Domain, Recorder, Threads};

/// The painted areas at an earlier time; empty at first.
#[derive(Default)]
pub struct Areas {
    /// None if nothing had been painted.
    bias: Option<Buffer<f32>>,
    /// As `bias`.
    looks: Option<Buffer<f32>>,
}

impl Areas {
    /// Had nothing been painted?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bias.is_none() && self.looks.is_none()
    }
}

/// Texels that are compared at once.
const COMPARED_AT_ONCE: u32 = 1 << 22;

impl Simulation {
    /// Records one dab of a brush, which is painted before the next recorded step, at the objects' present poses in pictures. Reads
    /// nothing back and does not wait; only the first dab makes its kernels. The first one that attracts, repels or forbids makes the
    /// kernels of steps again, as does the first one that brings particles where there is to be one a cell. Returns the number of painted
    /// texels, which may be zero.
    ///
    /// The trail that a dab adds spreads and decays like any other. Areas that attract, repel, forbid or have the second look stay, and are
    /// part of snapshots, checkpoints and hashes from then on; scene files have them in a [map](super::super::areas) beside them.
    ///
    /// ```no_run
    /// # use myxo::sim::paint::{Brush, Dab};
    /// # fn paint(simulation: &mut myxo::sim::Simulation, rec: &mut myxo::gpu::Recorder) -> myxo::Result<()> {
    /// let radius = simulation.setup().radius;
    /// let painted = simulation.paint(rec, &Dab {
    ///     brush: Brush::Trail { amount: 5.0 },
    ///     center: glam::Vec3::new(0.0, 0.0, radius),
    ///     radius: 0.1 * radius,
    ///     eye: None,
    ///     ring: None,
    ///     number: 0,
    /// })?;
    /// assert!(painted.count() > 0);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// When a number of the dab is out of its range, it has too many texels, or the device has no memory left. Then nothing
    /// is recorded.
    pub fn paint(&mut self, rec: &mut Recorder, dab: &Dab) -> Result<Painted> {
        self.paint_on_scaled(rec, dab, &[])
    }

    /// As [`paint`](Self::paint), where a picture shows each object `scales` times as large about its own origin: one factor an
    /// object, greater than 0; 1 for those beyond the end. What the dab covers in that picture is painted.
    ///
    /// # Errors
    /// As [`paint`](Self::paint), and when a factor is out of its range.
    pub fn paint_on_scaled(
        &mut self,
        rec: &mut Recorder,
        dab: &Dab,
        scales: &[f32],
    ) -> Result<Painted> {
        let mut texels = dab.texels_on_scaled(self.setup(), self.poses(), scales)?;
        texels.retain(|texel| self.spared.get(texel.object as usize) != Some(&true));
        let painted = Painted::of(&texels, self.poses().len());
        if texels.is_empty() {
            return Ok(painted);
        }
        self.make_painter()?;
        if dab.makes_bias() {
            self.make_bias()?;
        }
        if dab.makes_looks() {
            self.make_looks()?;
        }
        if dab.of_particles(self.settings()).is_some() {
            self.let_cells_be_shared()?;
        }
        let count = texels.len() as u32;
        let of_bias = dab.of_bias(count).filter(|_| self.state.bias.is_some());
        let of_looks = dab.of_looks(count).filter(|_| self.state.looks.is_some());
        let of_trail = dab.of_trail(count);
        if of_bias.is_some() || of_looks.is_some() || of_trail.is_some() {
            let entries = texels.iter().map(|texel| (texel.texel, texel.weight));
            let entries = self.entries_of(entries)?;
            let state = &self.state;
            if let Some(params) = of_trail {
                let trail = &state.trail;
                self.paint_field(rec, &entries, &trail.front, params);
            }
            if let (Some(params), Some(bias)) = (of_bias, &state.bias) {
                self.paint_field(rec, &entries, bias, params);
            }
            if let (Some(params), Some(looks)) = (of_looks, &state.looks) {
                self.paint_field(rec, &entries, looks, params);
            }
        }
        self.teleport(rec, dab, &texels)?;
        Ok(painted)
    }

    fn make_painter(&mut self) -> Result<()> {
        if self.painter.is_none() {
            self.painter = Some(Painter::new(
                &self.ctx,
                self.means().paths,
                tables_of(&self.ctx, self.setup()),
            )?);
        }
        Ok(())
    }

    /// From now on sensors read a bias, which is zero at first.
    fn make_bias(&mut self) -> Result<()> {
        if self.state.bias.is_some() {
            return Ok(());
        }
        let bias = unpainted(&self.ctx, self.setup().atlas.density.len())?;
        self.take_bias(Some(bias))
    }

    /// From now on several particles may be in a cell.
    fn let_cells_be_shared(&mut self) -> Result<()> {
        if self.course.is_apart() {
            let means = Means {
                apart: false,
                ..self.means()
            };
            let every = self.course.of_every_kernel(self.settings(), means);
            every.prepare(&mut self.pipelines)?;
            self.course.let_cells_be_shared();
        }
        Ok(())
    }

    /// From now on sensors read this bias, or none.
    fn take_bias(&mut self, bias: Option<Texture<f32>>) -> Result<()> {
        if bias.is_some() != self.state.bias.is_some() {
            let means = Means {
                painted: bias.is_some(),
                ..self.means()
            };
            let every = self.course.of_every_kernel(self.settings(), means);
            self.pipelines = pipelines_of(&self.ctx, self.setup(), &every)?;
        }
        self.state.bias = bias;
        Ok(())
    }

    /// From now on there are weights of the second look, which are zero at first.
    fn make_looks(&mut self) -> Result<()> {
        if self.state.looks.is_some() {
            return Ok(());
        }
        let looks = unlooked(&self.ctx, self.setup().atlas.density.len())?;
        self.take_looks(Some(looks))
    }

    /// From now on particles follow the second look by these weights, or nowhere.
    fn take_looks(&mut self, looks: Option<Texture<f32>>) -> Result<()> {
        if looks.is_some() != self.state.looks.is_some() {
            let means = Means {
                looks: looks.is_some(),
                ..self.means()
            };
            let every = self.course.of_every_kernel(self.settings(), means);
            self.pipelines = pipelines_of(&self.ctx, self.setup(), &every)?;
        }
        self.state.looks = looks;
        Ok(())
    }

    /// Texels and weights, as `paint` reads them.
    fn entries_of(
        &self,
        texels: impl ExactSizeIterator<Item = (u32, f32)>,
    ) -> Result<Buffer<UVec2>> {
        let mut entries = Buffer::new(&self.ctx, "dab", texels.len(), Domain::Upload)?;
        for (entry, (texel, weight)) in entries.as_mut_slice().iter_mut().zip(texels) {
            *entry = UVec2::new(texel, weight.to_bits());
        }
        Ok(entries)
    }

    fn paint_field(
        &self,
        rec: &mut Recorder,
        dab: &Buffer<UVec2>,
        field: &Texture<f32>,
        params: PaintParams,
    ) {
        let Some(painter) = &self.painter else {
            return;
        };
        rec.dispatch(
            &painter.paint,
            Threads(params.texel_count),
            PaintArgs { dab, field },
            params,
        );
        rec.dispatch(
            &painter.exchange_seams,
            Threads(self.setup().atlas.seams.len() as u32),
            ExchangeSeamsArgs {
                seams: &self.state.atlas.seams,
                trail: field,
            },
            ExchangeSeamsParams {
                seam_count: self.setup().atlas.seams.len() as u32,
            },
        );
    }

    /// Moves particles to the dab, if the brush does that.
    fn teleport(&self, rec: &mut Recorder, dab: &Dab, texels: &[DabTexel]) -> Result<()> {
        let (Some(painter), Some(params)) = (&self.painter, dab.of_particles(self.settings()))
        else {
            return Ok(());
        };
        let Places { places, ranges } = dab.places(self.setup(), texels, self.settings().seed);
        let mut place_list: Buffer<Particle> =
            Buffer::new(&self.ctx, "places", places.len(), Domain::Upload)?;
        place_list.as_mut_slice().copy_from_slice(&places);
        let mut place_ranges: Buffer<UVec2> =
            Buffer::new(&self.ctx, "place_ranges", ranges.len(), Domain::Upload)?;
        place_ranges.as_mut_slice().copy_from_slice(&ranges);
        let state = &self.state;
        rec.dispatch(
            &painter.teleport,
            Threads(params.particle_count),
            TeleportArgs {
                places: &place_list,
                place_ranges: &place_ranges,
                triangles: &state.surface.triangles,
                particles: &state.particles.texels,
                motions: &state.motions.texels,
            },
            params,
        );
        Ok(())
    }
}

/// Texels that get values.
struct Part {
    /// How many there are.
    texel_count: u32,
    /// Each with the weight 1.
    ones: Buffer<UVec2>,
    /// Each with its value.
    values: Buffer<UVec2>,
}

/// Copies of earlier areas, for undo.
impl Simulation {
    /// Does a brush change areas, if it touches anything?
    #[must_use]
    pub fn changes_areas(&self, brush: Brush) -> bool {
        brush.changes_areas(self.state.bias.is_some() || self.state.looks.is_some())
    }

    /// Records a copy, on the device, of the areas after everything recorded so far.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn record_areas(&self, rec: &mut Recorder) -> Result<Areas> {
        // In memory of the same kind, because areas may be larger than a binding.
        let mut copy = |field: Option<&Texture<f32>>| {
            field.map(|field| copy_on_device(rec, field)).transpose()
        };
        Ok(Areas {
            bias: copy(self.state.bias.as_ref())?,
            looks: copy(self.state.looks.as_ref())?,
        })
    }

    /// The texels of a span of which anything painted has changed since `before`. Everything recorded must have been submitted; waits for
    /// it.
    ///
    /// # Errors
    /// When the span ends beyond the texels, the device is lost, or its memory is full.
    pub fn repainted(&self, before: &Areas, span: Range<u32>) -> Result<Vec<Repainted>> {
        if let Some(last) = span.clone().next_back() {
            self.check_texels([last])?;
        }
        let state = &self.state;
        let mut repainted = self.repainted_of(
            PaintedField::Bias,
            (&before.bias, &state.bias),
            span.clone(),
        )?;
        let looks = (&before.looks, &state.looks);
        repainted.extend(self.repainted_of(PaintedField::Looks, looks, span)?);
        Ok(repainted)
    }

    fn repainted_of(
        &self,
        field: PaintedField,
        (before, now): (&Option<Buffer<f32>>, &Option<Texture<f32>>),
        span: Range<u32>,
    ) -> Result<Vec<Repainted>> {
        let mut repainted = Vec::new();
        let Some(now) = now else {
            return Ok(repainted);
        };
        for first in span.clone().step_by(COMPARED_AT_ONCE as usize) {
            let end = first.saturating_add(COMPARED_AT_ONCE).min(span.end);
            let part = first as usize..end as usize;
            let after = self.ctx.download_range(now, part.clone())?;
            let before = match before {
                Some(field) => self.ctx.download_range(field, part)?,
                None => vec![0.0; after.len()],
            };
            let all = (first..).zip(before.into_iter().zip(after));
            let all = all.map(|(texel, (before, after))| Repainted {
                field,
                texel,
                before,
                after,
            });
            repainted.extend(all.filter(|texel| texel.before != texel.after));
        }
        Ok(repainted)
    }

    /// Refuses texels that the atlas does not have: a kernel would write elsewhere.
    fn check_texels(&self, texels: impl IntoIterator<Item = u32>) -> Result<()> {
        let count = self.setup().atlas.density.len();
        let beyond = texels.into_iter().find(|texel| *texel as usize >= count);
        beyond.map_or(Ok(()), |texel| {
            Err(Error::Invalid(format!(
                "there is no texel {texel} in this scene, whose atlas has {count}, counted from 0: what was painted can be compared and \
                 put back only where it was painted"
            )))
        })
    }

    /// Records that texels get their earlier values (with `again`, their later ones). Each is listed once.
    ///
    /// # Errors
    /// When the atlas does not have one of the texels, or the device has no memory left. Then nothing is recorded.
    pub fn put_areas(
        &mut self,
        rec: &mut Recorder,
        texels: &[Repainted],
        again: bool,
    ) -> Result<()> {
        if texels.is_empty() {
            return Ok(());
        }
        self.check_texels(texels.iter().map(|texel| texel.texel))?;
        self.make_painter()?;
        let mut parts = Vec::new();
        for field in [PaintedField::Bias, PaintedField::Looks] {
            let own = texels.iter().filter(|texel| texel.field == field);
            let own: Vec<Repainted> = own.copied().collect();
            if own.is_empty() {
                continue;
            }
            match field {
                PaintedField::Bias => self.make_bias()?,
                PaintedField::Looks => self.make_looks()?,
            }
            for part in own.chunks(MOST_TEXELS) {
                parts.push((field, self.part_of(part, again)?));
            }
        }
        for (field, part) in parts {
            self.put_part(rec, field, part);
        }
        Ok(())
    }

    /// What gives texels their values.
    fn part_of(&self, texels: &[Repainted], again: bool) -> Result<Part> {
        let value = |texel: &Repainted| if again { texel.after } else { texel.before };
        Ok(Part {
            texel_count: texels.len() as u32,
            ones: self.entries_of(texels.iter().map(|texel| (texel.texel, 1.0)))?,
            values: self.entries_of(texels.iter().map(|texel| (texel.texel, value(texel))))?,
        })
    }

    /// Records that texels get values.
    fn put_part(&self, rec: &mut Recorder, field: PaintedField, part: Part) {
        let Part {
            texel_count,
            ones,
            values,
        } = part;
        let field = match field {
            PaintedField::Bias => &self.state.bias,
            PaintedField::Looks => &self.state.looks,
        };
        let Some(field) = field else {
            return;
        };
        // The old value is removed entirely; then the weight is added, in units.
        let params = PaintParams {
            texel_count,
            fade: 1.0,
            amount: 0.0,
            lowest: NO_GO,
            highest: GREATEST,
            no_go: NO_GO_BELOW,
        };
        self.paint_field(rec, &ones, field, params);
        let params = PaintParams {
            fade: 0.0,
            amount: 1.0,
            ..params
        };
        self.paint_field(rec, &values, field, params);
    }

    /// The present bias: one value per texel, gutters filled; empty if nothing was ever painted. Waits for all submitted work.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn areas(&self) -> Result<Vec<f32>> {
        match &self.state.bias {
            Some(bias) => Ok(self.ctx.download(bias)?),
            None => Ok(Vec::new()),
        }
    }

    /// Replaces all areas by ones that [`areas`](Self::areas) has returned.
    ///
    /// # Errors
    /// When there is another number of texels, or the device has no memory left.
    pub fn set_areas(&mut self, bias: &[f32]) -> Result<()> {
        let texels = self.setup().atlas.density.len();
        if ![0, texels].contains(&bias.len()) {
            return Err(Error::Invalid(format!(
                "there are {} texels of areas, and the atlas has {texels}",
                bias.len()
            )));
        }
        self.take_bias(bias_of(&self.ctx, bias)?)
    }

    /// The present weights of the second look: one value per texel, gutters filled; empty if nothing was ever painted. Waits for all
    /// submitted work.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn looks(&self) -> Result<Vec<f32>> {
        match &self.state.looks {
            Some(looks) => Ok(self.ctx.download(looks)?),
            None => Ok(Vec::new()),
        }
    }

    /// Replaces all weights of the second look by ones that [`looks`](Self::looks) has returned.
    ///
    /// # Errors
    /// When there is another number of texels, or the device has no memory left.
    pub fn set_looks(&mut self, looks: &[f32]) -> Result<()> {
        let texels = self.setup().atlas.density.len();
        if ![0, texels].contains(&looks.len()) {
            return Err(Error::Invalid(format!(
                "there are {} texels of a second look, and the atlas has {texels}",
                looks.len()
            )));
        }
        self.take_looks(looks_of(&self.ctx, looks)?)
    }

    /// Removes all areas, the bias and the second look's weights.
    ///
    /// # Errors
    /// When the kernels of a step without them cannot be made.
    pub fn forget_areas(&mut self) -> Result<()> {
        self.take_bias(None)?;
        self.take_looks(None)
    }
}
