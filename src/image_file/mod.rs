//! image_file.
