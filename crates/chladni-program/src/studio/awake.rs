//! Keeps the screen awake with a program of the system, for as long as that program runs.

use std::process::{Child, Stdio};

use chladni_task::{Needs, other_program};

/// The program that holds off sleep while another one runs, and its arguments. That one, `cat`, ends with its input, which the
/// system closes when we end, however that comes.
const KEEPER: Option<(&str, &[&str])> = if cfg!(target_os = "linux") {
    Some(("systemd-inhibit", &["--what=idle:sleep", "--who=Chladni", "--why=A dance is shown", "cat"]))
} else if cfg!(target_os = "macos") {
    Some(("caffeinate", &["-d", "-i", "cat"]))
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
        let why = if std::mem::replace(&mut self.wanted, on) == on {
            self.ended()?
        } else {
            self.let_go();
            if !on {
                return None;
            }
            self.begin()?
        };
        (!std::mem::replace(&mut self.was_said, true)).then(|| format!("The screen may go to sleep: {why}."))
    }

    /// Starts the program; why it cannot be started.
    fn begin(&mut self) -> Option<String> {
        let Some((program, arguments)) = KEEPER else {
            return Some("this system has no program that prevents it".into());
        };
        let silent = other_program(program, Needs::Desktop)
            .args(arguments)
            .stdin(Stdio::piped())
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

    /// How the program has ended by itself, where it has: it does so where there is nobody to ask.
    fn ended(&mut self) -> Option<String> {
        let status = self.keeper.as_mut()?.try_wait().ok()??;
        self.keeper = None;
        KEEPER.map(|(program, _)| format!("{program} ended ({status})"))
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_keeper_that_ends_by_itself_is_said_once() {
        let Some((program, _)) = KEEPER else { return };
        let mut gone = other_program("false", Needs::Desktop).spawn().unwrap();
        gone.wait().unwrap();
        let mut awake = Awake { keeper: Some(gone), wanted: true, was_said: false };
        let why = awake.keep(true).unwrap();
        assert!(why.contains(program) && why.ends_with("ended (exit status: 1)."), "{why}");
        assert_eq!([awake.keep(true), awake.keep(false)], [None, None]);
    }

    #[test]
    fn what_keeps_the_screen_awake_ends_with_us() {
        let Some((_, arguments)) = KEEPER else { return };
        let until = arguments.iter().position(|argument| !argument.starts_with('-')).unwrap();
        let mut command = other_program(arguments[until], Needs::Desktop);
        let mut kept = command.args(&arguments[until + 1..]).stdin(Stdio::piped()).spawn().unwrap();
        assert!(kept.try_wait().unwrap().is_none());
        // As the system does when we are killed.
        drop(kept.stdin.take());
        let began = Instant::now();
        while kept.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < chladni_testdata::HANGS, "it would keep the screen awake for ever");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
}
