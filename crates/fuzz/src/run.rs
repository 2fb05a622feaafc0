//! Runs a program within limits.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::Error;

/// Address space of a program, KiB: 4 GB.
const MEMORY_KIB: u64 = 4 * 1024 * 1024;
/// Time by the clock for each second of processor time, for a program that waits and does nothing.
const WAITING: u64 = 3;
/// The signal by which the system ends a program over its processor time.
const OVER_TIME: i32 = 24;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Code(i32),
    Signal(i32),
    Hang,
}

#[derive(Clone, Debug)]
pub struct Ended {
    pub end: End,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

/// Runs a program in a folder. What it writes to its streams goes to `logs`, another folder.
pub fn run(
    program: &Path,
    arguments: &[String],
    (folder, logs): (&Path, &Path),
    stdin: Option<&Path>,
    processor_s: u64,
) -> Result<Ended, Error> {
    let (stdout, stderr) = (logs.join("stdout"), logs.join("stderr"));
    let create = |path: &Path| File::create(path).map_err(|e| Error::file(path, "written", e));
    let stdin = match stdin {
        Some(path) => File::open(path).map_err(|e| Error::file(path, "read", e))?.into(),
        None => Stdio::null(),
    };
    let limited = format!("ulimit -c 0; ulimit -v {MEMORY_KIB}; ulimit -S -t {processor_s}; exec \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, "sh"])
        .arg(program)
        .args(arguments)
        .current_dir(folder)
        // As many cases as there are cores run side by side; two threads each leave nothing of the parallel
        // code out.
        .env("RAYON_NUM_THREADS", "2")
        .stdin(stdin)
        .stdout(create(&stdout)?)
        .stderr(create(&stderr)?)
        .spawn()
        .map_err(|e| Error::file(program, "run", e))?;
    let (begun, clock) = (Instant::now(), Duration::from_secs(WAITING * processor_s));
    let mut pause = Duration::from_micros(500);
    let end = loop {
        match child.try_wait().map_err(|e| Error::file(program, "run", e))? {
            Some(status) => break end(status),
            None if begun.elapsed() > clock => {
                // `sh` has become the program, so that this ends it.
                child.kill().and_then(|()| child.wait()).map_err(|e| Error::file(program, "run", e))?;
                break End::Hang;
            }
            None => std::thread::sleep(pause),
        }
        pause = (pause * 2).min(Duration::from_millis(20));
    };
    let read = |path: &Path| fs::read(path).map_err(|e| Error::file(path, "read", e));
    Ok(Ended { end, stdout: read(&stdout)?, stderr: String::from_utf8_lossy(&read(&stderr)?).into_owned() })
}

fn end(status: ExitStatus) -> End {
    match (status.code(), signal(status)) {
        (Some(code), _) => End::Code(code),
        (None, Some(OVER_TIME)) => End::Hang,
        (None, signal) => End::Signal(signal.unwrap_or_default()),
    }
}

#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal(_: ExitStatus) -> Option<i32> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn ended(script: &str) -> Ended {
        let folder = tempfile::tempdir().expect("a folder");
        let arguments = ["-c".to_string(), script.to_string()];
        run(Path::new("sh"), &arguments, (folder.path(), folder.path()), None, 60).expect("run")
    }

    #[test]
    fn ends_are_told_apart() {
        let done = ended("echo out; echo said >&2; exit 3");
        assert_eq!((done.end, &done.stdout[..], &done.stderr[..]), (End::Code(3), &b"out\n"[..], "said\n"));
        assert_eq!(ended("kill -6 $$").end, End::Signal(6));
        assert_eq!(ended("kill -24 $$").end, End::Hang);
    }
}
