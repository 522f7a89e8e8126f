//! The affine maps of glTF nodes.

use super::gltf_json::Node;

/// A column-major affine map.
pub(crate) type Matrix = [[f64; 4]; 4];

pub(super) const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// First `b`, then `a`.
pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|c| std::array::from_fn(|r| (0..4).map(|k| a[k][r] * b[c][k]).sum()))
}

/// Where `m` takes a point.
pub(super) fn moved(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r])
}

/// Whether it turns a left hand into a right one.
pub(super) fn mirrors(m: &Matrix) -> bool {
    let [a, b, c, _] = m;
    let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
        + c[0] * (a[1] * b[2] - a[2] * b[1]);
    det < 0.0
}

/// The map whose columns a file lists, one after the other.
pub(super) fn from_columns(m: &[f64; 16]) -> Matrix {
    std::array::from_fn(|c| std::array::from_fn(|r| m[4 * c + r]))
}

/// From a node to its parent.
pub(super) fn local_matrix(node: &Node) -> Matrix {
    if let Some(m) = &node.matrix {
        return from_columns(m);
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let s = node.scale.unwrap_or([1.0; 3]);
    let t = node.translation.unwrap_or([0.0; 3]);
    let columns = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let column = |c: usize| [columns[c][0] * s[c], columns[c][1] * s[c], columns[c][2] * s[c], 0.0];
    [column(0), column(1), column(2), [t[0], t[1], t[2], 1.0]]
}
