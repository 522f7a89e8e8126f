//! Judges whether the solver's statements about a case are true.

use chladni_harmonics::{Basis, Certificate, HarmonicsError, SymmetricSparse};

use crate::cases::{Case, Found, Known};

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
const AGAIN: f64 = 1.5;
/// Rounding errors of eigenvalues, as a share of the largest one.
const ROUNDING: f64 = 2e-13;

/// Solves a case and compares the result with what is known.
pub fn judge(case: &Case) -> Verdict {
    let Known { stiffness, mass, zeros, spectrum: exact } = match case.problem.pencil() {
        Ok(known) => known,
        Err(refusal) => return refused(&refusal),
    };
    let Found { basis, cuts_cluster } = match case.solve(1) {
        Ok(found) => found,
        Err(refusal) => return refused(&refusal),
    };
    let k = basis.harmonics();
    let asked = case.harmonics.min(mass.len());
    if k < asked || (k > asked && !case.whole_clusters) || (case.whole_clusters && cuts_cluster) {
        return Verdict::Wrong(format!("{k} harmonics for {asked}"));
    }
    let stated = basis.certificate;
    let lift = if zeros > 0 { 0.0 } else { lift(&exact, k) };
    let off = if stated.inertia_counts_match == Some(true) {
        missed(&basis, &exact, stated.max_relative_residual, lift)
    } else {
        invented(&stiffness, &basis, &exact)
    };
    if let Some(what) = off {
        return Verdict::Wrong(what);
    }
    let residual = largest_residual(&stiffness, &basis, zeros, lift);
    let overlap = largest_overlap(&basis);
    let is_within = |measured: f64, stated: f64, limit: f64| measured <= AGAIN * stated.max(0.1 * limit);
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
    let rightly = matches!(refusal, HarmonicsError::ZeroArea { .. } | HarmonicsError::NoTriangle);
    Verdict::Refused { why: refusal.to_string(), rightly }
}

/// Describes the first eigenvalue that is not the one expected in its place.
fn missed(basis: &Basis, exact: &[f64], residual: f64, lift: f64) -> Option<String> {
    let scale = exact.last().copied().unwrap_or(0.0);
    let share = 1e-9_f64.max(2.0 * residual);
    let off = |(_, (value, exact)): &(usize, (&f64, &f64))| {
        let error = (**value - **exact).abs();
        error.is_nan() || error > share * exact.abs() + 2.0 * residual * lift + ROUNDING * scale
    };
    let (k, (value, exact)) = basis.eigenvalues.iter().zip(exact).enumerate().find(off)?;
    Some(format!("eigenvalue {k} is {value:e}, not {exact:e} (the largest is {scale:e})"))
}

/// Describes the first eigenvalue that is not one of the exact ones within its residual: for any λ and h, one lies within
/// √(rᵀM⁻¹r / hᵀMh) of λ, where r = S h − λ M h.
fn invented(stiffness: &SymmetricSparse, basis: &Basis, exact: &[f64]) -> Option<String> {
    let scale = exact.last().copied().unwrap_or(0.0);
    (0..basis.harmonics()).find_map(|k| {
        let (h, lambda) = (basis.harmonic(k), basis.eigenvalues[k]);
        let image = stiffness.times(h);
        let sums = (0..h.len()).map(|v| {
            let m = basis.mass[v];
            [(image[v] - lambda * m * h[v]).powi(2) / m, m * h[v] * h[v]]
        });
        let [error, size] = sums.fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
        let reach = AGAIN * (error / size).sqrt() + ROUNDING * scale;
        let nearest = exact.iter().map(|value| (lambda - value).abs()).fold(f64::INFINITY, f64::min);
        let is_near = nearest <= reach;
        (!is_near).then(|| format!("eigenvalue {k}, {lambda:e}, is {nearest:.2e} from any, not {reach:.2e}"))
    })
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
fn largest_residual(stiffness: &SymmetricSparse, basis: &Basis, zeros: usize, lift: f64) -> f64 {
    (zeros..basis.harmonics())
        .map(|k| {
            let (h, lambda) = (basis.harmonic(k), basis.eigenvalues[k]);
            let image = stiffness.times(h);
            let rounding =
                |v: usize| f64::EPSILON * stiffness.column(v).map(|(i, s)| (s * h[i]).abs()).sum::<f64>();
            let sums = (0..h.len()).map(|v| {
                let m = basis.mass[v] * h[v];
                [image[v] - lambda * m, image[v] + lift * m, 4.0 * rounding(v)].map(|x| x * x)
            });
            let [error, size, rounding] = sums.fold([0.0; 3], |sum, x| [0, 1, 2].map(|i| sum[i] + x[i]));
            (error.sqrt() - rounding.sqrt()).max(0.0) / size.sqrt()
        })
        .fold(0.0, f64::max)
}

/// max |HᵀMH − I|.
fn largest_overlap(basis: &Basis) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..basis.harmonics() {
        let weighted: Vec<f64> = basis.harmonic(j).iter().zip(&basis.mass).map(|(h, a)| h * a).collect();
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
    let case = Case::of(1);
    let Known { stiffness, spectrum: exact, .. } = case.problem.pencil().unwrap();
    let basis = case.solve(1).unwrap().basis;
    assert_eq!(invented(&stiffness, &basis, &exact), None);
    // A pair that is missing is no lie where nothing was counted.
    let mut exact_and_more = exact.clone();
    exact_and_more.insert(0, 0.0);
    assert_eq!(invented(&stiffness, &basis, &exact_and_more), None);
    // Between two eigenvalues there is none, and its pair is one of another matrix.
    let others: Vec<f64> = exact.iter().map(|value| 1.001 * value + 1e-3 * exact[exact.len() - 1]).collect();
    assert!(invented(&stiffness, &basis, &others).is_some());
}
