//! Tests of sequences of files.

use super::*;
use crate::image_file::PAGE_MARK;

fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, "").unwrap();
    }
    folder
}

fn frames_of(paired: &PairedFiles) -> Vec<i64> {
    paired.pairs.iter().filter_map(|pair| pair.frame).collect()
}

#[test]
fn frames_are_paired_by_number() {
    let ours = folder(&["a.0001.exr", "a.0002.exr", "a.0010.exr", "notes.txt", "a.0003.exr.tmp"]);
    let theirs = folder(&["b_1.exr", "b_2.exr", "b_3.exr", "b_x.exr", "c_1.exr"]);
    for place in ["b_#.exr", "b_%d.exr", "b_{frame}.exr"] {
        let paired = pair_files(&ours.path().join("a.####.exr"), &theirs.path().join(place)).unwrap();
        assert_eq!(frames_of(&paired), [1, 2]);
        assert_eq!(paired.only_in_actual, [ours.path().join("a.0010.exr")]);
        assert_eq!(paired.only_in_reference, [theirs.path().join("b_3.exr")]);
    }
    let paired = pair_files(ours.path(), &theirs.path().join("b_#.exr")).unwrap();
    assert_eq!(frames_of(&paired), [1, 2]);
}

#[test]
fn the_files_of_a_folder_are_those_below_it_in_order() {
    let files = folder(&["b/c.0001.exr", "b/a.0010.exr", "b/a.0002.exr", ".h/a.exr", "a/x/d.png", "z.png"]);
    #[cfg(unix)]
    std::os::unix::fs::symlink("b", files.path().join("link")).unwrap();
    let expected = ["z.png", "a/x/d.png", "b/a.0002.exr", "b/a.0010.exr", "b/c.0001.exr"];
    assert_eq!(sequence_files(files.path()).unwrap(), expected.map(|name| files.path().join(name)));
}

#[cfg(unix)]
#[test]
fn links_to_nothing_are_frames_and_others_what_they_lead_to() {
    use std::os::unix::fs::symlink;
    let (files, reference) = (folder(&["a.0001.exr", "notes.txt"]), folder(&["a.0001.exr"]));
    let at = |name: &str| files.path().join(name);
    for (target, name) in
        [("gone.exr", "a.0002.exr"), ("a.0001.exr", "a.0003.exr"), (".", "a.0004.exr"), ("gone", "notes")]
    {
        symlink(target, at(name)).unwrap();
    }
    let frames = ["a.0001.exr", "a.0002.exr", "a.0003.exr"].map(at);
    for sequence in [files.path().to_owned(), at("a.####.exr")] {
        assert_eq!(sequence_files(&sequence).unwrap(), frames);
        let paired = pair_files(&sequence, &reference.path().join("a.####.exr")).unwrap();
        assert_eq!((frames_of(&paired), &*paired.only_in_actual), (vec![1], &frames[1..]));
    }
}

#[test]
fn a_minus_belongs_to_a_number_unless_it_follows_a_word() {
    for (name, frame) in [
        ("a.-001.exr", -1),
        ("-3.exr", -3),
        ("neg_-001.exr", -1),
        ("shot--001.exr", -1),
        ("shot-0001.exr", 1),
        ("v2-0001.exr", 1),
        ("\u{e9}-0001.exr", 1),
    ] {
        assert_eq!(frame_number(Path::new(name)), Some(frame), "{name}");
    }
}

#[test]
fn names_that_render_writes_are_found() {
    let files = folder(&["a01_01.exr", "a01_02.exr", "p%q.0001.exr", "x0001/y0001.exr", "x0002/y0003.exr"]);
    for pattern in ["a##_##.exr", "p%%q.%04d.exr", "x####/y####.exr"] {
        let pattern = files.path().join(pattern);
        let paired = pair_files(&pattern, &pattern).unwrap();
        assert_eq!(frames_of(&paired), [1], "{}", pattern.display());
        assert_eq!(sequence_files(&pattern).unwrap().len(), 1);
    }
}

#[test]
fn folders_of_several_sequences_are_paired_by_name_too() {
    let ours = folder(&["a.0001.exr", "a.depth.0001.exr", "a.-001.exr"]);
    let theirs = folder(&["a.0001.exr", "a.depth.0001.exr", "a.0002.exr", "still.png"]);
    let paired = pair_files(ours.path(), theirs.path()).unwrap();
    let names: Vec<_> = paired.pairs.iter().map(|pair| pair.actual.file_name().unwrap()).collect();
    assert_eq!(names, ["a.0001.exr", "a.depth.0001.exr"]);
    assert!(paired.pairs.iter().all(|pair| pair.actual.file_name() == pair.reference.file_name()));
    assert_eq!((paired.only_in_actual.len(), paired.only_in_reference.len()), (1, 2));
}

#[test]
fn folders_below_are_paired_by_their_paths() {
    let ours = folder(&[
        "a.1.exr",
        "b/x.1.exr",
        "b/x.2.exr",
        "b/c/still.exr",
        "only/z.png",
        ".git/h.png",
        "report/images/a.exr",
        "s.md",
        "s.md.files/0001-a-new.png",
    ]);
    std::fs::write(ours.path().join("report/index.html"), PAGE_MARK).unwrap();
    let theirs = folder(&["k.1.exr", "b/y.1.exr", "b/y.2.exr", "b/c/still.exr", "b/c/other.exr"]);
    let paired = pair_files(ours.path(), theirs.path()).unwrap();
    let of_pair = |pair: &FilePair| {
        let below = pair.reference.strip_prefix(theirs.path()).unwrap();
        (below.display().to_string().replace('\\', "/"), pair.frame)
    };
    assert_eq!(
        paired.pairs.iter().map(of_pair).collect::<Vec<_>>(),
        [("k.1.exr", Some(1)), ("b/y.1.exr", Some(1)), ("b/y.2.exr", Some(2)), ("b/c/still.exr", None)]
            .map(|(name, frame)| (name.to_owned(), frame))
    );
    assert_eq!(paired.only_in_actual, [ours.path().join("only/z.png")]);
    assert_eq!(paired.only_in_reference, [theirs.path().join("b/c/other.exr")]);
    // A pattern is of one folder, and so is what it is paired with.
    let paired = pair_files(ours.path(), &theirs.path().join("k.#.exr")).unwrap();
    assert_eq!((frames_of(&paired), paired.only_in_actual.len()), (vec![1], 0));
}

#[test]
#[cfg(unix)]
fn links_to_folders_are_not_followed() {
    let (ours, theirs) = (folder(&["a.exr", "b/c.exr"]), folder(&["a.exr"]));
    std::os::unix::fs::symlink(ours.path().join("b"), theirs.path().join("b")).unwrap();
    std::os::unix::fs::symlink(ours.path(), ours.path().join("b/d")).unwrap();
    let paired = pair_files(ours.path(), theirs.path()).unwrap();
    assert_eq!(paired.pairs.len(), 1);
    assert_eq!(paired.only_in_actual, [ours.path().join("b/c.exr")]);
}

#[test]
fn names_that_are_not_valid_are_usage_errors_unless_they_are_files() {
    let files = folder(&["a.1.exr", "b.%4d.exr"]);
    let [valid, wrong, file] = ["a.#.exr", "a.%4d.exr", "b.%4d.exr"].map(|name| files.path().join(name));
    let pairs = [pair_files(&wrong, &valid).map(drop), pair_files(&valid, &wrong).map(drop)];
    for result in pairs.into_iter().chain([sequence_files(&wrong).map(drop)]) {
        let error = result.unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains("must be %04d"), "{error}");
    }
    assert_eq!(pair_files(&file, &file).unwrap().pairs.len(), 1);
}

#[test]
fn a_word_after_a_percent_sign_is_a_missing_file() {
    let files = folder(&["50%.exr", "b.1.exr"]);
    let [word, pattern, file] = ["50%done.exr", "50%d.exr", "b.1.exr"].map(|name| files.path().join(name));
    assert!(!is_sequence(&word).unwrap() && is_sequence(&pattern).unwrap());
    assert_eq!(pair_files(&word, &file).unwrap().pairs[0].actual, word);
    assert_eq!(pair_files(&pattern, &file).unwrap_err().exit_code(), 2);
}

#[test]
fn two_files_of_one_frame_number_are_an_error() {
    let (ours, theirs) = (folder(&["a.01.exr", "a.002.exr", "a.1.exr"]), folder(&["a.1.exr", "a.2.exr"]));
    for error in [pair_files(ours.path(), theirs.path()), pair_files(theirs.path(), ours.path())] {
        let error = error.unwrap_err();
        let message = error.to_string();
        assert_eq!(error.exit_code(), 2);
        assert!(message.contains("a.01.exr and ") && message.contains("a.1.exr have"), "{message}");
    }
    // A field for the number selects one of them.
    let paired = pair_files(&ours.path().join("a.##.exr"), theirs.path()).unwrap();
    assert_eq!(frames_of(&paired), [1]);
}

#[test]
fn a_file_beside_a_sequence_and_empty_folders_are_errors() {
    let (full, empty) = (folder(&["a.0001.exr"]), folder(&["a.txt"]));
    let file = full.path().join("a.0001.exr");
    assert_eq!(pair_files(&file, full.path()).unwrap_err().exit_code(), 2);
    for error in [pair_files(full.path(), empty.path()).map(drop), sequence_files(empty.path()).map(drop)] {
        let error = error.unwrap_err();
        let message = format!("{}: holds no images", empty.path().display());
        assert_eq!((error.exit_code(), error.to_string()), (66, message));
    }
    assert_eq!(pair_files(&file, &file).unwrap().pairs.len(), 1);
    let pattern = full.path().join("a.%04d.png");
    assert_eq!(pair_files(&pattern, &pattern).unwrap_err().exit_code(), 66);
}

#[test]
fn a_folder_that_does_not_exist_is_missing() {
    let files = folder(&["a.0001.exr"]);
    let [gone, pattern, file] = ["gone", "a.####.exr", "a.0001.exr"].map(|name| files.path().join(name));
    for sequence in [files.path(), &pattern] {
        for error in [pair_files(sequence, &gone), pair_files(&gone, sequence)] {
            let error = error.unwrap_err();
            assert!(error.exit_code() == 66 && error.to_string().contains("gone"), "{error}");
        }
        assert_eq!(pair_files(sequence, &file).unwrap_err().exit_code(), 2);
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf8_are_other_ones() {
    use std::os::unix::ffi::OsStrExt as _;

    let (first, second) = (OsStr::from_bytes(b"\xe4_1.exr"), OsStr::from_bytes(b"\xf6_1.exr"));
    assert_ne!(numbered_name(first), numbered_name(second));
    assert_eq!(numbered_name(first).1, None);
    // Letters beyond ASCII are no numbers.
    assert_eq!(numbered_name(OsStr::new("\u{e4}.exr")), ("\u{e4}.exr".to_owned(), None));
    assert_eq!(numbered_name(OsStr::new("a_0009_\u{e9}.exr")).1, Some(9));
}
