//! Previews of kept frames: those that are missing, or that show another tone mapping, are made from the frames' files.

use std::sync::mpsc::{Receiver, channel};

use rayon::Scope;

use crate::cancel::CancelFlag;
use crate::error::{Error, Result};
use crate::image_file::{encode_png, insert_preview_hash, inspect_png, write_atomically};
use crate::output::PreviewLook;

use super::panic::catch_panic;
use super::render_hash::preview_hash;
use super::stored_frame::display_exr;
use super::{PlannedFrame, SequenceJob};

/// A preview that is being inspected and, where it is needed, written.
pub(super) struct KeptPreview(Receiver<Result<bool>>);

impl KeptPreview {
    /// Writes the preview of a kept frame as a task of `pool`, unless it is there and whole or `stop` is raised before; `None` without
    /// previews.
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
                    let hash = preview_hash(job, &planned.render_hash, look);
                    if inspect_png(path).is_ok_and(|stored| stored.preview_hash.as_ref() == Some(&hash)) {
                        return Ok(false);
                    }
                    let image = display_exr(job, planned, look)?;
                    let mut png = encode_png(image.size, &image.pixels, &planned.render_hash)?;
                    insert_preview_hash(&mut png, &hash);
                    write_atomically(path, &png).map(|()| true)
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

    /// Returns when the preview is there: true where it was written now.
    ///
    /// # Errors
    /// Those of reading the frame and of writing the preview.
    pub(super) fn written(self, frame: i64) -> Result<bool> {
        let ended = Error::Internal { message: format!("frame {frame}: the preview ended without a result") };
        self.0.recv().unwrap_or(Err(ended))
    }
}
