//! Previews of kept frames, made anew from their files.

use std::sync::mpsc::{Receiver, channel};

use rayon::Scope;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{encode_png, write_atomically};
use crate::output::PreviewLook;

use super::panic::catch_panic;
use super::stored_frame::display_exr;
use super::{PlannedFrame, SequenceJob};

/// A preview that is being written.
pub(super) struct KeptPreview(Receiver<Result<()>>);

impl KeptPreview {
    /// Writes the preview of a kept frame as a task of `pool`, unless `stop` is raised before; `None` without previews.
    pub(super) fn spawn<'s>(
        (job, planned): (&'s SequenceJob, &'s PlannedFrame),
        look: PreviewLook,
        stop: &'s CancelFlag,
        pool: &Scope<'s>,
    ) -> Option<Self> {
        let path = planned.preview_path.as_deref()?;
        let (sender, receiver) = channel();
        let work = move || {
            let written = stop.check().map_err(Error::from).and_then(|()| {
                catch_panic(planned.frame, || {
                    let image = display_exr(job, planned, look)?;
                    write_atomically(path, &encode_png(image.size, &image.pixels, &planned.render_hash)?)
                })
            });
            // The receiver is gone when the run has ended.
            let _ = sender.send(written);
        };
        // A pool of one thread would not start the task before the next frame is traced.
        if rayon::current_num_threads() == 1 {
            work();
        } else {
            pool.spawn(move |_| work());
        }
        Some(Self(receiver))
    }

    /// Returns when the preview is written.
    ///
    /// # Errors
    /// Those of reading the frame and of writing the preview.
    pub(super) fn written(self, frame: i64) -> Result<()> {
        let ended = Error::Internal { message: format!("frame {frame}: the preview ended without a result") };
        self.0.recv().unwrap_or(Err(ended))
    }
}
