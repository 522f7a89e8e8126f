//! The rows of the papers' tables, and two more: n, K and S, and the rates that are published.

/// A shape of a table and the frame rates printed for it.
pub struct Row {
    /// As the paper names it.
    pub model: &'static str,
    /// n.
    pub vertices: usize,
    /// K.
    pub harmonics: usize,
    /// Items S and the printed frames per second.
    pub published: &'static [(usize, f64)],
}

const fn music(
    model: &'static str,
    vertices: usize,
    harmonics: usize,
    published: &'static [(usize, f64)],
) -> Row {
    Row { model, vertices, harmonics, published }
}

/// Music paper (2012), table of frame rates at 1024×768: S = 1 on its CPU, S = 6 and 12 on its
/// GPU. Caricature paper (2010): 8.5 to 12.1 fps with three models at 30k to 50k vertices; the
/// better is set against the smaller. The last two are of no paper: n and K at which a processor's
/// kernels were tried before ours were written.
pub const ROWS: &[Row] = &[
    music("heart", 622, 256, &[(1, 99.7), (6, 322.1), (12, 203.7)]),
    music("eight", 766, 256, &[(1, 97.7), (6, 342.1), (12, 213.7)]),
    music("duck", 2108, 256, &[(1, 52.7), (6, 208.3), (12, 123.9)]),
    music("spring", 4695, 256, &[(1, 12.7), (6, 71.4), (12, 41.4)]),
    music("dinosaur", 14054, 533, &[(1, 4.7), (6, 28.3), (12, 13.9)]),
    music("octa", 15136, 529, &[(1, 4.1), (6, 26.8), (12, 13.2)]),
    music("octopus", 20351, 546, &[(1, 3.0), (6, 21.4), (12, 7.1)]),
    music("alien", 24988, 540, &[(1, 3.4), (6, 22.4), (12, 12.1)]),
    music("david", 24988, 804, &[(1, 2.6), (6, 14.8), (12, 7.3)]),
    music("cat", 30059, 271, &[(1, 9.6), (6, 45.7), (12, 23.0)]),
    music("gargoyle", 30059, 1052, &[(1, 2.1), (6, 13.7), (12, 6.9)]),
    music("bunny", 34834, 1070, &[(1, 1.7), (6, 12.1), (12, 5.8)]),
    music("buste", 37874, 1075, &[(1, 1.5), (6, 13.4), (12, 3.4)]),
    music("blooby", 42432, 1065, &[(1, 1.5), (6, 12.5), (12, 7.5)]),
    music("egea", 63739, 275, &[(1, 0.9), (6, 7.2), (12, 3.2)]),
    music("head", 65002, 1607, &[(1, 0.5), (6, 8.7), (12, 4.3)]),
    music("armadillo", 86488, 2376, &[(1, 0.2), (6, 10.3), (12, 3.4)]),
    music("cow", 97803, 256, &[(1, 0.1), (6, 9.1), (12, 3.1)]),
    music("caricature-30k", 30000, 512, &[(3, 12.1)]),
    music("caricature-50k", 50000, 512, &[(1, f64::NAN), (3, 8.5), (6, f64::NAN), (12, f64::NAN)]),
    music("trial-512", 50176, 512, &[(12, f64::NAN)]),
    music("trial-1008", 50176, 1008, &[(12, f64::NAN)]),
];
