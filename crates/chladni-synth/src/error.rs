//! The errors of this crate.

/// Why a model could not be built or a frame could not be synthesized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SynthError {
    /// The basis is not N×K for the N positions given.
    #[error("the basis has {found} values, which is not a whole number of harmonics of {vertices} vertices")]
    BasisShape {
        /// N.
        vertices: usize,
        /// The number of values.
        found: usize,
    },
    /// A number from which the model is built is NaN or infinite.
    #[error("{what} {index} is NaN or infinite")]
    NotFinite {
        /// "rest position" or "harmonic".
        what: &'static str,
        /// Its index.
        index: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    TriangleCorner {
        /// Index of the triangle.
        triangle: usize,
        /// The index of the vertex.
        vertex: u32,
        /// N.
        vertices: usize,
    },
    /// More coefficients than harmonics.
    #[error("item {item}, term {term}: {found} coefficients, but there are {harmonics} harmonics")]
    TooManyCoefficients {
        /// Index of the item.
        item: usize,
        /// Index of the term in the item.
        term: usize,
        /// The number of coefficients.
        found: usize,
        /// K.
        harmonics: usize,
    },
    /// A coefficient or gain is NaN or infinite.
    #[error("item {item}, term {term}: the {what} is NaN or infinite")]
    WeightNotFinite {
        /// Index of the item.
        item: usize,
        /// Index of the term in the item.
        term: usize,
        /// "coefficient of harmonic k" or "residual gain".
        what: String,
    },
    /// A mask or residual does not have one value per vertex.
    #[error("item {item}, term {term}: the {what} has {found} values, but there are {vertices} vertices")]
    SignalLength {
        /// Index of the item.
        item: usize,
        /// Index of the term in the item.
        term: usize,
        /// "mask" or "residual".
        what: &'static str,
        /// The number of values.
        found: usize,
        /// N.
        vertices: usize,
    },
    /// A vector residual with normal coefficients, or the reverse.
    #[error("item {item}, term {term}: the residual is not of the coefficients' form")]
    MixedForms {
        /// Index of the item.
        item: usize,
        /// Index of the term in the item.
        term: usize,
    },
    /// Normal blending outside [0, 1].
    #[error("normal blending is {0}, but must lie in [0, 1]")]
    NormalBlending(f32),
    /// More vertices or items than 32-bit indices can address.
    #[error("{items} items of {vertices} vertices are too many for 32-bit indices")]
    TooLarge {
        /// S.
        items: usize,
        /// N.
        vertices: usize,
    },
    /// A buffer would exceed the limits of the graphics device.
    #[error("the {what} takes {needed} bytes, but a buffer of this graphics device holds {limit}")]
    DeviceLimit {
        /// The content of the buffer.
        what: &'static str,
        /// Bytes needed.
        needed: u64,
        /// The largest size of a buffer, in bytes.
        limit: u64,
    },
    /// The graphics device does not work.
    #[error("the graphics device cannot be used: {0}")]
    Device(String),
}

impl SynthError {
    /// Whether the graphics device is at fault, rather than the request.
    pub fn is_of_device(&self) -> bool {
        matches!(self, Self::DeviceLimit { .. } | Self::Device(_))
    }
}
