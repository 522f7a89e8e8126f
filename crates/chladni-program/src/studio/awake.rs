//! Keeps the screen awake with a program of the system, for as long as that program runs.

use std::process::{Child, Stdio};

use chladni_task::{Needs, other_program};

/// The program that holds off sleep while it runs, and its arguments.
const KEEPER: Option<(&str, &[&str])> = if cfg!(target_os = "linux") {
    let until_ended = &["--what=idle:sleep", "--who=Chladni", "--why=A dance is shown", "sleep", "86400"];
    Some(("systemd-inhibit", until_ended))
} else if cfg!(target_os = "macos") {
    Some(("caffeinate", &["-d", "-i"]))
} else {
    None
};

/// Asks the system not to let the screen sleep.
#[derive(Debug, Default)]
pub struct Awake {
    keeper: Option<Child>,
    wanted: bool,
    /// It was said that this cannot be done.
    was_said: bool,
}

impl Awake {
    /// Keeps it awake from now on, or no longer; says why that cannot be done, once.
    pub fn keep(&mut self, on: bool) -> Option<String> {
        if std::mem::replace(&mut self.wanted, on) == on {
            return None;
        }
        self.let_go();
        if !on {
            return None;
        }
        let why = self.begin()?;
        (!std::mem::replace(&mut self.was_said, true)).then(|| format!("The screen may go to sleep: {why}."))
    }

    /// Starts the program; why it cannot be started.
    fn begin(&mut self) -> Option<String> {
        let Some((program, arguments)) = KEEPER else {
            return Some("this system has no program that prevents it".into());
        };
        let silent = other_program(program, Needs::Desktop)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        match silent {
            Ok(keeper) => {
                self.keeper = Some(keeper);
                None
            }
            Err(why) => Some(format!("{program}: {why}")),
        }
    }

    fn let_go(&mut self) {
        if let Some(mut keeper) = self.keeper.take() {
            // It may have ended by itself.
            let _ = keeper.kill();
            let _ = keeper.wait();
        }
    }
}

impl Drop for Awake {
    fn drop(&mut self) {
        self.let_go();
    }
}
