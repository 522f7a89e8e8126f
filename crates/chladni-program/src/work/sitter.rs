//! A shape ready to be caricatured by a gallery: its parts and its templates.

use std::sync::Arc;

use chladni_caricature::{
    HEAD_PARTS, HeadParts, Limbs, MatchRequest, Painted, Sitter, SitterPart, Stack, Template,
};
use chladni_harmonics::Basis;
use chladni_match::{Match, MatchSettings, Method, match_shapes};
use chladni_mesh::TriMesh;

use super::{Aside, Error, Watcher, body_of_limbs, matched, twins_of};

/// The sample that heads are matched with.
const HEAD: &str = "template";
/// A head that a gallery is bred from fits it at least so well before anything is bent: heads of the test data have 0.16 to
/// 0.24, a cow 0.30, a bust with its shoulders 0.34. Nobody looks at the parts of a gallery before they are used.
pub const HEADLIKE: f64 = 0.27;
/// The most parts that a variant stirs.
const MOST_PARTS: usize = 12;
/// Harmonics that the shape made smooth by itself keeps, coarse and fine.
const SMOOTH: [usize; 2] = [8, 30];

/// The shape of `stack`, whose file is `mesh`, with named parts where it is a head, else with its limbs. It is compared
/// with an ellipsoid, with itself made smooth, with a plain head where it is one, and with the template that is `given`.
/// Matching takes seconds to minutes; what `stack` has matched already is not matched again.
///
/// # Errors
/// A template that cannot be matched, [`Error::Cancelled`].
pub fn sitter(
    mesh: &TriMesh,
    stack: &mut Stack,
    given: Option<(Template, MatchSettings)>,
    watcher: &impl Watcher,
) -> Result<Sitter, Error> {
    let named = head(mesh, stack, watcher)?;
    let templates = all_templates(given, named.is_some(), smoothable(&stack.body().basis));
    let parts = match named {
        Some(parts) => parts,
        None => limbs(mesh, stack, watcher)?,
    };
    for (template, matching) in &templates {
        // Templates that are made from the shape itself need no match.
        let Some(request) = MatchRequest::with(template.clone(), matching.clone()) else { continue };
        if stack.matched(&request).is_some() {
            continue;
        }
        let body = stack.body().clone();
        let found = matched(&request, mesh, &body, watcher)?;
        stack.install(request, Ok(found));
    }
    Ok(Sitter::new(stack, &templates, parts)?)
}

/// The number of harmonics of a shape that can be made smooth; `None` where all are constants of its pieces, with which
/// no low-pass is possible.
fn smoothable(basis: &Basis) -> Option<usize> {
    let all = basis.harmonics();
    (all == 1 || basis.constants() < all).then_some(all)
}

/// The template that is `given`, a plain head where the shape is one, an ellipsoid, and the shape made smooth, where it
/// can be, of whose harmonics there are `all`: each only once, as few harmonics make all alike.
fn all_templates(
    given: Option<(Template, MatchSettings)>,
    is_head: bool,
    all: Option<usize>,
) -> Vec<(Template, MatchSettings)> {
    let usual = |template: Template| (template, MatchSettings::default());
    // Only a mesh is matched in more than one way.
    let given = given.map(|given| if given.0.is_mesh() { given } else { usual(given.0) });
    let head = is_head.then(|| Template::Sample(HEAD.into()));
    let smooth =
        all.into_iter().flat_map(|all| SMOOTH.map(|harmonics| Template::LowPass(harmonics.min(all))));
    let own = head.into_iter().chain([Template::Ellipsoid]).chain(smooth);
    let mut templates = Vec::new();
    for template in given.into_iter().chain(own.map(usual)) {
        if !templates.contains(&template) {
            templates.push(template);
        }
    }
    templates
}

/// The named parts of the head `mesh`, its match with the plain head, and the plain head; `None` if the misfit of `mesh` is
/// `most_misfit` or more, or another pose fits nearly as well. Takes seconds.
///
/// # Errors
/// A head that cannot be matched, [`Error::Cancelled`].
pub fn head_parts(
    mesh: &TriMesh,
    most_misfit: f64,
    watcher: &impl Watcher,
) -> Result<Option<(HeadParts, Match, TriMesh)>, Error> {
    let Some(plain) = chladni_mesh::samples::sample(HEAD) else { return Ok(None) };
    let rough = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
    let match_with = |settings: &MatchSettings| match_shapes(mesh, &plain, settings, watcher.task());
    let pose = watcher.watch("looking for a head", |_| match_with(&rough));
    watcher.task().check()?;
    let headlike =
        pose.is_ok_and(|pose| !pose.report.near_tie && pose.report.misfit.is_some_and(|m| m < most_misfit));
    if !headlike {
        return Ok(None);
    }
    let found = watcher.watch("finding the parts of the head", |_| match_with(&MatchSettings::default()));
    watcher.task().check()?;
    let found = found.map_err(|error| Error::input(error.to_string()))?;
    Ok(Some((HeadParts::of_match(mesh, &found)?, found, plain)))
}

/// The named parts of a head; `None` if it is not a head.
fn head(mesh: &TriMesh, stack: &mut Stack, watcher: &impl Watcher) -> Result<Option<Vec<SitterPart>>, Error> {
    let Some((parts, found, plain)) = head_parts(mesh, HEADLIKE, watcher)? else { return Ok(None) };
    let body = stack.body().clone();
    let request =
        MatchRequest { template: Template::Sample(HEAD.into()), matching: MatchSettings::default() };
    if stack.matched(&request).is_none() {
        let matched = request.of_match(found, mesh, &body, &plain, watcher.task())?;
        stack.install(request, Ok(matched));
    }
    let part = |name: &&str| {
        let painted = parts.painted(&body.operator_vertex, &[(*name).to_owned()])?;
        Ok(part((*name).to_owned(), painted))
    };
    let parts: Result<Vec<Option<SitterPart>>, Error> = HEAD_PARTS.iter().map(part).collect();
    Ok(Some(parts?.into_iter().flatten().collect()))
}

/// The limbs of any shape, mirror images together, the largest first: those that a click takes in the window, and that
/// `parts --level` prints. On the page they are those of the harmonics that it has, as for a click there.
fn limbs(mesh: &TriMesh, stack: &Stack, watcher: &impl Watcher) -> Result<Vec<SitterPart>, Error> {
    let own = stack.body();
    // The page has few harmonics where more would take long.
    let body = if cfg!(target_family = "wasm") {
        Arc::clone(own)
    } else {
        // Warnings of the mesh came with its own harmonics.
        watcher.watch("solving for the harmonics of limbs", |task| {
            body_of_limbs(own, ("the shape", mesh), &Aside::new(task))
        })?
    };
    let found = Limbs::of(&body, Limbs::USUAL_LEVEL);
    // A part that is the whole shape would only enlarge it.
    if found.parts.len() < 2 {
        return Ok(Vec::new());
    }
    let twins = twins_of(&found, &body, watcher)?;
    let mut parts = Vec::new();
    for (i, twin) in twins.iter().enumerate().filter(|(i, twin)| twin.is_none_or(|twin| twin > *i)) {
        let both: Vec<usize> = std::iter::once(i).chain(*twin).collect();
        let kind = if found.parts[i].is_trunk() { "trunk" } else { "part" };
        let name = both.iter().map(usize::to_string).collect::<Vec<_>>().join("+");
        parts.extend(part(format!("{kind} {name}"), found.painted(&both)));
    }
    parts.truncate(MOST_PARTS);
    Ok(parts)
}

/// `None` where nothing is painted.
fn part(name: String, painted: Painted) -> Option<SitterPart> {
    let Painted::Vertices(painted) = painted else { return None };
    painted.iter().any(|x| *x > 0.0).then(|| SitterPart { name, painted: Arc::clone(&painted) })
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_mesh::samples::{icosphere, sample};
    use chladni_task::Task;

    use super::*;
    use crate::work::Parts;

    #[test]
    fn a_bust_has_parts_for_a_person_to_look_at_but_none_for_a_gallery() {
        let Some(path) = chladni_testdata::shared("meshes/heads/demosthenes-low-res.obj") else { return };
        let (bust, task) = (chladni_mesh::load_mesh(&path).unwrap().mesh, Task::new());
        let found = |most_misfit| head_parts(&bust, most_misfit, &Aside::new(&task)).unwrap();
        assert!(found(HEADLIKE).is_none());
        let (parts, ..) = found(HeadParts::MOST_MISFIT).unwrap();
        let nose = HEAD_PARTS.iter().position(|name| *name == "nose").unwrap();
        assert!(parts.extent(nose).1 > Some(0.5) && !parts.report.warnings.is_empty());
    }

    fn kept(templates: &[(Template, MatchSettings)]) -> Vec<usize> {
        let smooth = |(template, _): &(Template, MatchSettings)| match template {
            Template::LowPass(harmonics) => Some(*harmonics),
            _ => None,
        };
        templates.iter().filter_map(smooth).collect()
    }

    #[test]
    fn a_shape_of_as_many_pieces_as_harmonics_is_not_made_smooth() {
        let (ball, task) = (icosphere(1), Task::new());
        let count = ball.positions.len() as u32;
        let mut mesh = ball.clone();
        mesh.positions.extend(ball.positions.iter().map(|[x, y, z]| [1.5 * x + 4.0, 1.5 * y, 1.5 * z]));
        mesh.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + count)));
        let smooth = |harmonics| {
            let body = Body::build(&mesh, &BasisSettings::new(harmonics), &task).unwrap();
            let stack = Stack::new(Arc::new(body)).unwrap();
            let templates = all_templates(None, false, smoothable(&stack.body().basis));
            for (template, matching) in &templates {
                let is_smooth = matches!(template, Template::LowPass(_));
                assert!(!is_smooth || stack.difference(template, matching).is_ok(), "{template}");
            }
            kept(&templates)
        };
        assert_eq!([1, 2, 3].map(smooth), [vec![1], vec![], vec![3]]);
    }

    #[test]
    fn a_shape_made_smooth_is_one_template_where_it_has_few_harmonics() {
        let kept = |given: Option<usize>, all: usize| {
            let given = given.map(|harmonics| (Template::LowPass(harmonics), MatchSettings::default()));
            kept(&all_templates(given, false, Some(all)))
        };
        assert_eq!(kept(None, 5), [5]);
        assert_eq!(kept(None, 96), [8, 30]);
        assert_eq!(kept(Some(8), 20), [8, 20]);
    }

    #[test]
    fn a_template_that_is_given_is_there_once() {
        let usual = MatchSettings::default();
        let icp = MatchSettings { method: Method::Icp, ..MatchSettings::default() };
        let head = Template::Sample(HEAD.into());
        let count = |template: &Template, matching: &MatchSettings| {
            let all = all_templates(Some((template.clone(), matching.clone())), true, Some(96));
            all.iter().filter(|(known, _)| known == template).count()
        };
        assert_eq!((count(&head, &usual), count(&Template::Ellipsoid, &usual)), (1, 1));
        // A mesh that is matched otherwise is another template; an ellipsoid knows one way only.
        assert_eq!((count(&head, &icp), count(&Template::Ellipsoid, &icp)), (2, 1));
    }

    /// The number that `parts --level` prints, from 0, and --limb takes.
    #[test]
    fn a_limb_has_one_number_wherever_it_is_named() {
        let (mesh, task) = (sample("octopus").unwrap(), Task::new());
        let [body, few] = [Limbs::HARMONICS, 12]
            .map(|harmonics| Arc::new(Body::build(&mesh, &BasisSettings::new(harmonics), &task).unwrap()));
        let stack = Stack::new(few).unwrap();
        let found = Limbs::of(&body, Limbs::USUAL_LEVEL);
        let of_page = Parts::at_level(&body, Limbs::USUAL_LEVEL, None).names;
        assert_eq!(of_page.len(), found.parts.len());
        let of_gallery = limbs(&mesh, &stack, &Aside::new(&task)).unwrap();
        assert!(of_gallery.len() > 1);
        for SitterPart { name, painted } in of_gallery {
            let (kind, numbers) = name.split_once(' ').unwrap();
            let numbers: Vec<usize> = numbers.split('+').map(|number| number.parse().unwrap()).collect();
            for number in &numbers {
                assert!(of_page[*number].starts_with(&format!("{kind} {number},")), "{name}: {of_page:?}");
            }
            assert_eq!(found.painted(&numbers), Painted::Vertices(painted), "{name}");
        }
    }
}
