//! A template that is the shape itself without its detail.

use chladni_harmonics::Body;
use chladni_match::Correspondence;

use crate::CaricatureError;
use crate::difference::check_low_pass;

/// Each vertex ↔ itself with only the harmonics k < `k0` kept, where the constants of all pieces count as
/// one: exaggerating a shape against its own smooth version brings out its detail. `file_positions` are the n
/// positions of the file that `body` was made from.
///
/// # Errors
/// `k0` outside 1..=K, no harmonics but the constants of several pieces, or positions that are not those of the body.
pub fn self_low_passed(
    body: &Body,
    file_positions: &[[f64; 3]],
    k0: usize,
) -> Result<Correspondence, CaricatureError> {
    check_low_pass(k0, &body.basis)?;
    if file_positions.len() != body.operator_vertex.len() {
        let (found, expected) = (file_positions.len(), body.operator_vertex.len());
        return Err(CaricatureError::VertexCount { what: "the list of file positions", found, expected });
    }
    let mut coefficients = body.basis.transform3(&body.positions);
    coefficients.truncate(body.basis.harmonics_below(k0));
    let smooth = body.basis.synthesize3(&coefficients);
    let displacement: Vec<[f64; 3]> =
        smooth.iter().zip(&body.positions).map(|(s, x)| std::array::from_fn(|i| s[i] - x[i])).collect();
    let point = body.displaced_file_positions(file_positions, &displacement);
    let confidence = body.operator_vertex.iter().map(|v| f64::from(u8::from(v.is_some()))).collect();
    Ok(Correspondence::direct(point, confidence))
}
