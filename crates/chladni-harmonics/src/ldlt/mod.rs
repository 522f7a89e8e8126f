//! Sparse L D Lᵀ factorization of A − σI for many shifts of one matrix: ordered and analyzed once, factored
//! by the multifrontal method, solved for blocks of right-hand sides.

mod factor;
mod front;
mod ordering;
mod panel;
mod separator;
mod solve;
mod solve_one;
mod symbolic;

pub(crate) use factor::{Factor, Workspace};
pub(crate) use front::ZeroPivot;
pub(crate) use ordering::nested_dissection;
pub(crate) use solve::Row;
pub(crate) use symbolic::Symbolic;

#[cfg(test)]
mod tests;
