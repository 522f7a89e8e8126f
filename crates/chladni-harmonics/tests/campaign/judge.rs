//! Judges whether the solver's statements about a case are true.

use chladni_harmonics::{Basis, Certificate, HarmonicsError, Operator, SymmetricSparse};

use crate::cases::{Case, FAMILIES, Found, Known};
use crate::inertia::count_below;
use crate::spectrum::JACOBI;

/// The verdict on a case.
pub enum Verdict {
    /// Certified as precise, which is true.
    Certified {
        residual: f64,
    },
    /// Returned with a warning, and right within what that states: residuals and overlaps are no larger, and every eigenvalue is one
    /// of the exact ones within its residual, though some may be missing.
    Warned,
    /// `rightly` if the mesh has no harmonics at all.
    Refused {
        why: String,
        rightly: bool,
    },
    Wrong(String),
}

/// If a residual consists of rounding errors, measuring it in another order gives another value.
const AGAIN: f64 = 1.2;
/// Errors below this share of their limit are not compared.
const TINY: f64 = 0.01;
/// By how many last bits of the terms that it adds S h is uncertain: H is rounded once more after it was measured.
const LAST_BITS: f64 = 2.0;
/// Rounding errors of eigenvalues, as a share of the largest one.
const ROUNDING: f64 = 2e-13;
/// A millionth of the first eigenvalue is 10⁻¹³ of the largest, beside which rounding may blur a count, if that is this many
/// times as large.
const COUNTABLE: f64 = 1e7;
/// Up to this many rows each case is counted in [`miscounted`], beyond it one in eight.
const COUNTED: usize = 120;

/// Solves a case and compares the result with what is known.
pub fn judge(case: &Case) -> Verdict {
    let known = match case.problem.pencil() {
        Ok(known) => known,
        Err(refusal) => return refused(&refusal),
    };
    let Found { basis, cuts_cluster } = match case.solve(1) {
        Ok(found) => found,
        Err(refusal) => return refused(&refusal),
    };
    let (k, n) = (basis.harmonics(), known.mass.size());
    let asked = case.harmonics.min(n);
    if k < asked || (k > asked && !case.whole_clusters) || (case.whole_clusters && cuts_cluster) {
        return Verdict::Wrong(format!("{k} harmonics for {asked}"));
    }
    let stated = basis.certificate;
    let lift = if known.operator.is_some() { 0.0 } else { lift(&known.spectrum, k) };
    let off = if stated.inertia_counts_match == Some(true) {
        let groups = if n <= COUNTED { 3 } else { usize::from((case.seed / FAMILIES).is_multiple_of(8)) };
        missed(&known, &basis, lift).or_else(|| miscounted(&known, &basis, lift, groups))
    } else {
        invented(&known, &basis)
    };
    let refuted = || known.operator.as_ref().and_then(|operator| certified_again(operator, &known, &basis));
    if let Some(what) = off.or_else(refuted) {
        return Verdict::Wrong(what);
    }
    let residual = largest_residual(&known, &basis, lift);
    let overlap = largest_overlap(&known.mass, &basis);
    let is_within = |measured: f64, stated: f64, limit: f64| measured <= AGAIN * stated.max(TINY * limit);
    if !is_within(residual, stated.max_relative_residual, Certificate::RESIDUAL) {
        return Verdict::Wrong(format!(
            "the residual is {residual:.2e}, not {:.2e}",
            stated.max_relative_residual
        ));
    }
    if !is_within(overlap, stated.max_orthogonality_error, Certificate::ORTHOGONALITY) {
        return Verdict::Wrong(format!(
            "the overlap is {overlap:.2e}, not {:.2e}",
            stated.max_orthogonality_error
        ));
    }
    if stated.is_precise() { Verdict::Certified { residual } } else { Verdict::Warned }
}

fn refused(refusal: &HarmonicsError) -> Verdict {
    use HarmonicsError::{CrowdedEdge, FlatTriangle, NoTriangle, ZeroArea};
    let rightly = matches!(refusal, ZeroArea { .. } | NoTriangle | CrowdedEdge { .. } | FlatTriangle { .. });
    Verdict::Refused { why: refusal.to_string(), rightly }
}

/// Describes the first eigenvalue that is not the one expected in its place.
fn missed(known: &Known, basis: &Basis, lift: f64) -> Option<String> {
    let (exact, residual) = (&known.spectrum, basis.certificate.max_relative_residual);
    let scale = exact.last().copied().unwrap_or(0.0);
    let share = 1e-9_f64.max(2.0 * residual);
    let by_rotations = known.operator.is_some() && known.mass.size() <= JACOBI;
    let off = |(k, (value, exact)): &(usize, (&f64, &f64))| {
        let error = (**value - **exact).abs();
        // Which constant goes with which zero nobody knows; and such a residual says that rounding has left nothing.
        let is_near = by_rotations && *k >= known.zeros && residual < 0.1;
        let rounding = if is_near { rounding_beside(known, basis.harmonic(*k)) } else { f64::INFINITY };
        let allowed = share * exact.abs() + 2.0 * residual * lift + rounding.min(ROUNDING * scale);
        error.is_nan() || error > allowed
    };
    let (k, (value, exact)) = basis.eigenvalues.iter().zip(exact).enumerate().find(off)?;
    Some(format!("eigenvalue {k} is {value:e}, not {exact:e} (the largest is {scale:e})"))
}

/// What rounding errors of S can do to the eigenvalue of `h`: the terms that cancel in hᵀSh times some last bits.
fn rounding_beside(known: &Known, h: &[f64]) -> f64 {
    let row = |v: usize| known.stiffness.column(v).map(|(i, s)| (s * h[i] * h[v]).abs()).sum::<f64>();
    16.0 * f64::EPSILON * (0..h.len()).map(row).sum::<f64>()
}

/// Describes the first of up to `groups` + 1 places between groups of eigenvalues where an exact count differs from the number of
/// pairs: below the first that is not 0, below and above the last, and some between. Counts are taken just beside the
/// eigenvalues, no farther than their certificate allows them to be off.
fn miscounted(known: &Known, basis: &Basis, lift: f64, groups: usize) -> Option<String> {
    let (values, residual) = (&basis.eigenvalues, basis.certificate.max_relative_residual);
    let scale = known.spectrum.last().copied().unwrap_or(0.0);
    // A residual is a share of ‖S h‖, which is larger than λ ‖M h‖ by up to the residual itself; of 1 it states nothing.
    if residual.is_nan() || residual >= 1.0 {
        return None;
    }
    let of_value = residual / (1.0 - residual);
    let allowed = |value: f64| {
        let stated = 1e-9_f64.max(2.0 * of_value) * value.abs();
        if known.operator.is_some() {
            stated
        } else {
            // Beside the residuals of S + tM, those of S itself are known to this.
            let own = 3.0 * of_value.max(1e-7) * value.abs();
            own.min(stated + 2.0 * residual * lift + ROUNDING * scale)
        }
    };
    let above = |k: usize| values[k] + allowed(values[k]);
    let below = |k: usize| values[k] - allowed(values[k]);
    // A certificate may state that it cannot tell an eigenvalue from 0.
    let is_gap = |k: &usize| below(*k) > k.checked_sub(1).map_or(0.0, above).max(0.0);
    let gaps: Vec<usize> = (0..values.len()).filter(is_gap).collect();
    // The last one first, as below it none may be missing.
    let steps = groups.saturating_sub(1).max(1);
    let last = gaps.len().saturating_sub(1);
    let mut places: Vec<usize> =
        (0..groups).filter_map(|i| gaps.get(last * (steps - i) / steps).copied()).collect();
    places.dedup();
    let counted = |sigma: f64| count_below(&known.stiffness, &known.mass, sigma);
    for k in places {
        let just_above = k.checked_sub(1).filter(|k| values[*k] > 0.0).map(above);
        for sigma in just_above.into_iter().chain([below(k)]) {
            let count = counted(sigma);
            if count != k {
                return Some(format!("{count} eigenvalues are below {sigma:e}, not {k}: {:e}", values[k]));
            }
        }
    }
    let last = values.len().checked_sub(1).filter(|k| groups > 1 && values[*k] > 0.0)?;
    let count = counted(above(last));
    (count <= last).then(|| format!("{count} eigenvalues are below {:e}, not {}", above(last), last + 1))
}

/// Describes the first eigenvalue that is not one of the exact ones within its residual: for any λ and h, one lies within
/// √(rᵀM⁻¹r / hᵀMh) of λ, where r = S h − λ M h.
fn invented(known: &Known, basis: &Basis) -> Option<String> {
    let scale = known.spectrum.last().copied().unwrap_or(0.0);
    (0..basis.harmonics()).find_map(|k| {
        let (h, lambda) = (basis.harmonic(k), basis.eigenvalues[k]);
        let (image, weighted) = (known.stiffness.times(h), known.mass.times(h));
        // With the diagonal of an M that is not diagonal, the error can be half of what it is with M (`pencils::consistent`).
        let sums = (0..h.len())
            .map(|v| [(image[v] - lambda * weighted[v]).powi(2) / basis.mass[v], weighted[v] * h[v]]);
        let [error, size] = sums.fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
        let reach = 2.0 * AGAIN * (error / size).sqrt() + ROUNDING * scale;
        let nearest = known.spectrum.iter().map(|value| (lambda - value).abs()).fold(f64::INFINITY, f64::min);
        let is_near = nearest <= reach;
        (!is_near).then(|| format!("eigenvalue {k}, {lambda:e}, is {nearest:.2e} from any, not {reach:.2e}"))
    })
}

/// Describes how [`Operator::certify`] is mistaken about a precise result, which it must not refute, and must accept unless
/// its counts are lost in rounding; or about the same without one pair, which it must not accept.
fn certified_again(operator: &Operator, known: &Known, basis: &Basis) -> Option<String> {
    if !basis.certificate.is_precise() {
        return None;
    }
    let largest = known.spectrum.last().copied().unwrap_or(0.0);
    let first = basis.eigenvalues.get(known.zeros).or(known.spectrum.get(known.zeros));
    let is_countable = first.is_none_or(|first| largest <= COUNTABLE * first);
    match operator.certify(basis) {
        Ok(again) if again.inertia_counts_match == Some(true) => {}
        Ok(again) if again.inertia_counts_match.is_none() && !is_countable => {}
        Err(_) if !is_countable => {}
        other => return Some(format!("precise, but certified again it is {other:?}")),
    }
    // One of the last group may be missing, because K may cut it.
    let values = &basis.eigenvalues;
    let last = (1..values.len()).rev().find(|k| values[*k] - values[k - 1] > 1e-5 * values[*k])?;
    let missing = last / 2;
    let n = basis.vertices();
    let mut eigenvalues = values.clone();
    eigenvalues.remove(missing);
    let mut vectors = basis.vectors.to_vec();
    vectors.drain(missing * n..(missing + 1) * n);
    let fewer = Basis { eigenvalues, vectors: vectors.into(), ..basis.clone() };
    let again = operator.certify(&fewer).ok()?;
    (again.inertia_counts_match == Some(true))
        .then(|| format!("certified again without pair {missing}: {again:?}"))
}

/// The largest shift that the solver adds to the eigenvalues of a given pencil before it measures
/// residuals.
fn lift(exact: &[f64], k: usize) -> f64 {
    let largest = exact.last().copied().unwrap_or(0.0);
    let zeros = exact.iter().take_while(|value| **value <= 1e-12 * largest).count();
    if zeros >= k {
        // Where all wanted ones are 0, about as much as the first that is not.
        return exact.get(2 * zeros + 2).map_or(4.0 * largest, |above| 1.2 * above);
    }
    exact.get(2 * k).map_or(4.0 * largest, |above| 1.2 * above) / k as f64 + 1e-9 * largest
}

/// The largest ‖S h − λ M h‖ / ‖(S + tM) h‖ beyond what rounding of S h may leave; t = 0 unless a pencil
/// was given.
fn largest_residual(known: &Known, basis: &Basis, lift: f64) -> f64 {
    (known.zeros..basis.harmonics())
        .map(|k| {
            let (h, lambda) = (basis.harmonic(k), basis.eigenvalues[k]);
            let (image, weighted) = (known.stiffness.times(h), known.mass.times(h));
            let rounding = |v: usize| {
                f64::EPSILON * known.stiffness.column(v).map(|(i, s)| (s * h[i]).abs()).sum::<f64>()
            };
            let sums = (0..h.len()).map(|v| {
                let m = weighted[v];
                [image[v] - lambda * m, image[v] + lift * m, LAST_BITS * rounding(v)].map(|x| x * x)
            });
            let [error, size, rounding] = sums.fold([0.0; 3], |sum, x| [0, 1, 2].map(|i| sum[i] + x[i]));
            (error.sqrt() - rounding.sqrt()).max(0.0) / size.sqrt()
        })
        .fold(0.0, f64::max)
}

/// max |HᵀMH − I|.
fn largest_overlap(mass: &SymmetricSparse, basis: &Basis) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..basis.harmonics() {
        let weighted = mass.times(basis.harmonic(j));
        for i in 0..=j {
            let overlap: f64 = basis.harmonic(i).iter().zip(&weighted).map(|(a, b)| a * b).sum();
            largest = largest.max((overlap - f64::from(u8::from(i == j))).abs());
        }
    }
    largest
}

/// A warning is worth something only if a wrong one is found: eigenvalues that are none, and a residual that is understated.
#[test]
fn a_warned_result_that_is_wrong_is_found() {
    let case = Case::in_family(1, 1);
    let mut known = case.problem.pencil().unwrap();
    let basis = case.solve(1).unwrap().basis;
    assert_eq!(invented(&known, &basis), None);
    // A pair that is missing is no lie where nothing was counted.
    let exact = known.spectrum.clone();
    known.spectrum.insert(0, 0.0);
    assert_eq!(invented(&known, &basis), None);
    // Between two eigenvalues there is none, and its pair is one of another matrix.
    known.spectrum = exact.iter().map(|value| 1.001 * value + 1e-3 * exact[exact.len() - 1]).collect();
    assert!(invented(&known, &basis).is_some());
}

/// Counts must find a pair that is missing, whether of small or of large eigenvalues.
#[test]
fn a_pair_that_is_missing_is_found() {
    let mut tried = 0;
    for seed in 0..30 {
        let case = Case::in_family(5, seed);
        let known = case.problem.pencil().unwrap();
        let basis = case.solve(1).unwrap().basis;
        let n = basis.vertices();
        let lowest = basis.eigenvalues.len() > 2 && basis.eigenvalues[2] > 1.1 * basis.eigenvalues[1];
        if n > COUNTED || !lowest || !basis.certificate.is_precise() {
            continue;
        }
        assert_eq!(miscounted(&known, &basis, 0.0, 3), None, "{seed}");
        let mut fewer = basis.clone();
        fewer.eigenvalues.remove(1);
        assert!(miscounted(&known, &fewer, 0.0, 3).is_some(), "{seed}");
        tried += 1;
    }
    assert!(tried >= 5, "{tried}");
}
