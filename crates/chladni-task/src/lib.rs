//! Progress and cancellation of long work, files that are written whole or not at all, or by one program at a time,
//! files that are read whole up to a size limit, copies of unsaved work that outlive a crash, other programs that are
//! started, names in addresses and those that lead to other machines, numbers of things in words, and files of newer
//! programs.
//!
//! ```
//! use chladni_task::Task;
//!
//! let task = Task::new();
//! let stage = task.stage("summing", 10);
//! let mut sum = 0;
//! for i in 0..10 {
//!     task.check()?; // Err(Cancelled) as soon as somebody calls task.cancel()
//!     sum += i;
//!     stage.advance(1);
//! }
//! assert_eq!(sum, 45);
//! assert_eq!(task.progress().done, 10);
//! # Ok::<(), chladni_task::Cancelled>(())
//! ```
//!
//! Not guaranteed: the exact counts. Those of parallel workers may arrive in any order, and a stage may end
//! before it reaches its total.

#![warn(clippy::missing_errors_doc)]

mod alone;
mod atomic_file;
mod counted;
mod newer;
mod other_machine;
mod other_program;
mod percent;
mod progress;
mod read_file;
mod recovery;

pub use alone::alone;
pub use atomic_file::{
    Draft, advice_in, advised, create_folder, create_private_folder, folder_of, persist, persist_new,
    private_folder, temporary_beside, where_it_leads, write_atomic, write_atomic_private, write_atomic_with,
    write_new,
};
pub use counted::counted;
pub use newer::newer;
pub use other_machine::asks_another_machine;
pub use other_program::{Needs, apart, other_program};
pub use percent::percent_decoded;
pub use progress::{Cancelled, Progress, Stage, Task};
pub use read_file::{date_now, open_file, read_file, read_text_file};
pub use recovery::RecoveryCopy;

/// The examples of README.md, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
