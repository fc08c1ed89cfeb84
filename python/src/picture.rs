//! Pictures of models, as the tool draws them.

use pyo3::prelude::*;

#[pyfunction]
pub(crate) fn render() {}
