//! What entries hold, what is no entry, and the bound of the folder.

use std::fs::{self, File};
use std::time::{Duration, SystemTime};

use super::eviction::ENDING;
use super::{AssetCache, ImageShape, SourceKey};
use crate::scene::{AssetCacheUse, Encoding, Image, Texels, mip_levels};

/// Odd sides, more than one block.
const SHAPE: ImageShape = ImageShape { width: 613, height: 501, is_deep: false };
const DEEP: ImageShape = ImageShape { is_deep: true, ..SHAPE };

fn texels(shape: ImageShape) -> Texels {
    let value = |index: u32| index.wrapping_mul(2_654_435_761).to_le_bytes();
    let count = shape.width * shape.height;
    if !shape.is_deep {
        return Texels::Rgba8((0..count).map(value).collect());
    }
    let deep = |index| value(index).map(|byte| (u16::from(byte) * 251).wrapping_add(index as u16));
    Texels::Rgba16((0..count).map(deep).collect())
}

fn image(shape: ImageShape) -> Image {
    Image { name: None, width: shape.width, height: shape.height, texels: texels(shape) }
}

fn names(folder: &std::path::Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    names.collect()
}

#[test]
fn entries_hold_what_was_stored_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for shape in [SHAPE, DEEP] {
        let cache = AssetCache::open(folder.path(), 1 << 30);
        let (image, key) = (image(shape), shape.key_of(&[u8::from(shape.is_deep)]).unwrap());
        assert_eq!(cache.texels(key, shape), None);
        cache.store_texels(key, shape, &image.texels);
        // Another process.
        let other = AssetCache::open(folder.path(), 1 << 30);
        assert_eq!(other.texels(key, shape), Some(image.texels.clone()));
        for encoding in [Encoding::Srgb, Encoding::CoveredSrgb, Encoding::Normal, Encoding::Linear] {
            assert_eq!(cache.mip_levels(key, shape, encoding), None);
            let levels = mip_levels(&image, encoding);
            cache.store_mip_levels(key, shape, (encoding, &levels));
            assert_eq!(other.mip_levels(key, shape, encoding), Some(levels));
        }
        assert_eq!(cache.usage(), AssetCacheUse { hits: 0, misses: 5 });
        assert_eq!(other.usage(), AssetCacheUse { hits: 5, misses: 0 });
        assert_eq!(cache.write_error(), None);
    }
    assert_eq!(names(folder.path()).len(), 10);
}

#[test]
fn other_sources_sizes_and_depths_have_no_entry() {
    let folder = tempfile::tempdir().unwrap();
    let cache = AssetCache::open(folder.path(), 1 << 30);
    let key = SourceKey::of(b"a");
    cache.store_texels(key, SHAPE, &texels(SHAPE));
    assert_eq!(cache.texels(SourceKey::of(b"b"), SHAPE), None);
    assert_eq!(cache.texels(key, DEEP), None);
    assert_eq!(cache.texels(key, ImageShape { width: 501, height: 614, is_deep: false }), None);
    assert_eq!(cache.mip_levels(key, SHAPE, Encoding::Linear), None);
    // Texels that are not of the stated size are not kept.
    let other = SourceKey::of(b"c");
    cache.store_texels(other, ImageShape { width: 614, ..SHAPE }, &texels(SHAPE));
    cache.store_texels(other, DEEP, &texels(SHAPE));
    assert_eq!(names(folder.path()).len(), 1);
    // Small images are decoded anew.
    assert_eq!(ImageShape { width: 64, height: 64, is_deep: true }.key_of(b"a"), None);
}

#[test]
fn damaged_entries_are_misses_and_written_anew() {
    let folder = tempfile::tempdir().unwrap();
    let cache = AssetCache::open(folder.path(), 1 << 30);
    let key = SourceKey::of(b"a");
    cache.store_texels(key, SHAPE, &texels(SHAPE));
    let path = folder.path().join(&names(folder.path())[0]);
    let whole = fs::read(&path).unwrap();
    let is_miss = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        cache.texels(key, SHAPE).is_none()
    };
    // One bit anywhere: in the header, in a block, in a checksum.
    for index in (0..60).chain((60..whole.len()).step_by(40_009)).chain([whole.len() - 1]) {
        let mut bytes = whole.clone();
        bytes[index] ^= 1 << (index % 8);
        assert!(is_miss(&bytes), "{index}");
    }
    // Blocks that changed places: both have one mebibyte.
    let mut bytes = whole.clone();
    let block = (1 << 20) + 4;
    let (first, second) = bytes[48..48 + block + 1000].split_at_mut(block);
    first[..1000].swap_with_slice(&mut second[..1000]);
    assert!(is_miss(&bytes));
    // Other lengths.
    for length in [0, 1, 47, 48, 1000, whole.len() - 1] {
        assert!(is_miss(&whole[..length]), "{length}");
    }
    assert!(is_miss(&[&whole[..], b"x"].concat()));
    cache.store_texels(key, SHAPE, &texels(SHAPE));
    assert!(fs::read(&path).unwrap() == whole);
    assert_eq!(cache.texels(key, SHAPE), Some(texels(SHAPE)));
    assert_eq!(cache.write_error(), None);
}

#[test]
fn the_bound_holds_and_files_of_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let entry_bytes = 613 * 501 * 4 + 48 + 2 * 4;
    let at = |name: &str| folder.path().join(name);
    // Names of entries with other content, and other names.
    let foreign = format!("{}{ENDING}", "0".repeat(64));
    for name in [&*foreign, "notes.txt", "x.rayasset"] {
        fs::write(at(name), "of somebody else").unwrap();
        age(&at(name), 1_000_000);
    }
    let keys: Vec<SourceKey> = (0..6_u8).map(|index| SourceKey::of(&[index])).collect();
    // Three fit. Each entry is stored by a process of its own.
    let max_bytes = entry_bytes * 3 + 100;
    let mut ages = 100_000;
    for (index, &key) in keys.iter().enumerate() {
        let cache = AssetCache::open(folder.path(), max_bytes);
        cache.store_texels(key, SHAPE, &texels(SHAPE));
        age(&cache.path(&key.entry("texels")), ages);
        ages -= 1000;
        // The first one is used all the time.
        assert!(cache.texels(keys[0], SHAPE).is_some(), "{index}");
        let entries: Vec<_> =
            names(folder.path()).into_iter().filter(|name| name.ends_with(ENDING)).collect();
        let bytes: u64 = entries.iter().map(|name| fs::metadata(at(name)).unwrap().len()).sum();
        assert!(bytes <= max_bytes, "{bytes} after {index}");
        assert_eq!(cache.write_error(), None);
    }
    let cache = AssetCache::open(folder.path(), max_bytes);
    let is_kept: Vec<bool> = keys.iter().map(|key| cache.texels(*key, SHAPE).is_some()).collect();
    assert_eq!(is_kept, [true, false, false, false, true, true]);
    for name in [&*foreign, "notes.txt", "x.rayasset"] {
        assert_eq!(fs::read(at(name)).unwrap(), b"of somebody else", "{name}");
    }
    // One process that stores many holds the bound, too.
    for index in 10..20_u8 {
        cache.store_texels(SourceKey::of(&[index]), SHAPE, &texels(SHAPE));
    }
    assert_eq!(names(folder.path()).len(), 6);
}

/// Makes a file look as if it was used `seconds` ago.
fn age(path: &std::path::Path, seconds: u64) {
    let time = SystemTime::now() - Duration::from_secs(seconds);
    File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
}

#[test]
fn threads_and_processes_that_store_at_once_see_whole_entries() {
    let folder = tempfile::tempdir().unwrap();
    let expected = texels(SHAPE);
    let entry_bytes = 613 * 501 * 4 + 48 + 2 * 4;
    std::thread::scope(|threads| {
        for thread in 0..4_u8 {
            let (expected, folder) = (&expected, folder.path());
            threads.spawn(move || {
                for round in 0..8_u8 {
                    // Two of three fit, so that entries are removed while others read them.
                    let cache = AssetCache::open(folder, entry_bytes * 2);
                    let key = SourceKey::of(&[(round + thread) % 3]);
                    if let Some(found) = cache.texels(key, SHAPE) {
                        assert!(found == *expected);
                    }
                    cache.store_texels(key, SHAPE, expected);
                    assert_eq!(cache.write_error(), None);
                }
            });
        }
    });
    assert!(names(folder.path()).iter().all(|name| name.ends_with(ENDING)));
}

/// Reading it for each entry took longer than decoding where it had very many.
#[test]
fn the_folder_is_read_after_a_twentieth_of_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    let store = |cache: &AssetCache, number: u8| {
        // 48 bytes of the header, 48 of the block and 4 of its checksum.
        cache.store(&[number; 32], 100, |entry| entry.block(&[0; 48]));
        assert_eq!(cache.write_error(), None);
        names(folder.path()).len()
    };
    // A hundred entries fit, and five are a twentieth.
    let [first, second] = [(), ()].map(|()| AssetCache::open(folder.path(), 10_000));
    assert_eq!(store(&first, 0), 1);
    for number in 1..100 {
        assert_eq!(store(&second, number), usize::from(number) + 1);
    }
    // The first process does not know of the entries of the second yet.
    for number in 100..104 {
        assert_eq!(store(&first, number), usize::from(number) + 1);
    }
    // Then a tenth of the bound is freed, so that the folder need not be read again soon.
    assert_eq!(store(&first, 104), 90);
    for number in 105..109 {
        assert_eq!(store(&first, number), usize::from(number) - 14);
    }
}

#[test]
fn folders_that_cannot_be_written_are_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for path in [file.clone(), file.join("below")] {
        let cache = AssetCache::open(&path, 1 << 30);
        assert_eq!(cache.texels(SourceKey::of(b"a"), SHAPE), None);
        assert_eq!(cache.write_error(), None, "nothing was written");
        for name in [b"a", b"b"] {
            cache.store_texels(SourceKey::of(name), SHAPE, &texels(SHAPE));
        }
        let trouble = cache.write_error().unwrap();
        assert!(trouble.contains("asset cache") && trouble.contains("file"), "{trouble}");
    }
}

#[cfg(unix)]
#[test]
fn links_and_pipes_are_no_entries() {
    let folder = tempfile::tempdir().unwrap();
    let cache = AssetCache::open(folder.path(), 1 << 30);
    let key = SourceKey::of(b"a");
    let path = cache.path(&key.entry("texels"));
    cache.store_texels(key, SHAPE, &texels(SHAPE));
    let elsewhere = folder.path().join("elsewhere");
    fs::rename(&path, &elsewhere).unwrap();
    std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
    assert_eq!(cache.texels(key, SHAPE), None);
    // The link is replaced, not the file that it leads to.
    let before = fs::read(&elsewhere).unwrap();
    cache.store_texels(key, SHAPE, &texels(SHAPE));
    assert!(fs::symlink_metadata(&path).unwrap().is_file());
    assert!(fs::read(&elsewhere).unwrap() == before);
    // Reading a pipe without a writer would wait for ever.
    fs::remove_file(&path).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
    assert!(made.success());
    assert_eq!(cache.texels(key, SHAPE), None);
}

#[test]
fn a_folder_beyond_a_smaller_bound_is_trimmed() {
    let folder = tempfile::tempdir().unwrap();
    let entry_bytes = 613 * 501 * 4 + 48 + 2 * 4;
    let cache = AssetCache::open(folder.path(), 1 << 30);
    for index in 0..4_u8 {
        cache.store_texels(SourceKey::of(&[index]), SHAPE, &texels(SHAPE));
    }
    fs::write(folder.path().join("notes.txt"), "of somebody else").unwrap();
    AssetCache::open(folder.path(), 2 * entry_bytes);
    assert_eq!(names(folder.path()).len(), 3);
    // Nothing fits, so nothing is stored.
    let none = AssetCache::open(folder.path(), entry_bytes - 1);
    none.store_texels(SourceKey::of(b"x"), SHAPE, &texels(SHAPE));
    assert_eq!(names(folder.path()), ["notes.txt"]);
    assert_eq!(none.write_error(), None);
}
