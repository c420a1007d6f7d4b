//! Default memory limit: four fifths of the memory of the machine, the control group or the
//! shell.

use std::fs;
use std::path::{Path, PathBuf};

use crate::settings::SettingValues;

/// Limit for systems without this information, bytes.
const FALLBACK: u64 = 4 << 30;

/// The limit of the settings, bytes.
pub(super) fn max_memory_bytes(values: &SettingValues) -> u64 {
    values.max_memory.unwrap_or_else(default_max_memory_bytes)
}

/// Four fifths of the least of all limits.
pub fn default_max_memory_bytes() -> u64 {
    let limits = [
        physical_bytes(&read("/proc/meminfo")),
        control_group_bytes(&read("/proc/self/cgroup"), Path::new("/sys/fs/cgroup")),
        address_space_bytes(&read("/proc/self/limits"), &read("/proc/self/status")),
    ];
    limits.into_iter().flatten().min().unwrap_or(FALLBACK) / 5 * 4
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// `MemTotal` of `/proc/meminfo`.
fn physical_bytes(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

/// Remaining address space under `ulimit -v`, from `/proc/self/limits` and `/proc/self/status`.
fn address_space_bytes(limits: &str, status: &str) -> Option<u64> {
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = limit.split_whitespace().next()?.parse().ok()?;
    let used = status.lines().find_map(|line| line.strip_prefix("VmSize:"));
    let used: u64 = used.and_then(|used| used.split_whitespace().next()?.parse().ok()).unwrap_or(0);
    Some(limit.saturating_sub(used * 1024))
}

/// The least limit of this process's control group and those around it, version 2 (`memory.max`) or 1.
fn control_group_bytes(memberships: &str, mount: &Path) -> Option<u64> {
    let mut least = None;
    for line in memberships.lines() {
        // hierarchy : controllers : path
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (fields.next(), fields.next()) else {
            continue;
        };
        let (root, file) = if controllers.is_empty() {
            (mount.to_owned(), "memory.max")
        } else if controllers.split(',').any(|controller| controller == "memory") {
            (mount.join("memory"), "memory.limit_in_bytes")
        } else {
            continue;
        };
        // In a container the path is often the host's; the mount itself then is the group.
        let mut folder: PathBuf = root.join(group.trim_start_matches('/'));
        while folder.starts_with(&root) {
            let limit = fs::read_to_string(folder.join(file)).ok();
            let limit = limit.and_then(|text| text.trim().parse::<u64>().ok());
            least = [least, limit].into_iter().flatten().min();
            if !folder.pop() {
                break;
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_limit_around_the_group_counts() {
        let mount = tempfile::tempdir().unwrap();
        let inner = mount.path().join("farm/job");
        fs::create_dir_all(&inner).unwrap();
        fs::write(inner.join("memory.max"), "max\n").unwrap();
        fs::write(mount.path().join("farm/memory.max"), "1000000\n").unwrap();
        assert_eq!(control_group_bytes("0::/farm/job\n", mount.path()), Some(1_000_000));
        assert_eq!(control_group_bytes("0::/\n", mount.path()), None);
        assert_eq!(control_group_bytes("", mount.path()), None);
    }

    #[test]
    fn version_1_groups_are_found_under_their_controller() {
        let mount = tempfile::tempdir().unwrap();
        fs::create_dir_all(mount.path().join("memory/job")).unwrap();
        fs::write(mount.path().join("memory/job/memory.limit_in_bytes"), "31457280\n").unwrap();
        let memberships = "5:cpu,cpuacct:/x\n4:memory:/job\n";
        assert_eq!(control_group_bytes(memberships, mount.path()), Some(31_457_280));
    }

    #[test]
    fn the_address_space_limit_counts() {
        let limits = "Max locked memory         8388608   8388608   bytes\n\
                      Max address space         100000000 unlimited bytes\n";
        assert_eq!(address_space_bytes(limits, "VmSize:\t   10000 kB\n"), Some(89_760_000));
        assert_eq!(address_space_bytes(limits, "VmSize: 1000000 kB"), Some(0));
        let unlimited = "Max address space         unlimited            unlimited            bytes";
        assert_eq!(address_space_bytes(unlimited, "VmSize: 1 kB"), None);
    }

    #[test]
    fn the_memory_of_the_machine_is_read() {
        assert_eq!(physical_bytes("MemTotal:       24000000 kB\nMemFree: 1 kB"), Some(24_576_000_000));
        assert_eq!(physical_bytes(""), None);
    }
}
