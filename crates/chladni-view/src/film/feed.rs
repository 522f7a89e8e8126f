//! A program that reads from us on standard input, and its error messages.

use std::io::{Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

/// This much of a program's standard error is kept.
const MOST_COMPLAINTS: u64 = 64 << 10;

/// A running program. Dropped, it is ended.
#[derive(Debug)]
pub(super) struct Feed {
    child: Child,
    input: Option<ChildStdin>,
    complaints: Option<JoinHandle<String>>,
}

impl Feed {
    pub(super) fn start(command: &mut Command) -> std::io::Result<Self> {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
        let (input, stderr) = (child.stdin.take(), child.stderr.take());
        let mut feed = Self { child, input, complaints: None };
        if let Some(mut stderr) = stderr {
            let read = move || {
                let mut text = Vec::new();
                // A message that cannot be read cannot be reported; the exit status still is.
                let _ = stderr.by_ref().take(MOST_COMPLAINTS).read_to_end(&mut text);
                let _ = std::io::copy(&mut stderr, &mut std::io::sink());
                String::from_utf8_lossy(&text).into_owned()
            };
            feed.complaints = Some(std::thread::Builder::new().spawn(read)?);
        }
        Ok(feed)
    }

    /// Writes to it. If it takes no more, the error is the program's message.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some(input) = &mut self.input else { return Err(self.complaint("it takes no more frames")) };
        let written = input.write_all(bytes);
        written.map_err(|why| self.complaint(&why.to_string()))
    }

    /// Its standard input, for another thread to write; the program ends when that is dropped.
    pub(super) fn take_input(&mut self) -> Option<ChildStdin> {
        self.input.take()
    }

    /// Closes its input and waits until it ends.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        self.input = None;
        let status = self.child.wait().map_err(|why| why.to_string())?;
        if status.success() { Ok(()) } else { Err(self.complaint(&status.to_string())) }
    }

    /// Ends it.
    pub(super) fn end(&mut self) {
        self.input = None;
        // Nothing to do for one that has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Ends it and returns its message as one line, or `otherwise` if it said nothing.
    pub(super) fn complaint(&mut self, otherwise: &str) -> String {
        self.end();
        let text = self.complaints.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        let line = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
        if line.is_empty() { otherwise.to_owned() } else { line }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.end();
    }
}
