//! Solves general pencils, which are only known to be symmetric and positive semidefinite.

use chladni_task::Task;
use rayon::prelude::*;

use super::components::{self, Kind};
use super::plan::inertia;
use super::problem::{Problem, Profile};
use super::{Solved, Wanted, or_dense, plan, solve_connected, where_it_fits};
use crate::basis::larger;
use crate::{Basis, BasisSettings, HarmonicsError, Pencil, SymmetricSparse, canonical};

/// Shares of a bound on the largest eigenvalue: below the first, an eigenvalue of S beside its own diagonal counts as zero,
/// and the search for others begins there; the second is how far rounding may push one below zero; the third is the
/// smallest shift.
const FIRST: f64 = 1e-13;
const BELOW_ZERO: f64 = 1e-10;
const LEAST_LIFT: f64 = 1e-10;
/// The least of that diagonal, as a share of its largest value: smaller ones may be rounding.
const LEAST_DIAGONAL: f64 = 1e-10;
/// The number of counts taken in that search, and how many of the first assume evenly spread eigenvalues.
const ROUNDS: usize = 60;
const PROPORTIONAL: usize = 5;
/// The residuals of S rather than S + tM are reported from here on: smaller ones measure the rounding of S h itself.
const REPORTED_RESIDUAL: f64 = 1e-7;

/// Solves for the first pairs of `pencil`.
///
/// The relative error of an eigenvalue 0 is undefined, and its vectors are unknown. Instead of S, S + tM is
/// solved. Its eigenvalues are those of S plus t, where t is about the distance between the first ones;
/// none of them is small compared with the distance to the next. If all that are wanted are 0, t is about the
/// first eigenvalue that is not.
///
/// `choose` chooses among equally good pairs, before a group of equal eigenvalues is cut at K.
pub(crate) fn solve(
    pencil: Pencil,
    settings: &BasisSettings,
    choose: impl FnOnce(&mut Basis) -> Result<(), HarmonicsError>,
    task: &Task,
) -> Result<Solved, HarmonicsError> {
    let (vertices, planned) = (pencil.mass.len(), plan::slices(settings.harmonics));
    let mut solved = where_it_fits(vertices, planned, settings, |wanted| solve_wanted(pencil, wanted, task))?;
    choose(&mut solved.basis)?;
    if !settings.whole_clusters && solved.basis.harmonics() > settings.harmonics {
        solved.basis.truncate(settings.harmonics);
        solved.cuts_cluster = true;
    }
    Ok(solved)
}

fn solve_wanted(pencil: Pencil, wanted: Wanted, task: &Task) -> Result<Solved, HarmonicsError> {
    let harmonics = wanted.harmonics;
    let mut profile = Profile::default();
    let problem = Problem::of(pencil);
    // Before the first factor: those of graphs and solids may be far larger than those of surfaces.
    wanted.fitted(&problem.symbolic)?;
    let mut problem = problem.given(pencil)?;
    let bound = pencil.bound() * problem.stretch();
    // Zeros are counted by inertia: by value, a zero cannot be distinguished from anything small compared
    // with the lift. How many there are, and how many are negative, depends on S alone (Sylvester), so they are counted
    // beside its own diagonal: beside M a single small mass lifts what counts as zero above all others.
    let (spacing, zeros) = if bound > 0.0 {
        let own = own_diagonal(pencil.stiffness);
        let alone = Pencil::lumped(pencil.stiffness, &own);
        let (scaled, largest) = (Problem::of(alone).given(alone)?, alone.bound());
        check_signs(&scaled, largest, &mut profile)?;
        let zeros = inertia(&scaled, FIRST * largest, &mut profile)?.1;
        // Where all wanted ones are 0, as far as the first that is not.
        let (among, steps) = if zeros < harmonics { (harmonics, harmonics) } else { (zeros + 1, 1) };
        (above(&problem, bound, among, &mut profile, task)? / steps as f64, zeros)
    } else {
        (1.0, pencil.mass.len())
    };
    let lift = spacing.max(LEAST_LIFT * bound);
    problem.lift(lift);
    let stiffness = match pencil.consistent {
        None => pencil.stiffness.plus_diagonal(pencil.mass, lift),
        Some(consistent) => pencil.stiffness.plus(consistent, lift),
    };
    let lifted = Pencil { stiffness: &stiffness, ..pencil };
    let component = stiffness.components();
    let solved = if component.iter().any(|c| *c > 0) {
        // Components are solved separately: a single Krylov space would need a direction for each copy of
        // an eigenvalue that equal components share.
        components::solve(lifted, &component, Kind::Given { spacing: lift }, wanted, task)
    } else {
        let stage = task.stage("harmonics", harmonics as u64);
        solve_connected(lifted, 0, Some(problem), wanted, &stage, task)
    };
    let mut solved = or_dense(solved, lifted, 0, wanted, task)?;
    solved.profile.add(&profile);
    for (k, value) in solved.basis.eigenvalues.iter_mut().enumerate() {
        *value = if k < zeros { 0.0 } else { (*value - lift).max(0.0) };
    }
    // So far the certificate is that of S + tM: an error that is small beside t may be large beside the first eigenvalues.
    let own = residual(&pencil, zeros, &solved.basis, task)?;
    if own.is_nan() || own > REPORTED_RESIDUAL {
        let certified = &mut solved.basis.certificate.max_relative_residual;
        *certified = larger(*certified, own);
    }
    canonical::orient(&mut solved.basis);
    Ok(solved)
}

/// The largest ‖S h − λ M h‖ / ‖S h‖ of the pairs after the first `zeros`, where ‖x‖² = xᵀD⁻¹x with the diagonal D of M: if
/// M is diagonal, no λ is farther from an eigenvalue.
fn residual(pencil: &Pencil, zeros: usize, basis: &Basis, task: &Task) -> Result<f64, HarmonicsError> {
    // All pairs of a large pencil take long.
    let of_pair = |k: usize| -> Result<f64, HarmonicsError> {
        task.check()?;
        let (h, lambda) = (basis.harmonic(k), basis.eigenvalues[k]);
        let (mut error, mut size) = (0.0, f64::MIN_POSITIVE);
        for ((s, m), d) in pencil.stiffness.times(h).iter().zip(pencil.mass_times(h)).zip(pencil.mass) {
            error += (s - lambda * m).powi(2) / d;
            size += s * s / d;
        }
        Ok((error / size).sqrt())
    };
    (zeros..basis.harmonics()).into_par_iter().map(of_pair).try_reduce(|| 0.0, |a, b| Ok(larger(a, b)))
}

/// The diagonal of S, as a mass with which the largest eigenvalue is about 1.
fn own_diagonal(stiffness: &SymmetricSparse) -> Vec<f64> {
    let least = LEAST_DIAGONAL * stiffness.largest_diagonal();
    let usual = |value: f64| if value.max(least) > 0.0 { value.max(least) } else { 1.0 };
    stiffness.diagonal().into_iter().map(usual).collect()
}

/// Refuses negative eigenvalues.
fn check_signs(problem: &Problem, bound: f64, profile: &mut Profile) -> Result<(), HarmonicsError> {
    let (_, negative) = inertia(problem, -BELOW_ZERO * bound, profile)?;
    if negative > 0 {
        let mut reason =
            format!("S has {negative} negative eigenvalues, so that it is not positive semidefinite");
        if inertia(problem, BELOW_ZERO * bound, profile)?.1 == problem.mass.len() {
            reason += ": it has no positive ones, and -S is what Laplacians of the other sign need";
        }
        return Err(HarmonicsError::bad_pencil(reason));
    }
    Ok(())
}

/// A value about as high as the first `harmonics` eigenvalues reach; `bound` is above all eigenvalues.
fn above(
    problem: &Problem,
    bound: f64,
    harmonics: usize,
    profile: &mut Profile,
    task: &Task,
) -> Result<f64, HarmonicsError> {
    let (mut low, mut high) = (FIRST * bound, 1.01 * bound);
    // Assumes evenly spread eigenvalues, as those of surfaces are; their mean is that of the diagonal.
    let wanted = 1.5 * harmonics as f64;
    let n = problem.mass.len() as f64;
    let mut at = wanted / n * problem.matrix.diagonal().iter().sum::<f64>() / n;
    for round in 0..ROUNDS {
        task.check()?;
        if round >= PROPORTIONAL || !(at > low && at < high) {
            at = (low * high).sqrt();
        }
        let (_, count) = inertia(problem, at, profile)?;
        if count < harmonics {
            low = at;
        } else {
            high = at;
        }
        if high <= 1.1 * low || (harmonics..=2 * harmonics).contains(&count) {
            break;
        }
        at *= wanted / (count as f64).max(0.5);
    }
    Ok(high)
}

#[cfg(test)]
mod tests {
    use chladni_mesh::samples;
    use proptest::prelude::*;

    use super::*;
    use crate::{ConsistentPencil, Operator};

    fn solved(pencil: &Pencil, harmonics: usize) -> Basis {
        let (basis, report) = pencil.solve(&BasisSettings::new(harmonics), &Task::new()).unwrap();
        assert!(report.warnings(&basis.certificate).is_empty(), "{:?}", basis.certificate);
        basis
    }

    /// ‖S h − λ M h‖ relative to the size of the part of the spectrum that was requested.
    fn worst_residual(pencil: &Pencil, basis: &Basis) -> f64 {
        let scale = basis.eigenvalues.last().copied().unwrap_or(1.0).max(1e-300);
        let residual = |k: usize| {
            let (h, image) = (basis.harmonic(k), pencil.stiffness.times(basis.harmonic(k)));
            let lambda = basis.eigenvalues[k];
            let squares =
                (0..h.len()).map(|v| (image[v] - lambda * pencil.mass[v] * h[v]).powi(2) / pencil.mass[v]);
            squares.sum::<f64>().sqrt() / scale
        };
        (0..basis.harmonics()).map(residual).fold(0.0, f64::max)
    }

    #[test]
    fn a_surface_that_was_given_has_the_eigenvalues_of_its_own_solver() {
        let operator = Operator::of(&samples::torus(0.4, 60, 30)).unwrap();
        let own = super::super::solve(&operator, &BasisSettings::new(150), &Task::new()).unwrap().basis;
        let given = solved(&operator.pencil(), 150);
        assert_eq!(given.eigenvalues[0], 0.0);
        for (a, b) in given.eigenvalues.iter().zip(&own.eigenvalues).skip(1) {
            assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
        }
        assert!(worst_residual(&operator.pencil(), &given) < 1e-8);
    }

    #[test]
    fn several_pieces_and_no_null_space_at_all_are_solved_in_slices() {
        // Six strings of beads with different weights; then each of them held at its ends.
        let (strings, beads) = (6, 300);
        for held in [0.0, 1.0] {
            let mut entries = Vec::new();
            for s in 0..strings {
                for i in 0..beads {
                    let v = s * beads + i;
                    let ends = f64::from(u8::from(i > 0)) + f64::from(u8::from(i + 1 < beads));
                    entries.push((v, v, ends.max(2.0 * held)));
                    if i > 0 {
                        entries.push((v, v - 1, -1.0));
                    }
                }
            }
            let stiffness = SymmetricSparse::from_entries(strings * beads, entries).unwrap();
            let mass: Vec<f64> = (0..strings * beads).map(|v| 1.0 + (v / beads) as f64).collect();
            let pencil = Pencil::new(&stiffness, &mass).unwrap();
            let basis = solved(&pencil, 60);
            let mut exact: Vec<f64> = (0..strings)
                .flat_map(|s| {
                    (0..beads).map(move |k| {
                        let turn = if held > 0.0 {
                            (k + 1) as f64 / (beads + 1) as f64
                        } else {
                            k as f64 / beads as f64
                        };
                        (2.0 - 2.0 * (std::f64::consts::PI * turn).cos()) / (1.0 + s as f64)
                    })
                })
                .collect();
            exact.sort_by(f64::total_cmp);
            for (value, exact) in basis.eigenvalues.iter().zip(&exact) {
                assert!((value - exact).abs() < 1e-10, "{value} {exact}");
            }
            let zeros = basis.eigenvalues.iter().filter(|l| **l == 0.0).count();
            assert_eq!(zeros, if held > 0.0 { 0 } else { strings });
            assert!(worst_residual(&pencil, &basis) < 1e-8);
        }
    }

    #[test]
    fn a_small_eigenvalue_is_not_zero() {
        // The search for the lift ends far above the first eigenvalue.
        let stiffness =
            SymmetricSparse::from_entries(2, [(0, 0, 1e8 + 0.5), (1, 1, 1e8 + 0.5), (0, 1, 0.5 - 1e8)])
                .unwrap();
        let pencil = Pencil::new(&stiffness, &[1.0; 2]).unwrap();
        for harmonics in [1, 2] {
            let first = solved(&pencil, harmonics).eigenvalues[0];
            assert!((first - 1.0).abs() < 1e-6, "{first}");
        }
    }

    #[test]
    fn a_light_part_makes_no_other_eigenvalue_zero_and_no_negative_one_pass() {
        let sphere = Operator::of(&samples::icosphere(3)).unwrap();
        let n = sphere.vertices();
        let column = |v: usize| sphere.stiffness.column(v).filter(move |(i, _)| *i >= v);
        let entries = (0..n).flat_map(|v| column(v).map(move |(i, s)| (i, v, s)));
        let stiffness = SymmetricSparse::from_entries(n + 1, entries.chain([(n, n, 1.0)])).unwrap();
        let mass: Vec<f64> = sphere.mass.iter().copied().chain([1e-14]).collect();
        let pencil = Pencil::new(&stiffness, &mass).unwrap();
        let (basis, _) = pencil.solve(&BasisSettings::new(10), &Task::new()).unwrap();
        let alone = solved(&sphere.pencil(), 10);
        for (value, exact) in basis.eigenvalues.iter().zip(&alone.eigenvalues) {
            assert!((value - exact).abs() < 1e-4, "{value} for {exact}");
        }
        // A negative one beside a mass matrix that is nearly singular.
        let c = 1.0 - 1e-9;
        let stiffness = SymmetricSparse::from_entries(3, [(0, 0, -0.1), (1, 1, 1.0), (2, 2, 1.0)]).unwrap();
        let mass =
            SymmetricSparse::from_entries(3, [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (2, 1, c)]).unwrap();
        let pencil = ConsistentPencil::new(&stiffness, &mass).unwrap();
        let refused = pencil.solve(&BasisSettings::new(2), &Task::new()).unwrap_err().to_string();
        assert!(refused.contains("negative eigenvalues"), "{refused}");
    }

    #[test]
    fn the_certificate_of_a_dense_solve_tells_what_the_first_eigenvalues_are_worth() {
        // A path whose masses differ by up to 14 orders of magnitude. For the first of many pairs a dense solve is all there
        // is; for five it is the last resort.
        let n = 200;
        let entries = (1..n).flat_map(|v| [(v, v, 1.0), (v - 1, v - 1, 1.0), (v, v - 1, -1.0)]);
        let stiffness = SymmetricSparse::from_entries(n, entries).unwrap();
        for (decades, harmonics) in [(2.0, 5), (12.0, 120), (14.0, 5), (14.0, 120)] {
            let spread = |v: usize| decades * (0.618_033_988_749_895 * v as f64).fract() - 0.5 * decades;
            let mass: Vec<f64> = (0..n).map(|v| 10_f64.powf(spread(v))).collect();
            // The number of eigenvalues below x is that of the negative pivots of S − xM.
            let below = |x: f64| {
                let mut pivot = f64::INFINITY;
                let is_negative = |v: &usize| {
                    let degree = if *v == 0 || v + 1 == n { 1.0 } else { 2.0 };
                    pivot = degree - x * mass[*v] - 1.0 / pivot;
                    pivot < 0.0
                };
                (0..n).filter(is_negative).count()
            };
            let exact = |k: usize| {
                let (mut low, mut high) = (1e-20_f64, 1e20_f64);
                for _ in 0..100 {
                    let at = (low * high).sqrt();
                    (low, high) = if below(at) > k { (low, at) } else { (at, high) };
                }
                high
            };
            let pencil = Pencil::new(&stiffness, &mass).unwrap();
            let (basis, _) = pencil.solve(&BasisSettings::new(harmonics), &Task::new()).unwrap();
            let certificate = basis.certificate;
            assert_eq!(certificate.is_precise(), decades < 3.0, "{certificate:?}");
            for k in 1..5 {
                let (value, exact) = (basis.eigenvalues[k], exact(k));
                let stated = 2.0 * certificate.max_relative_residual.max(1e-9);
                assert!((value - exact).abs() <= stated * exact, "{value} for {exact}: {certificate:?}");
            }
        }
    }

    #[test]
    fn the_certificate_of_a_solve_in_slices_is_that_of_a_small_first_eigenvalue_too() {
        // Two paths of unit springs that a weak spring joins.
        let (n, weak) = (800, 1e-9);
        let spring = |v: usize| if v == n / 2 { weak } else { 1.0 };
        let entries = (1..n).flat_map(|v| {
            let s = spring(v);
            [(v, v, s), (v - 1, v - 1, s), (v, v - 1, -s)]
        });
        let stiffness = SymmetricSparse::from_entries(n, entries).unwrap();
        let mass = vec![1.0; n];
        let pencil = Pencil::new(&stiffness, &mass).unwrap();
        let (basis, report) = pencil.solve(&BasisSettings::new(20), &Task::new()).unwrap();
        assert!(!report.fell_back_to_dense);
        // The halves move against each other.
        let (value, exact) = (basis.eigenvalues[1], weak * 4.0 / n as f64);
        let stated = basis.certificate.max_relative_residual;
        assert!((value - exact).abs() <= (1e-6 + 2.0 * stated) * exact, "{value} for {exact}: {stated}");
        assert!(stated > REPORTED_RESIDUAL && stated < 0.1 && !basis.certificate.is_precise(), "{stated}");
    }

    #[test]
    fn the_measurement_of_residuals_can_be_cancelled() {
        let sphere = Operator::of(&samples::icosphere(1)).unwrap();
        let (pencil, task) = (sphere.pencil(), Task::new());
        let basis = solved(&pencil, 5);
        assert!(residual(&pencil, 1, &basis, &task).unwrap() < REPORTED_RESIDUAL);
        task.cancel();
        assert!(matches!(residual(&pencil, 1, &basis, &task), Err(HarmonicsError::Cancelled(_))));
    }

    #[test]
    fn twelve_equal_spheres_are_solved_part_by_part() {
        let sphere = Operator::of(&samples::icosphere(4)).unwrap();
        let (n, copies) = (sphere.vertices(), 12);
        let entries = (0..n * copies).flat_map(|v| {
            let (first, j) = (v / n * n, v % n);
            sphere.stiffness.column(j).filter(move |(i, _)| *i >= j).map(move |(i, s)| (first + i, v, s))
        });
        let stiffness = SymmetricSparse::from_entries(n * copies, entries).unwrap();
        let mass = sphere.mass.repeat(copies);
        let pencil = Pencil::new(&stiffness, &mass).unwrap();
        // K cuts the last group of equal eigenvalues; before that, the group is solved as a whole.
        let basis = solved(&pencil, 150);
        let alone = solved(&sphere.pencil(), 16);
        assert!(basis.eigenvalues[..copies].iter().all(|value| *value == 0.0));
        for (k, value) in basis.eigenvalues.iter().enumerate() {
            let exact = alone.eigenvalues[k / copies];
            assert!((value - exact).abs() <= 1e-9 * exact, "{k}: {value} for {exact}");
        }
        assert!(worst_residual(&pencil, &basis) < 1e-8);
    }

    #[test]
    fn what_is_no_pencil_is_refused() {
        let refused = |stiffness: &SymmetricSparse, mass: &[f64]| match Pencil::new(stiffness, mass) {
            Ok(pencil) => pencil.solve(&BasisSettings::new(1), &Task::new()).unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        let two = SymmetricSparse::from_entries(2, [(0, 0, 1.0), (1, 1, 1.0)]).unwrap();
        assert!(refused(&two, &[1.0]).contains("S has 2 rows and M has 1"));
        assert!(refused(&two, &[1.0, 0.0]).contains("value 1 of M is 0"));
        let indefinite = SymmetricSparse::from_entries(2, [(0, 0, 1.0), (0, 1, 2.0), (1, 1, 1.0)]).unwrap();
        let indefinite_refused = refused(&indefinite, &[1.0; 2]);
        assert!(indefinite_refused.starts_with("S has 1 negative eigenvalues"), "{indefinite_refused}");
        assert!(!indefinite_refused.contains("-S"), "{indefinite_refused}");
        let other_sign = SymmetricSparse::from_entries(2, [(0, 0, -1.0), (0, 1, 1.0), (1, 1, -1.0)]).unwrap();
        assert!(refused(&other_sign, &[1.0; 2]).contains("-S is what"));
        let mut slanted = indefinite.clone();
        slanted.values[1] = 0.5;
        assert!(refused(&slanted, &[1.0; 2]).contains("not symmetric"));
        assert!(SymmetricSparse::from_entries(2, [(0, 2, 1.0)]).is_err());
        assert!(SymmetricSparse::from_entries(1, [(0, 0, f64::NAN)]).is_err());
        let nothing = SymmetricSparse::from_entries(3, []).unwrap();
        assert_eq!(solved(&Pencil::new(&nothing, &[1.0; 3]).unwrap(), 3).eigenvalues, [0.0; 3]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]
        #[test]
        fn a_random_gram_matrix_is_solved_as_a_dense_one(
            rows in prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, 12), 5..20),
            mass in prop::collection::vec(0.1..10.0_f64, 12),
        ) {
            // S = BᵀB, whose rank is at most the number of rows of B.
            let entry = |i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
            let entries = (0..12).flat_map(|i| (0..=i).map(move |j| (i, j)));
            let stiffness =
                SymmetricSparse::from_entries(12, entries.map(|(i, j)| (i, j, entry(i, j)))).unwrap();
            let pencil = Pencil::new(&stiffness, &mass).unwrap();
            let (basis, _) = pencil.solve(&BasisSettings::new(12), &Task::new()).unwrap();
            let dense = super::super::dense::symmetrized(pencil);
            let (exact, _) = crate::symmetric_eigen::symmetric_eigen(&dense, faer::Par::Seq).unwrap();
            let largest = exact[11];
            for (value, exact) in basis.eigenvalues.iter().zip(&exact) {
                prop_assert!((value - exact).abs() < 1e-9 * largest, "{} {}", value, exact);
            }
            prop_assert!(worst_residual(&pencil, &basis) < 1e-8);
        }
    }
}
