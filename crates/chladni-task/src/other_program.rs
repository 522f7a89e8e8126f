//! Programs that this one starts: each gets the environment variables that it needs, and no others.
//!
//! Variables can make a program write files (`FFREPORT`), load code or reach other machines.
//! Settings that a user made for a shell were not meant for a program started by this one.

use std::ffi::{OsStr, OsString};
use std::process::Command;

/// The part of the environment that a program gets, besides the search path, the home folder and the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Files and pipes: an encoder.
    Files,
    /// The sound server and the services of a desktop.
    Desktop,
    /// The desktop and a graphics device: ourselves, with another window.
    Window,
    /// The other processes of MPI, on this machine and others.
    Ranks,
}

/// Variables that any program may need. A name that ends in `*` means all that begin so.
const ALL: &[&str] = &[
    "PATH",
    "HOME",
    "USER",
    "LOGNAME",
    "LANG",
    "LANGUAGE",
    "LC_*",
    "TZ",
    "TMPDIR",
    "LD_LIBRARY_PATH",
    "DYLD_LIBRARY_PATH",
    "DYLD_FALLBACK_LIBRARY_PATH",
];

/// On Windows, variables without which no program starts, and the paths of system folders.
const WINDOWS: &[&str] = &[
    "SYSTEMROOT",
    "SYSTEMDRIVE",
    "WINDIR",
    "COMSPEC",
    "PATHEXT",
    "TEMP",
    "TMP",
    "USERNAME",
    "USERPROFILE",
    "HOMEDRIVE",
    "HOMEPATH",
    "APPDATA",
    "LOCALAPPDATA",
    "PROGRAMDATA",
    "PROGRAMFILES*",
    "COMMONPROGRAMFILES*",
    "NUMBER_OF_PROCESSORS",
    "PROCESSOR_*",
    "MSMPI_*",
];

/// Where a desktop and its sound server are found. `GST_PLUGIN_*` says where GStreamer's parts are installed.
const DESKTOP: &[&str] = &[
    "XDG_*",
    "DBUS_SESSION_BUS_ADDRESS",
    "DISPLAY",
    "WAYLAND_DISPLAY",
    "XAUTHORITY",
    "PULSE_*",
    "PIPEWIRE_*",
    "SPA_PLUGIN_DIR",
    "GST_PLUGIN_*",
];

/// The graphics device, and the setup of keyboard and pointer.
const WINDOW: &[&str] = &[
    "CHLADNI_*",
    "WGPU_*",
    "WINIT_*",
    "VK_*",
    "MESA_*",
    "LIBGL_*",
    "GALLIUM_*",
    "LP_NUM_THREADS",
    "__EGL_*",
    "__GLX_*",
    "__NV_*",
    "DRI_PRIME",
    "XCURSOR_*",
    "XKB_*",
    "XMODIFIERS",
];

/// How the kinds of MPI, the queues of clusters, and the libraries below SLEPc are set up, and the way to other hosts.
const RANKS: &[&str] = &[
    "CHLADNI_*",
    "OMPI_*",
    "OPAL_*",
    "PMIX_*",
    "PRTE_*",
    "PMI_*",
    "HYDRA_*",
    "MPICH_*",
    "MPIR_*",
    "I_MPI_*",
    "FI_*",
    "UCX_*",
    "SLURM_*",
    "PBS_*",
    "LSB_*",
    "PE_HOSTFILE",
    "OMP_*",
    "OPENBLAS_*",
    "MKL_*",
    "PETSC_*",
    "SLEPC_*",
    "PYTHONPATH",
    "PYTHONHOME",
    "VIRTUAL_ENV",
    "CONDA_PREFIX",
    "SSH_AUTH_SOCK",
    "KRB5CCNAME",
];

/// Variables that say that this process is itself a rank of MPI: an `mpirun` started it, or it has initialized MPI.
const OF_A_RANK: &[&str] = &["PMIX_NAMESPACE", "OMPI_COMM_WORLD_RANK"];

/// Those that describe the job of such a rank: an `mpirun` that has them takes itself for a part of it, and fails.
const OF_ITS_JOB: &[&str] = &[
    "PMIX_*",
    "OMPI_COMM_WORLD_*",
    "OMPI_MCA_ess*",
    "OMPI_MCA_pmix",
    "OMPI_MCA_orte_*",
    "OMPI_UNIVERSE*",
    "OMPI_APP*",
];

/// Whether `name` is one of `known`, or begins as one of those that end in `*`.
fn is_among(name: &str, known: &[&str]) -> bool {
    known.iter().any(|known| match known.strip_suffix('*') {
        Some(beginning) => name.starts_with(beginning),
        None => name == *known,
    })
}

impl Needs {
    fn lists(self) -> &'static [&'static [&'static str]] {
        match self {
            Self::Files => &[ALL],
            Self::Desktop => &[ALL, DESKTOP],
            Self::Window => &[ALL, DESKTOP, WINDOW],
            Self::Ranks => &[ALL, RANKS],
        }
    }

    /// Whether a program gets a variable of this name, where this process is a rank or is none.
    fn include(self, name: &OsStr, in_a_rank: bool) -> bool {
        let Some(name) = name.to_str() else { return false };
        // Windows takes names in any case for the same.
        let name = if cfg!(windows) { name.to_ascii_uppercase() } else { name.to_owned() };
        let system: &[&str] = if cfg!(windows) { WINDOWS } else { &[] };
        self.lists().iter().chain([&system]).any(|known| is_among(&name, known))
            && !(in_a_rank && is_among(&name, OF_ITS_JOB))
    }
}

/// A command for another program, with what it needs of our environment. Every program that we start is started by this.
/// One that needs files only is [`apart`].
pub fn other_program(name: impl AsRef<OsStr>, needs: Needs) -> Command {
    let mut command = with_variables(name.as_ref(), needs, std::env::vars_os());
    if needs == Needs::Files {
        apart(&mut command);
    }
    command
}

/// Starts a program in a process group of its own (on Unix): Ctrl-C, which a terminal sends to the whole group, would end
/// an encoder before we have given it the rest. One that reads from us or writes to us ends when we do, one that makes a
/// file of files when that is done.
pub fn apart(command: &mut Command) {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    #[cfg(not(unix))]
    let _ = command;
}

fn with_variables(
    name: &OsStr,
    needs: Needs,
    variables: impl Iterator<Item = (OsString, OsString)>,
) -> Command {
    let variables: Vec<(OsString, OsString)> = variables.collect();
    let in_a_rank =
        variables.iter().any(|(name, _)| name.to_str().is_some_and(|name| is_among(name, OF_A_RANK)));
    let mut command = Command::new(name);
    command.env_clear().envs(variables.into_iter().filter(|(name, _)| needs.include(name, in_a_rank)));
    command
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a panic is how a test fails")]
mod tests {
    use super::*;

    /// The names of the variables that a program is started with, as it says itself.
    fn given(needs: Needs, set: &[&str]) -> Vec<String> {
        let path = std::env::var_os("PATH").unwrap();
        let variables = set.iter().map(|name| (OsString::from(*name), OsString::from("1")));
        let variables = variables.chain([("PATH".into(), path)]);
        let output = with_variables(OsStr::new("env"), needs, variables).output().unwrap();
        let mut names: Vec<String> = String::from_utf8(output.stdout)
            .unwrap()
            .lines()
            .map(|line| line.split('=').next().unwrap().to_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_program_gets_what_it_needs_and_nothing_else() {
        let set = [
            "FFREPORT",
            "LD_PRELOAD",
            "BASH_ENV",
            "AWS_SECRET_ACCESS_KEY",
            "PYTHONSTARTUP",
            "GST_DEBUG_FILE",
            "HTTP_PROXY",
            "LC_ALL",
            "HOME",
            "PULSE_SERVER",
            "OMPI_MCA_btl",
            "WGPU_BACKEND",
            "PATHS",
        ];
        assert_eq!(given(Needs::Files, &set), ["HOME", "LC_ALL", "PATH"]);
        assert_eq!(given(Needs::Desktop, &set), ["HOME", "LC_ALL", "PATH", "PULSE_SERVER"]);
        assert_eq!(given(Needs::Window, &set), ["HOME", "LC_ALL", "PATH", "PULSE_SERVER", "WGPU_BACKEND"]);
        assert_eq!(given(Needs::Ranks, &set), ["HOME", "LC_ALL", "OMPI_MCA_btl", "PATH"]);
    }

    #[test]
    fn ranks_do_not_join_the_job_that_this_process_is_a_rank_of() {
        let set = ["PMIX_RANK", "OMPI_MCA_ess_base_jobid", "OMPI_MCA_btl", "OMPI_MCA_orte_top_session_dir"];
        let all =
            ["OMPI_MCA_btl", "OMPI_MCA_ess_base_jobid", "OMPI_MCA_orte_top_session_dir", "PATH", "PMIX_RANK"];
        assert_eq!(given(Needs::Ranks, &set), all);
        for of_a_rank in OF_A_RANK {
            let set = [&set[..], &[*of_a_rank]].concat();
            assert_eq!(given(Needs::Ranks, &set), ["OMPI_MCA_btl", "PATH"]);
        }
    }

    /// Process and process group, from the text of `/proc/…/stat`.
    #[cfg(target_os = "linux")]
    fn process_and_group(stat: &str) -> (u32, u32) {
        let numbers: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        (stat.split_whitespace().next().unwrap().parse().unwrap(), numbers[2].parse().unwrap())
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_encoder_does_not_get_what_a_terminal_sends_to_us() {
        let (_, ours) = process_and_group(&std::fs::read_to_string("/proc/self/stat").unwrap());
        let started = |needs| {
            let output = other_program("cat", needs).arg("/proc/self/stat").output().unwrap();
            process_and_group(&String::from_utf8(output.stdout).unwrap())
        };
        let (process, group) = started(Needs::Files);
        assert!(group == process && group != ours);
        // Those that have no pipe with us end as we do.
        for needs in [Needs::Desktop, Needs::Window, Needs::Ranks] {
            assert_eq!(started(needs).1, ours, "{needs:?}");
        }
    }
}
