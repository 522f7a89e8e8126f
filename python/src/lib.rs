//! The engines from Python.
use pyo3::prelude::*;
#[pymodule]
fn _chladni(_module: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
