//! The macro that turns the table of settings into structs and definitions.

/// Declares `Settings` (what is given), `SettingValues` (with defaults) and `DEFINITIONS`.
///
/// An entry is `name: Type = default, Group { key: value, … }` with its help as doc comment; keys are fields of
/// [`super::Definition`]. A setting without default is an `Option` in `SettingValues`.
macro_rules! settings {
    ($(
        $(#[doc = $doc:literal])+
        $name:ident: $type:ty $(= $default:expr)?, $group:ident { $($key:ident: $value:expr),* $(,)? }
    )+) => {
        /// Settings of `rayframe render` that are given, each with its origin.
        #[derive(Clone, Debug, Default, PartialEq)]
        #[non_exhaustive]
        pub struct Settings {
            $($(#[doc = $doc])+ pub $name: Option<Assigned<<$type as SettingType>::Value>>,)+
            /// Whether `crop` gives way where it reaches beyond the image: a stronger level decides about the size of the image, and so
            /// does the camera.
            pub(crate) crop_gives_way: bool,
        }

        /// All settings with defaults applied.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct SettingValues {
            $($(#[doc = $doc])+ pub $name: value_type!($type $(, $default)?),)+
            /// Whether `crop` gives way where it reaches beyond the image.
            pub(crate) crop_gives_way: bool,
        }

        impl Settings {
            /// The values, with defaults for what is not given.
            pub fn values(&self) -> SettingValues {
                SettingValues {
                    $($name: value_of!(self.$name $(, $default)?),)+
                    crop_gives_way: self.crop_gives_way,
                }
            }
        }

        /// Every setting, in the order of the help.
        pub static DEFINITIONS: &[Definition] = &[$(Definition {
            help: &[$($doc),+],
            $($key: $value,)*
            ..Definition::new(stringify!($name), Group::$group, <$type as SettingType>::FORM, Access {
                parse: |settings, text, origin| set::<$type>(&mut settings.$name, text, origin),
                origin: |settings| settings.$name.as_ref().map(|given| &given.origin),
                write: |settings| settings.$name.as_ref().map(|given| <$type as SettingType>::write(&given.value)),
                check: |settings| {
                    settings.$name.as_ref().map_or(Ok(()), |given| <$type as SettingType>::check(&given.value))
                },
                write_default: || default_texts!($type $(, $default)?),
                copy: |to, from| to.$name.clone_from(&from.$name),
                clear: |settings| settings.$name = None,
                rebase: <$type as SettingType>::rebase,
                choices: <$type as SettingType>::choices,
            })
        }),+];
    };
}

macro_rules! value_type {
    ($type:ty) => { Option<<$type as SettingType>::Value> };
    ($type:ty, $default:expr) => { <$type as SettingType>::Value };
}

macro_rules! value_of {
    ($field:expr) => {
        $field.as_ref().map(|given| given.value.clone())
    };
    ($field:expr, $default:expr) => {
        $field.as_ref().map_or_else(|| $default, |given| given.value.clone())
    };
}

macro_rules! default_texts {
    ($type:ty) => {
        None
    };
    ($type:ty, $default:expr) => {
        Some(<$type as SettingType>::write(&$default))
    };
}

pub(super) use {default_texts, settings, value_of, value_type};
