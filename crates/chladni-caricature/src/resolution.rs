//! How finely a project's shape is worked on.

use serde::{Deserialize, Serialize};

/// How finely a project's shape is worked on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Resolution {
    /// As is usual: with each vertex of its file, unless there are very many.
    #[default]
    Usual,
    /// With each vertex of its file, however many there are.
    Whole,
    /// Through a [`Proxy`](chladni_mesh::Proxy).
    Proxy(ProxyKey),
}

/// Which proxy of a shape.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProxyKey {
    /// About how many vertices it has.
    pub vertices: usize,
    /// Distinguishes it from other proxies with as many vertices, since regions and landmarks name vertices by
    /// number; `None` until it was made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
}

impl ProxyKey {
    /// The fewest vertices that a proxy may be asked to have.
    pub const FEWEST: usize = 100;
}
