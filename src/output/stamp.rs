//! Stamp of when and where a frame was rendered.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::image_file::RunStamp;

/// Stamp of a frame that took `render_seconds` and is finished now.
pub fn run_stamp(render_seconds: f64) -> RunStamp {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    RunStamp {
        capture_date: universal_time(since_epoch),
        host: host_name(),
        render_seconds: render_seconds as f32,
    }
}

/// Name of the machine, from Linux or else from the environment.
pub(crate) fn host_name() -> Option<String> {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = name.or_else(|| std::env::var("HOSTNAME").or_else(|_| std::env::var("COMPUTERNAME")).ok())?;
    let name = name.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

/// Date and time of now, such as `2026-11-21 18:57:00`.
pub(crate) fn universal_time_now() -> String {
    let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    universal_time(since_epoch).replacen(':', "-", 2)
}

/// Date and time, such as `2026:11:21 18:57:00`.
fn universal_time(since_epoch: Duration) -> String {
    let seconds = since_epoch.as_secs();
    let (days, second) = (seconds / 86400, seconds % 86400);
    let (year, month, day) = date(days);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}:{month:02}:{day:02} {hour:02}:{minute:02}:{second:02}")
}

/// Gregorian date of a number of days after 1 January 1970: year, month and day.
///
/// Years are counted from March, so that the leap day is their last (Howard Hinnant, "chrono-compatible low-level date
/// algorithms", 2013).
fn date(days_since_epoch: u64) -> (u64, u64, u64) {
    const DAYS_A_CYCLE: u64 = 146_097;
    const FROM_YEAR_0_TO_EPOCH: u64 = 719_468;
    let days = days_since_epoch + FROM_YEAR_0_TO_EPOCH;
    let (cycle, day_of_cycle) = (days / DAYS_A_CYCLE, days % DAYS_A_CYCLE);
    let leap_days = day_of_cycle / 1460 - day_of_cycle / 36524 + day_of_cycle / 146_096;
    let year_of_cycle = (day_of_cycle - leap_days) / 365;
    let day_of_year = day_of_cycle - (365 * year_of_cycle + year_of_cycle / 4 - year_of_cycle / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = cycle * 400 + year_of_cycle + u64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_follow_the_calendar() {
        let text = |seconds| universal_time(Duration::from_secs(seconds));
        assert_eq!(text(0), "1970:01:01 00:00:00");
        // `date -u -d @SECONDS`: a leap day of a century, the last second of a year, a day after.
        assert_eq!(text(951_782_400), "2000:02:29 00:00:00");
        assert_eq!(text(1_767_225_599), "2025:12:31 23:59:59");
        assert_eq!(text(4_107_542_400), "2100:03:01 00:00:00");
    }

    #[test]
    fn days_are_consecutive() {
        let mut last = date(0);
        for day in 1..60_000 {
            let next = date(day);
            let follows = (next.0, next.1, next.2) == (last.0, last.1, last.2 + 1)
                || next.2 == 1 && (next.1 == last.1 + 1 || (last.1, next.1, next.0) == (12, 1, last.0 + 1));
            assert!(follows, "{last:?} {next:?}");
            last = next;
        }
    }
}
