//! The engines from Python: numpy arrays in, numpy arrays out. The engines do all computations; here are only
//! conversions, exceptions, and the thread that waits for signals. The names that users see are in `chladni/`.

mod arrays;
mod basis;
mod failure;
mod functional_map;
mod geodesic;
mod instruments;
mod matching;
mod spectrum;
mod stored;
mod work;

use pyo3::prelude::*;

#[pymodule]
mod _chladni {
    #[pymodule_export]
    use crate::basis::{Basis, Certificate, restored_certificate};
    #[pymodule_export]
    use crate::functional_map::{fm_to_p2p, p2p_to_fm, zoomout};
    #[pymodule_export]
    use crate::geodesic::HeatGeodesics;
    #[pymodule_export]
    use crate::instruments::{caricature, read_mesh, symmetry, write_mesh};
    #[pymodule_export]
    use crate::matching::match_meshes;
    #[pymodule_export]
    use crate::spectrum::{eigsh, mesh_laplacian, point_cloud_laplacian};
    #[pymodule_export]
    use crate::stored::StoredBasis;
}
