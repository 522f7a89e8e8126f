//! Bringing project files of older formats up to date.

use std::path::Path;

use toml::{Table, Value};

use crate::project::DEFAULT_HARMONICS;
use crate::scale_curve::monotone;
use crate::{CaricatureError, ScaleCurve, usual_wavelength};

/// The newest format; only projects with an unusual resolution are written in it.
pub const FORMAT_VERSION: i64 = 5;
/// The format of all others, so that older programs read them.
pub(crate) const USUAL_VERSION: i64 = 4;

/// `table` in the current format with the number of the older one it was in, or `None` where it is current
/// already.
pub(crate) fn migrate(mut table: Table, path: &Path) -> Result<Option<(Table, i64)>, CaricatureError> {
    let invalid = |why: &str| CaricatureError::ProjectFile { path: path.into(), why: why.to_owned() };
    let Some(version) = table.get("format_version").and_then(Value::as_integer) else {
        return Err(invalid("names no format_version; it is not a Chladni project"));
    };
    match version {
        // Format 3 could not keep triangles, and 4 had no proxies; missing keys mean that these are off.
        3 | USUAL_VERSION | FORMAT_VERSION => return Ok(None),
        1 => {
            from_1_to_2(&mut table);
            from_2_to_3(&mut table);
        }
        2 => from_2_to_3(&mut table),
        found if found > FORMAT_VERSION => {
            return Err(CaricatureError::NewerFormat { path: path.into(), found, supported: FORMAT_VERSION });
        }
        _ => return Err(invalid(&format!("has format version {version}, which never existed"))),
    }
    table.insert("format_version".into(), Value::Integer(FORMAT_VERSION));
    Ok(Some((table, version)))
}

/// In format 1 the shape was a single key, and a layer's region and scale curve were keys of the
/// layer itself: `spheres`, `cutoff` (always a sharp cut, never clamped), `curve` and `residual`.
fn from_1_to_2(table: &mut Table) {
    let shape = table.remove("shape").unwrap_or(Value::String(String::new()));
    let mut shape_table = Table::new();
    shape_table.insert("source".into(), shape);
    if let Some(harmonics) = table.remove("harmonics") {
        shape_table.insert("harmonics".into(), harmonics);
    }
    table.insert("shape".into(), Value::Table(shape_table));
    let Some(Value::Array(layers)) = table.get_mut("layer") else { return };
    for layer in layers.iter_mut().filter_map(Value::as_table_mut) {
        let mut region = Table::new();
        for key in ["spheres", "painted", "cutoff"] {
            region.extend(layer.remove(key).map(|value| (key.to_owned(), value)));
        }
        region.insert("roll_off".into(), Value::String("sharp".into()));
        region.insert("clamp".into(), Value::Boolean(false));
        layer.insert("region".into(), Value::Table(region));
        if let Some(points) = layer.remove("curve") {
            let residual = layer.remove("residual").unwrap_or(Value::Float(1.0));
            let scale = [("points".to_owned(), points), ("residual".to_owned(), residual)];
            layer.insert("scale".into(), Value::Table(scale.into_iter().collect()));
        }
    }
}

/// In format 2 a scale curve ran over u, the share of the frequency of the last of K harmonics, and a region
/// was smoothed below harmonic `cutoff`. Both become wavelengths by Weyl's law, which needs neither the shape
/// nor its harmonics.
fn from_2_to_3(table: &mut Table) {
    let harmonics = table.get("shape").and_then(|shape| shape.get("harmonics")).and_then(Value::as_integer);
    let harmonics = harmonics.map_or(DEFAULT_HARMONICS as f64, |k| k.max(1) as f64);
    let Some(Value::Array(layers)) = table.get_mut("layer") else { return };
    for layer in layers.iter_mut().filter_map(Value::as_table_mut) {
        // It did not exist: the shape stays as it was made.
        layer.insert("infill".into(), Value::Float(0.0));
        let region = layer.entry("region").or_insert_with(|| Value::Table(Table::new()));
        if let Some(region) = region.as_table_mut() {
            let cutoff = region.remove("cutoff").and_then(|cutoff| cutoff.as_integer());
            let wavelength = usual_wavelength(cutoff.unwrap_or(96).clamp(1, 90_000) as f64);
            region.insert("wavelength".into(), Value::Float(wavelength));
            // A Gaussian low-pass by harmonics, which rang a little; heat halves the same wavelength.
            if region.get("roll_off").and_then(Value::as_str) == Some("gaussian") {
                region.insert("roll_off".into(), Value::String("heat".into()));
            }
        }
        let points = layer.get_mut("scale").and_then(|scale| scale.get_mut("points"));
        if let Some(points) = points
            && let Ok(old) = points.clone().try_into::<Vec<[f64; 2]>>()
            && old.windows(2).all(|pair| pair[0][0] < pair[1][0])
            && old
                .iter()
                .all(|[u, gain]| (0.0..=1.0).contains(u) && (0.0..=ScaleCurve::MAX_GAIN).contains(gain))
        {
            let pair = |p: &[f64; 2]| Value::Array(p.map(Value::Float).into());
            *points = Value::Array(over_wavelengths(&old, harmonics).iter().map(pair).collect());
        }
    }
}

/// Hardly any shape has longer waves than this, except the constant, at u = 0.
const LONGEST: f64 = 2.5;

/// The points of a curve over wavelengths that is within 0.005 of the one through `old` over u for all waves
/// that shapes have, and the same for the constant.
fn over_wavelengths(old: &[[f64; 2]], harmonics: f64) -> Vec<[f64; 2]> {
    let finest = usual_wavelength(harmonics);
    let before = |wavelength: f64| monotone(old.iter().copied(), finest / wavelength).unwrap_or(1.0);
    let Some([_, gain]) = old.first() else { return Vec::new() };
    if old.iter().all(|p| p[1] == *gain) {
        return ScaleCurve::flat(*gain).points;
    }
    let (broad, fine) = (ScaleCurve::BROADEST, ScaleCurve::FINEST);
    let mut curve = ScaleCurve { points: Vec::new(), residual: 0.0 };
    curve.set_point(broad, *gain);
    for u in old.iter().map(|p| p[0]).chain([0.0]) {
        let wavelength = (finest / u).clamp(fine, LONGEST);
        curve.set_point(wavelength, before(wavelength));
    }
    let steps = 400;
    let grid = |i: usize| LONGEST * (fine / LONGEST).powf(i as f64 / f64::from(steps));
    for _ in 0..100 {
        let off = |w: f64| (curve.at(w) - before(w)).abs();
        let worst = (0..=steps as usize).map(grid).max_by(|a, b| off(*a).total_cmp(&off(*b)));
        match worst.filter(|w| off(*w) > 0.005) {
            Some(wavelength) => curve.set_point(wavelength, before(wavelength)),
            None => break,
        };
    }
    curve.points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_over_shares_of_the_highest_frequency_is_the_same_over_wavelengths() {
        let curves: [&[[f64; 2]]; 4] = [
            &[[0.0, 1.0], [0.5, 1.0], [1.0, 0.0]],
            &[[0.0, 0.2], [0.15, 1.0], [0.3, 1.8], [0.5, 1.0], [0.8, 0.0]],
            &[[0.0, 0.0], [0.3, 0.1], [0.6, 1.0], [1.0, 1.8]],
            &[[0.2, 4.0], [0.21, 0.0], [0.9, 3.0]],
        ];
        for old in curves {
            for harmonics in [16.0, 256.0, 512.0, 4096.0] {
                let points = over_wavelengths(old, harmonics);
                assert!(points.len() < 40, "{}", points.len());
                let curve = ScaleCurve { points, residual: 0.0 };
                curve.validate().unwrap();
                for k in 2..harmonics as usize {
                    let u = (k as f64 / harmonics).sqrt();
                    let expected = monotone(old.iter().copied(), u).unwrap();
                    let found = curve.at(usual_wavelength(k as f64));
                    assert!((found - expected).abs() < 0.04, "K = {harmonics}, k = {k}: {found}, {expected}");
                }
            }
        }
        // Weyl's law is an estimate: on a coarse ball, whose equal eigenvalues come in long steps, the new
        // curve is at most an eighth of a frequency away from the old one.
        let body = chladni_harmonics::Body::build(
            &chladni_mesh::samples::icosphere(3),
            &chladni_harmonics::BasisSettings::new(100),
            &chladni_task::Task::new(),
        );
        let basis = body.unwrap().basis;
        let curve = ScaleCurve { points: over_wavelengths(curves[1], 100.0), residual: 0.0 };
        for (gain, l) in curve.gains(&basis).into_iter().zip(&basis.eigenvalues) {
            let u = (l.max(0.0) / basis.eigenvalues[99]).sqrt();
            let near = (-12..=12).map(|percent| u * (1.0 + 0.01 * f64::from(percent)));
            let off = near.map(|u| (gain - monotone(curves[1].iter().copied(), u).unwrap()).abs());
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off < 0.03, "u = {u}: {gain}, off by {off}");
        }
        assert_eq!(over_wavelengths(&[[0.0, 2.0], [1.0, 2.0]], 512.0), ScaleCurve::flat(2.0).points);
        assert!(over_wavelengths(&[], 512.0).is_empty());
    }
}
