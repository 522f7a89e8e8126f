//! Where solved bases are kept.

use chladni_harmonics::BasisCache;

/// The folder named by `CHLADNI_CACHE`, else the user's own cache folder; `None`, and nothing
/// is kept, where there is neither.
pub fn basis_cache() -> Option<BasisCache> {
    match std::env::var_os("CHLADNI_CACHE") {
        Some(folder) if !folder.is_empty() => Some(BasisCache::new(folder)),
        _ => BasisCache::of_user(),
    }
}
