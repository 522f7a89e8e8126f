//! Transfers the difference between two shapes to a third.

use chladni_mesh::TriMesh;
use chladni_mesh::surface::Bounds;
use chladni_mesh::surface::vec3::distance;
use chladni_task::Task;

use crate::correspondence::has_same_vertices;
use crate::infill::rest_off_surface;
use crate::{
    Correspondence, MatchError, MatchReport, MatchSettings, Method, Scaling, Similarity, infilled,
    match_shapes,
};

/// A shape to which a difference, such as an expression or a caricature, was transferred.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// The new positions of the n vertices of the target, in its own coordinates.
    pub positions: Vec<[f64; 3]>,
    /// The confidence in each vertex's match with the neutral shape, in [0, 1].
    pub confidence: Vec<f64>,
    /// How well the target and the neutral shape match. Its warnings begin with those about the neutral shape and the
    /// expression.
    pub report: MatchReport,
}

/// Transfers the difference between `neutral` and `expression` to `target`.
///
/// If `neutral` and `expression` have the same polygons, or the same triangles in whatever order, the difference is
/// that of their vertices as stored in the files, with a warning where most of that is another place, pose or size;
/// otherwise it is that of a match, without the differences of position, pose and size. `target` is matched with
/// `neutral` as `settings` say. Each vertex of `target` takes the difference at its point of the neutral shape, rotated
/// and scaled by the similarity that brings the neutral shape to the target. Where that match is not trusted, the
/// difference is filled in from its surroundings ([`infilled`]). A vertex of `target` that no triangle uses, and that
/// has no partner, stays where it is.
///
/// # Errors
/// Those of [`match_shapes`].
pub fn transfer(
    neutral: &TriMesh,
    expression: &TriMesh,
    target: &TriMesh,
    settings: &MatchSettings,
    task: &Task,
) -> Result<Transfer, MatchError> {
    let (difference, warnings) = difference(neutral, expression, settings, task)?;
    let mut found = match_shapes(target, neutral, settings, task)?;
    found.report.warnings.splice(..0, warnings);
    let Correspondence { on_template, similarity, confidence, .. } = &found.correspondence;
    let still = similarity.apply([0.0; 3]);
    let turned = |d: [f64; 3]| -> [f64; 3] {
        let at = similarity.apply(d);
        std::array::from_fn(|i| at[i] - still[i])
    };
    let on = on_template.as_ref().ok_or(MatchError::NoSurface(crate::Side::Template))?;
    let moved = |(p, on): (&[f64; 3], &chladni_mesh::surface::SurfacePoint)| {
        let at = on.position(&neutral.triangles, |v| difference[v as usize]).unwrap_or([0.0; 3]);
        let by = turned(at);
        std::array::from_fn(|i| p[i] + by[i])
    };
    let positions: Vec<[f64; 3]> = target.positions.iter().zip(on).map(moved).collect();
    let direct = Correspondence::direct(positions, confidence.clone());
    let filled = infilled(target, &direct)?;
    let mut positions = filled.map_or(direct.target, |filled| filled.target);
    rest_off_surface(target, &direct.confidence, &mut positions);
    Ok(Transfer { positions, confidence: direct.confidence, report: found.report })
}

/// The displacement of each vertex of `neutral` that makes it `expression`, in the coordinates of
/// `neutral`, and the warnings of their match.
fn difference(
    neutral: &TriMesh,
    expression: &TriMesh,
    settings: &MatchSettings,
    task: &Task,
) -> Result<(Vec<[f64; 3]>, Vec<String>), MatchError> {
    let less = |(x, r): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| r[i] - x[i]);
    if has_same_vertices(neutral, expression) {
        let between = neutral.positions.iter().zip(&expression.positions);
        return Ok((between.map(less).collect(), stands_apart(neutral, expression).into_iter().collect()));
    }
    // Landmarks, and vertices in the same order, are of the target and the neutral shape.
    let method = match settings.method {
        Method::Map | Method::Same => Method::Fit,
        method => method,
    };
    let settings = MatchSettings { landmarks: Vec::new(), method, ..settings.clone() };
    let found = match_shapes(neutral, expression, &settings, task)?;
    let named = |w: &String| format!("the neutral shape, matched with the expression as its template: {w}");
    let warnings = found.report.warnings.iter().map(named).collect();
    let target =
        infilled(neutral, &found.correspondence)?.map_or(found.correspondence.target, |filled| filled.target);
    Ok((neutral.positions.iter().zip(&target).map(less).collect(), warnings))
}

/// The least mean displacement, as a share of the diagonal, that is taken for another pose: faces hardly move as far.
const APART: f64 = 0.03;

/// A warning where a similarity alone accounts for most of what moves the vertices of `neutral` to those of `expression`,
/// which then are in another unit or pose.
fn stands_apart(neutral: &TriMesh, expression: &TriMesh) -> Option<String> {
    let (from, to) = (&neutral.positions, &expression.positions);
    let similarity = Similarity::fit(from, to, None, Scaling::Free).ok()?;
    let rms = |squares: f64| (squares / from.len().max(1) as f64).sqrt();
    let whole = rms(from.iter().zip(to).map(|(a, b)| distance(*a, *b).powi(2)).sum());
    let left = rms(from.iter().zip(to).map(|(a, b)| distance(similarity.apply(*a), *b).powi(2)).sum());
    let is_far = whole > APART * Bounds::of(from.iter().copied()).diagonal();
    if !is_far || left >= 0.5 * whole {
        return None;
    }
    let what = match similarity.scale {
        scale if scale > 3.0 => format!("is about {scale:.0} times larger than the neutral shape"),
        scale if scale < 1.0 / 3.0 => {
            format!("is about {:.0} times smaller than the neutral shape", 1.0 / scale)
        }
        _ => "has another place, pose or size than the neutral shape".to_owned(),
    };
    Some(format!(
        "the expression {what}, which counts as movement: bring both into one unit and pose unless that is meant"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::samples::{sample, torus};

    /// A grimace: the front of the face moves down and out, and parts farther forward move more.
    fn grimace(p: &[f64; 3]) -> [f64; 3] {
        let front = ((p[2] - 0.3) / 0.5).clamp(0.0, 1.0);
        let below = ((-0.3 - p[1]) / 0.4).clamp(0.0, 1.0);
        [0.0, -0.12 * front * below, 0.04 * front * below]
    }

    fn moved(mesh: &TriMesh) -> TriMesh {
        let positions = mesh.positions.iter().map(|p| {
            let d = grimace(p);
            std::array::from_fn(|i| p[i] + d[i])
        });
        TriMesh { positions: positions.collect(), ..mesh.clone() }
    }

    #[test]
    fn of_the_same_triangles_the_answer_is_exact_in_any_pose_and_size() {
        let neutral = sample("template").unwrap();
        let mut expression = moved(&neutral);
        // As exporters do that group triangles by material.
        expression.triangles.reverse();
        expression.triangles.iter_mut().for_each(|t| t.rotate_left(1));
        // The target is the neutral head, three times as large and turned on its side.
        let pose = |p: &[f64; 3]| [3.0 * p[1] + 5.0, -3.0 * p[0], 3.0 * p[2] - 1.0];
        let posed =
            |mesh: &TriMesh| TriMesh { positions: mesh.positions.iter().map(pose).collect(), ..mesh.clone() };
        let settings = MatchSettings { method: Method::Same, ..MatchSettings::default() };
        let found = transfer(&neutral, &expression, &posed(&neutral), &settings, &Task::new()).unwrap();
        for (found, expected) in found.positions.iter().zip(posed(&expression).positions) {
            assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-9));
        }
    }

    #[test]
    fn an_expression_in_another_unit_or_pose_is_warned_of_and_no_other() {
        let neutral = torus(0.4, 24, 12);
        let by = |change: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let positions = neutral.positions.iter().map(|p| change(*p)).collect();
            stands_apart(&neutral, &TriMesh { positions, ..neutral.clone() }).unwrap_or_default()
        };
        let bent = |[x, y, z]: [f64; 3]| [x, y + 0.3 * x * x, z - 0.1 * y];
        let [larger, smaller] = [10.0_f64, 0.1].map(|unit| {
            by(&|p| {
                let [x, y, z] = bent(p);
                [unit * x + 3.0, unit * y, unit * z]
            })
        });
        assert!(
            larger.contains("10 times larger") && smaller.contains("10 times smaller"),
            "{larger} {smaller}"
        );
        assert!(by(&|p| [p[1], -p[0], p[2]]).contains("another place, pose or size"));
        // Whatever changes the form, and what moves no farther than a nod.
        for said in [by(&bent), by(&|[x, y, z]| [x + 0.02, y, z]), by(&|[x, y, z]| [x, 1.5 * y, z])] {
            assert!(said.is_empty(), "{said}");
        }
    }

    /// The expression has its vertices in another order, which only a match by shape can find.
    #[test]
    fn an_expression_of_other_triangles_is_matched_by_its_shape_whatever_leads_the_target() {
        let neutral = sample("template").unwrap();
        let n = neutral.positions.len() as u32;
        let mut expression = moved(&neutral);
        expression.positions.reverse();
        expression.triangles.iter_mut().flatten().for_each(|v| *v = n - 1 - *v);
        let settings = MatchSettings { method: Method::Same, ..MatchSettings::default() };
        let found = transfer(&neutral, &expression, &neutral, &settings, &Task::new()).unwrap();
        // Its vertices may slip along the face; they follow the grimace where there is one.
        let (mut along, mut whole) = (0.0, 0.0);
        for (x, found) in neutral.positions.iter().zip(&found.positions) {
            let d = grimace(x);
            along += (0..3).map(|i| (found[i] - x[i]) * d[i]).sum::<f64>();
            whole += d.iter().map(|d| d * d).sum::<f64>();
        }
        assert!((0.6..1.4).contains(&(along / whole)), "{along} of {whole}");
    }

    #[test]
    fn warnings_about_the_expression_are_heard_too() {
        let neutral = torus(0.4, 24, 12);
        let mut expression = neutral.clone();
        expression.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let settings = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
        let found = transfer(&neutral, &expression, &neutral, &settings, &Task::new()).unwrap();
        let first = &found.report.warnings[0];
        assert!(first.starts_with("the neutral shape, matched with the expression"), "{first}");
        let turned = |warning: &&String| warning.contains("faces of the template look inward");
        assert_eq!(found.report.warnings.iter().filter(turned).count(), 1);
    }

    #[test]
    fn a_vertex_of_the_target_that_no_triangle_uses_stays() {
        let (neutral, mut target) = (torus(0.4, 24, 12), torus(0.4, 24, 12));
        let positions = neutral.positions.iter().map(|[x, y, z]| [*x + 0.1 * y, *y, *z]).collect();
        let expression = TriMesh { positions, ..neutral.clone() };
        target.positions.push([0.1, 0.9, 0.2]);
        let found =
            transfer(&neutral, &expression, &target, &MatchSettings::default(), &Task::new()).unwrap();
        assert_eq!(found.positions.last(), Some(&[0.1, 0.9, 0.2]));
    }

    #[test]
    fn another_head_makes_the_same_grimace() {
        let (neutral, target) = (sample("template").unwrap(), sample("head").unwrap());
        let expected = moved(&target);
        let found =
            transfer(&neutral, &moved(&neutral), &target, &MatchSettings::default(), &Task::new()).unwrap();
        let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let error: f64 = found.positions.iter().zip(&expected.positions).map(|(a, b)| distance(a, b)).sum();
        let whole: f64 = target.positions.iter().zip(&expected.positions).map(|(a, b)| distance(a, b)).sum();
        assert!(error < 0.35 * whole, "{error} of {whole}");
        println!("off by {:.3} of the mean movement", error / whole);
    }

    /// What raises the back of a cat raises that of another one: longer, flatter, and with its vertices in another order.
    #[test]
    fn an_animal_moves_where_the_other_one_did_and_what_is_far_stays() {
        let neutral = sample("cat").unwrap();
        let stretch = |p: &[f64; 3]| [1.1 * p[0], 0.95 * p[1], 1.05 * p[2]];
        let n = neutral.positions.len() as u32;
        let target = TriMesh {
            positions: neutral.positions.iter().rev().map(stretch).collect(),
            triangles: neutral.triangles.iter().map(|t| t.map(|v| n - 1 - v)).collect(),
            ..TriMesh::default()
        };
        let top = neutral.positions.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
        let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let size = Bounds::of(neutral.positions.iter().copied()).diagonal();
        let bump = |p: &[f64; 3]| {
            let near = (1.0 - distance(p, &top) / (0.2 * size)).max(0.0);
            [0.0, 0.1 * size * near, 0.0]
        };
        let plus = |p: &[f64; 3], d: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] + d[i]) };
        let raised: Vec<[f64; 3]> = neutral.positions.iter().map(|p| plus(p, bump(p))).collect();
        let expression = TriMesh { positions: raised, ..neutral.clone() };
        let found =
            transfer(&neutral, &expression, &target, &MatchSettings::default(), &Task::new()).unwrap();
        assert!(found.positions.iter().flatten().all(|x| x.is_finite()));
        let moved = found.positions.iter().zip(&target.positions).map(|(a, b)| distance(a, b));
        let known = neutral.positions.iter().rev().map(bump);
        let (mut error, mut whole, mut elsewhere) = (0.0, 0.0, 0.0_f64);
        for ((found, p), (by, moved)) in found.positions.iter().zip(&target.positions).zip(known.zip(moved)) {
            error += distance(found, &plus(p, by));
            whole += by[1];
            if distance(p, &stretch(&top)) > 0.35 * size {
                elsewhere = elsewhere.max(moved);
            }
        }
        println!("off by {:.3} of the mean movement", error / whole);
        assert!(error < 0.35 * whole, "{error} of {whole}");
        assert!(elsewhere < 0.01 * size, "{elsewhere} of {size}");
    }

    /// A cat has no human mouth: what it is given is bounded, and the report does not call it a good match.
    #[test]
    fn a_grimace_on_an_animal_is_finite_and_no_larger_than_on_the_head() {
        let (neutral, target) = (sample("template").unwrap(), sample("cat").unwrap());
        let found =
            transfer(&neutral, &moved(&neutral), &target, &MatchSettings::default(), &Task::new()).unwrap();
        let size = |mesh: &TriMesh| Bounds::of(mesh.positions.iter().copied()).diagonal();
        let most = neutral.positions.iter().map(grimace).map(|d| d[1].hypot(d[2])).fold(0.0, f64::max);
        let most = most * size(&target) / size(&neutral);
        let far = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let farthest = found.positions.iter().zip(&target.positions).map(far).fold(0.0, f64::max);
        assert!(found.positions.iter().flatten().all(|x| x.is_finite()));
        assert!(farthest > 0.05 * most && farthest < 2.0 * most, "{farthest} of {most}");
    }

    /// Two identities of one face model, whose vertices correspond by number: that is the answer, which a match by shape
    /// alone is to find.
    #[test]
    fn another_identity_of_a_face_model_makes_the_same_face() {
        let [Some(neutral), Some(target)] = ["generic_neutral_mesh", "identity005"]
            .map(|name| chladni_testdata::shared(&format!("meshes/heads/{name}.obj")))
        else {
            return;
        };
        let [neutral, target] = [neutral, target].map(|path| chladni_mesh::load_mesh(&path).unwrap().mesh);
        let size = 0.5 * Bounds::of(neutral.positions.iter().copied()).diagonal();
        let center = chladni_mesh::Frame::of(&neutral).center;
        let expression = TriMesh {
            positions: neutral
                .positions
                .iter()
                .map(|p| {
                    let d = grimace(&std::array::from_fn(|i| 1.7 * (p[i] - center[i]) / size));
                    std::array::from_fn(|i| p[i] + 0.6 * size * d[i])
                })
                .collect(),
            ..neutral.clone()
        };
        let by = |method| {
            let settings = MatchSettings { method, ..MatchSettings::default() };
            transfer(&neutral, &expression, &target, &settings, &Task::new()).unwrap().positions
        };
        let (answer, found) = (by(Method::Same), by(Method::Fit));
        let mean = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt())
                .sum::<f64>()
        };
        let (error, whole) = (mean(&found, &answer), mean(&target.positions, &answer));
        println!("identity005: off by {:.3} of the mean movement", error / whole);
        assert!(error < 0.35 * whole, "{error} of {whole}");
    }
}
