//! Which Python exception each error of the engines becomes.

use chladni_caricature::CaricatureError;
use chladni_harmonics::HarmonicsError;
use chladni_match::MatchError;
use chladni_mesh::MeshError;
use chladni_task::Cancelled;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

pyo3::import_exception!(chladni._errors, FileError);
pyo3::import_exception!(chladni._errors, InputError);
pyo3::import_exception!(chladni._errors, InternalError);
pyo3::import_exception!(chladni._errors, MissingFileError);
pyo3::import_exception!(chladni._errors, NotCertifiedError);
pyo3::import_exception!(chladni._errors, RanksError);

/// Why a call has no result, on a thread that knows no Python.
#[derive(Debug)]
pub enum Failure {
    /// Input that cannot be computed with.
    Input(String),
    /// A result that did not pass its check.
    NotCertified(String),
    /// The ranks of SLEPc ended without a result.
    Ranks(String),
    /// A file could not be read or written.
    File(String),
    /// The engine is at fault.
    Internal(String),
    /// A signal or the progress callback stopped it.
    Cancelled,
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Input(reason) => InputError::new_err(reason),
            Failure::NotCertified(reason) => NotCertifiedError::new_err(reason),
            Failure::Ranks(reason) => RanksError::new_err(reason),
            Failure::File(reason) => FileError::new_err(reason),
            Failure::Internal(reason) => InternalError::new_err(reason),
            Failure::Cancelled => PyKeyboardInterrupt::new_err("cancelled"),
        }
    }
}

impl From<HarmonicsError> for Failure {
    fn from(error: HarmonicsError) -> Self {
        match error {
            HarmonicsError::Cancelled(Cancelled) => Self::Cancelled,
            HarmonicsError::NotCertified { .. } => Self::NotCertified(error.to_string()),
            HarmonicsError::RanksFailed { .. } => Self::Ranks(error.to_string()),
            HarmonicsError::Threads(_) => Self::Internal(error.to_string()),
            HarmonicsError::Stored { .. } => Self::File(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<MatchError> for Failure {
    fn from(error: MatchError) -> Self {
        match error {
            MatchError::Cancelled(_) => Self::Cancelled,
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<CaricatureError> for Failure {
    fn from(error: CaricatureError) -> Self {
        match error {
            CaricatureError::Cancelled(_) => Self::Cancelled,
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<chladni_music::MusicError> for Failure {
    fn from(error: chladni_music::MusicError) -> Self {
        match error {
            chladni_music::MusicError::Cancelled(_) => Self::Cancelled,
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        Self::File(error.to_string())
    }
}
