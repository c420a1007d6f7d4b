//! Shards: parts of a suite that are tested on different machines.

use std::fmt;
use std::str::FromStr;

use sha2::{Digest as _, Sha256};

/// One of `count` parts of a suite. A shot belongs to a part by the hash of its name, so that new shots move no others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// Whether the shot of this name belongs to the part.
    pub fn includes(self, shot: &str) -> bool {
        let digest = Sha256::digest(shot.as_bytes());
        let hash = digest[..8].iter().fold(0, |hash, byte| hash << 8 | u64::from(*byte));
        hash % u64::from(self.count.max(1)) + 1 == u64::from(self.index)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            Some((index, count)) if count > 0 => {
                Err(format!("there is no part {index} of {count}; parts are 1 to {count}"))
            }
            _ => Err("write I/N, the part and the number of parts, such as 1/4".to_owned()),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shot_belongs_to_one_part() {
        for name in (0..200).map(|number| format!("shots/{number}")) {
            let parts = (1..=3).filter(|&index| Shard { index, count: 3 }.includes(&name));
            assert_eq!(parts.count(), 1, "{name}");
        }
        let all: Vec<u32> = (1..=3)
            .map(|index| {
                (0..3000).filter(|n| Shard { index, count: 3 }.includes(&n.to_string())).count() as u32
            })
            .collect();
        assert!(all.iter().all(|&count| (900..1100).contains(&count)), "{all:?}");
    }

    #[test]
    fn texts_are_parsed() {
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
        assert_eq!(Shard { index: 2, count: 3 }.to_string(), "2/3");
        for wrong in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
