//! Placeholders of output names for the scene, the shot file, the clip, the camera and the variant.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// A placeholder of output names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placeholder {
    /// Name of the scene file, without its extension.
    Scene,
    /// Name of the shot file, without its extension; that of the scene where there is no shot file.
    Shot,
    /// Name of the animation clip.
    Clip,
    /// Name of the camera.
    Camera,
    /// Name of the material variant.
    Variant,
}

impl Placeholder {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Scene, Self::Shot, Self::Clip, Self::Camera, Self::Variant];

    /// The word in its braces, which is also its key in reports.
    pub fn key(self) -> &'static str {
        self.text().trim_matches(['{', '}'])
    }

    /// The placeholder as it is written.
    pub fn text(self) -> &'static str {
        match self {
            Self::Scene => "{scene}",
            Self::Shot => "{shot}",
            Self::Clip => "{clip}",
            Self::Camera => "{camera}",
            Self::Variant => "{variant}",
        }
    }

    /// The placeholder with which `text` begins.
    pub(super) fn at(text: &[u8]) -> Option<Self> {
        Self::ALL.into_iter().find(|placeholder| text.starts_with(placeholder.text().as_bytes()))
    }

    /// Whether the file name `path` has this placeholder.
    pub fn is_in(self, path: &Path) -> bool {
        let mut is_found = false;
        let _ = replaced(path, true, &mut |placeholder| {
            is_found |= placeholder == self;
            OsString::new()
        });
        is_found
    }
}

/// The letters in braces with which `text` begins, braces included: a placeholder, known or not.
pub(super) fn word_in_braces(text: &[u8]) -> Option<&str> {
    let letters = text.strip_prefix(b"{")?.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let word = text.get(..letters + 2).filter(|word| letters > 0 && word.ends_with(b"}"))?;
    std::str::from_utf8(word).ok()
}

/// What is wrong with an unknown placeholder.
pub(super) fn unknown_placeholder(word: &str, known: &str) -> String {
    format!("{word} is no placeholder; there are {known}, and %{word} for the text itself")
}

/// Checks the placeholders of the name of a file beside the frames.
///
/// # Errors
/// One line, for an unknown placeholder.
pub(super) fn check_placeholders(path: &Path) -> Result<(), String> {
    let bytes = path.as_os_str().as_encoded_bytes();
    let begins = |at: &usize| *at == 0 || bytes[at - 1] != b'%';
    let mut words = (0..bytes.len()).filter(begins).filter_map(|at| word_in_braces(&bytes[at..]));
    match words.find(|word| Placeholder::ALL.iter().all(|known| known.text() != *word)) {
        Some(word) => Err(unknown_placeholder(word, "{scene}, {shot}, {clip}, {camera}, {variant}")),
        None => Ok(()),
    }
}

/// The names that replace the placeholders for one sequence, as parts of file names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputNames {
    scene: OsString,
    shot: OsString,
    clip: OsString,
    camera: OsString,
    variant: OsString,
}

impl OutputNames {
    /// Makes the names safe with [`file_name_part`]. Scene and shot are files.
    pub fn new(scene: &Path, shot: Option<&Path>, clip: &str, camera: &str, variant: &str) -> Self {
        let stem = |path: &Path| file_name_part(path.file_stem().unwrap_or(OsStr::new("scene")));
        Self {
            scene: stem(scene),
            shot: stem(shot.unwrap_or(scene)),
            clip: file_name_part(OsStr::new(clip)),
            camera: file_name_part(OsStr::new(camera)),
            variant: file_name_part(OsStr::new(variant)),
        }
    }

    /// The name in place of `placeholder`.
    pub fn of(&self, placeholder: Placeholder) -> &OsStr {
        match placeholder {
            Placeholder::Scene => &self.scene,
            Placeholder::Shot => &self.shot,
            Placeholder::Clip => &self.clip,
            Placeholder::Camera => &self.camera,
            Placeholder::Variant => &self.variant,
        }
    }

    /// A file name with its placeholders replaced. `%{scene}` stands for the text `{scene}`.
    pub fn fill(&self, path: &Path) -> PathBuf {
        replaced(path, true, &mut |placeholder| self.of(placeholder).to_owned()).into()
    }

    /// A file name with `{shot}` replaced and everything else as it was.
    pub(crate) fn fill_shot(&self, path: &Path) -> PathBuf {
        let name = |placeholder: Placeholder| match placeholder {
            Placeholder::Shot => escaped_folder(Path::new(&self.shot)).into_os_string(),
            _ => placeholder.text().into(),
        };
        replaced(path, false, &mut { name }).into()
    }
}

/// A name as part of a file name on any system: control characters and each of `/ \ : * ? " < > |` become `_`, and so do dots at the
/// beginning, and dots and spaces at the end. An empty name becomes `_`.
pub fn file_name_part(name: &OsStr) -> OsString {
    let mut bytes = name.as_encoded_bytes().to_vec();
    for byte in &mut bytes {
        if byte.is_ascii_control() || br#"/\:*?"<>|"#.contains(byte) {
            *byte = b'_';
        }
    }
    let leading = bytes.iter().take_while(|&&byte| byte == b'.').count();
    let trailing = bytes.iter().rev().take_while(|&&byte| matches!(byte, b'.' | b' ')).count();
    let end = bytes.len() - trailing;
    bytes.iter_mut().take(leading).for_each(|byte| *byte = b'_');
    bytes.iter_mut().skip(end).for_each(|byte| *byte = b'_');
    if bytes.is_empty() {
        bytes.push(b'_');
    }
    // Only ASCII was replaced by ASCII, so that what was Unicode still is.
    os_string(bytes).unwrap_or_else(|_| name.to_owned())
}

/// A folder as the beginning of a file name with placeholders.
pub(super) fn escaped_folder(folder: &Path) -> PathBuf {
    let bytes = folder.as_os_str().as_encoded_bytes();
    let mut escaped = Vec::new();
    for (at, &byte) in bytes.iter().enumerate() {
        if word_in_braces(&bytes[at..]).is_some() {
            escaped.push(b'%');
        }
        escaped.push(byte);
    }
    os_string(escaped).map_or_else(|_| folder.to_owned(), PathBuf::from)
}

/// `path` with `name` of each placeholder in its place. `unescapes` removes the `%` of escaped ones.
fn replaced(path: &Path, unescapes: bool, name: &mut dyn FnMut(Placeholder) -> OsString) -> OsString {
    let bytes = path.as_os_str().as_encoded_bytes();
    let mut text = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let escaped = rest.strip_prefix(b"%").and_then(word_in_braces);
        if let Some(escaped) = escaped {
            text.extend_from_slice(if unescapes { b"" } else { b"%" });
            text.extend_from_slice(escaped.as_bytes());
            at += 1 + escaped.len();
        } else if let Some(placeholder) = Placeholder::at(rest) {
            text.extend_from_slice(name(placeholder).as_encoded_bytes());
            at += placeholder.text().len();
        } else {
            text.push(bytes[at]);
            at += 1;
        }
    }
    os_string(text).unwrap_or_else(|_| path.as_os_str().to_owned())
}

/// The bytes as text of the system.
///
/// # Errors
/// One line, where the system has Unicode names only.
#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "the version for other platforms can fail")]
pub(super) fn os_string(bytes: Vec<u8>) -> Result<OsString, String> {
    Ok(std::os::unix::ffi::OsStringExt::from_vec(bytes))
}

/// The bytes as text of the system.
///
/// # Errors
/// One line, where the system has Unicode names only.
#[cfg(not(unix))]
pub(super) fn os_string(bytes: Vec<u8>) -> Result<OsString, String> {
    String::from_utf8(bytes)
        .map(OsString::from)
        .map_err(|_| "the output name is not valid Unicode".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_parts_of_file_names() {
        let part = |name: &str| file_name_part(OsStr::new(name)).into_string().unwrap();
        assert_eq!(part("Armature|Walk"), "Armature_Walk");
        assert_eq!(part("../../etc/passwd"), "___.._etc_passwd");
        assert_eq!(part(".hidden"), "_hidden");
        assert_eq!(part("a\nb\u{7f}. ."), "a_b____");
        assert_eq!(part("..."), "___");
        assert_eq!(part(""), "_");
        assert_eq!(part("Größe 50% #1"), "Größe 50% #1");
    }

    #[cfg(unix)]
    #[test]
    fn names_need_not_be_unicode() {
        use std::os::unix::ffi::OsStrExt as _;
        let names = OutputNames::new(Path::new(OsStr::from_bytes(b"a/\xff.glb")), None, "x", "y", "z");
        assert_eq!(names.fill(Path::new("{scene}.json")).as_os_str().as_bytes(), b"\xff.json");
    }

    #[test]
    fn placeholders_of_file_names_are_replaced() {
        let shot = Some(Path::new("s/010.toml"));
        let names = OutputNames::new(Path::new("in/robot.v2.glb"), shot, "a/b", "auto", "red|matte");
        let fill = |path: &str| names.fill(Path::new(path)).into_os_string().into_string().unwrap();
        assert_eq!(fill("out/{scene}/{shot}.{clip}.{camera}.mp4"), "out/robot.v2/010.a_b.auto.mp4");
        assert_eq!(fill("{variant}/%{variant}.png"), "red_matte/{variant}.png");
        assert_eq!(fill("%{scene}%{x}%{y.png"), "{scene}{x}%{y.png");
        let folder = escaped_folder(Path::new("a {clip}/%b/{x}"));
        assert_eq!(names.fill(&folder.join("{clip}.gif")), Path::new("a {clip}/%b/{x}/a_b.gif"));
        assert!(
            Placeholder::Clip.is_in(Path::new("{clip}.gif"))
                && !Placeholder::Clip.is_in(Path::new("%{clip}.gif"))
        );
    }

    #[test]
    fn keys_are_the_words_in_braces() {
        let keys = Placeholder::ALL.map(Placeholder::key);
        assert_eq!(keys, ["scene", "shot", "clip", "camera", "variant"]);
    }

    #[test]
    fn words_in_braces_are_placeholders() {
        for text in
            ["{scene}.gif", "{variant}.gif", "%{name}.gif", "{a b}.gif", "{}.gif", "{x", "{0}.gif", "a}"]
        {
            assert_eq!(check_placeholders(Path::new(text)), Ok(()), "{text}");
        }
        for text in ["{name}.gif", "a/{scene}.{X}.gif", "{frame}.gif"] {
            let why = check_placeholders(Path::new(text)).unwrap_err();
            assert!(why.contains("there are {scene}, "), "{why}");
        }
    }
}
