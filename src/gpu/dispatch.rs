//! Recording dispatches: direct ones, whose number of invocations the host gives, and indirect ones, whose number the device counts.

use ash::vk;

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer};
use super::kernel::{DispatchGroups, Kernel, Pipeline, Resource, Threads};
use super::recorder::Recorder;
use super::timer::SpanKind;

impl Recorder {
    /// Runs a kernel with at least `threads` invocations; none records nothing.
    ///
    /// # Panics
    /// If a buffer has fewer elements than the invocations need, for buffers whose shader declares that; with checks on, if one buffer is
    /// bound twice and written.
    pub fn dispatch<K: Kernel>(
        &mut self,
        pipeline: &Pipeline<K>,
        threads: Threads,
        args: K::Args<'_>,
        params: K::Params,
    ) {
        let Some([x, y]) = threads.groups(K::GROUP_SIZE, self.ctx().info().max_group_count) else {
            return;
        };
        if !self.admits::<K>(pipeline.core().name, &args) {
            return;
        }
        Self::check_lengths::<K>(pipeline.core().name, threads, &args);
        self.bind::<K>(pipeline.core(), Access::Kernel, None, &args, &params);
        self.work(pipeline.core().name, SpanKind::Kernel, |rec| {
            for (i, part) in rec.parts_of(pipeline.core().name, [x, y]).enumerate() {
                if i > 0 {
                    rec.end_slice();
                    rec.put::<K>(
                        pipeline.core(),
                        vk::PipelineBindPoint::COMPUTE,
                        &args,
                        &params,
                    );
                }
                rec.dispatch_part(part);
            }
        });
    }

    /// Is every buffer long enough, if the shader declares what each invocation needs?
    fn check_lengths<K: Kernel>(name: &str, threads: Threads, args: &K::Args<'_>) {
        let bound = K::resources(args).into_iter().zip(K::BINDINGS);
        for (resource, binding) in bound.filter(|(_, binding)| binding.each > 0) {
            let Some(core) = resource.core() else {
                continue;
            };
            let element = match resource {
                Resource::Texels(texels) => 4 * texels.components() as usize,
                _ => binding.element,
            };
            let has = core.size_in_bytes() / element as u64;
            let needs = u64::from(threads.0) * u64::from(binding.each);
            assert!(
                has >= needs,
                "`{name}` runs {} invocations, which need {needs} elements of {}, and `{}` has {has}",
                threads.0,
                binding.name,
                core.name()
            );
        }
    }

    /// As [`Recorder::dispatch`], with the groups that `groups` holds at `index`; they stay on the device.
    ///
    /// # Panics
    /// If `groups` has no such index or was never written, or one buffer is bound twice and written.
    pub fn dispatch_indirect<K: Kernel>(
        &mut self,
        pipeline: &Pipeline<K>,
        (groups, index): (&Buffer<DispatchGroups>, usize),
        args: K::Args<'_>,
        params: K::Params,
    ) {
        assert!(
            index < groups.len(),
            "`{}` has {} elements, not {index}",
            groups.name(),
            groups.len()
        );
        if !self.admits::<K>(pipeline.core().name, &args) {
            return;
        }
        let core = groups.core();
        assert!(
            core.has_content(),
            "`{}` says how often `{}` runs, and nothing has been written to it",
            core.name(),
            pipeline.core().name
        );
        let groups = Some((core, Access::Indirect));
        self.bind::<K>(pipeline.core(), Access::Kernel, groups, &args, &params);
        self.work(pipeline.core().name, SpanKind::Kernel, |rec| {
            let offset = (index * size_of::<DispatchGroups>()) as u64;
            // SAFETY: as in `dispatch`; the groups lie in the buffer, which was made for indirect use.
            unsafe {
                rec.device()
                    .cmd_dispatch_indirect(rec.raw(), core.whole(), offset)
            };
        });
    }

    /// As [`Recorder::dispatch_indirect`], for at most `most` invocations and a kernel that itself skips those beyond `groups`.
    /// Slicing can then divide the dispatch, although only the device has counted the invocations.
    ///
    /// # Panics
    /// As [`Recorder::dispatch_indirect`].
    pub fn dispatch_at_most<K: Kernel>(
        &mut self,
        pipeline: &Pipeline<K>,
        most: Threads,
        groups: (&Buffer<DispatchGroups>, usize),
        args: K::Args<'_>,
        params: K::Params,
    ) {
        if self.takes_long(pipeline.core().name) {
            self.dispatch(pipeline, most, args, params);
        } else {
            self.dispatch_indirect(pipeline, groups, args, params);
        }
    }
}
