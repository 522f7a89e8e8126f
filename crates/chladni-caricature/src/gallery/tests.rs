use std::sync::Arc;

use chladni_breeding::Genome;
use chladni_harmonics::{BasisSettings, Body};
use chladni_match::MatchSettings;
use chladni_mesh::ShapeSource;
use chladni_mesh::samples::{head_parts, icosphere, sample};
use chladni_mesh::surface::vec3::{distance, length};
use chladni_task::Task;

use super::*;
use crate::{HEAD_PARTS, MatchRequest, Painted, Project, Stack, Template};

/// The sample head against an ellipsoid and itself made smooth, with its known parts.
fn sitter() -> (Sitter, Stack) {
    let mesh = sample("head").unwrap();
    let body = Arc::new(Body::build(&mesh, &BasisSettings::new(64), &Task::new()).unwrap());
    let mut stack = Stack::new(body.clone()).unwrap();
    let matching = MatchSettings::default();
    let request = MatchRequest { template: Template::Ellipsoid, matching: matching.clone() };
    let matched = request.run(&mesh, &body, None, &Task::new());
    stack.install(request, matched);
    let known = head_parts("head", &mesh.positions).unwrap();
    let parts = HEAD_PARTS.iter().enumerate().map(|(i, name)| {
        let values = known.iter().map(|part| f32::from(u8::from(usize::from(*part) == i)));
        let Painted::Vertices(painted) = Painted::of_file(values, &body.operator_vertex) else {
            unreachable!()
        };
        SitterPart { name: (*name).to_owned(), painted }
    });
    let parts = parts.collect();
    let templates = [(Template::Ellipsoid, matching.clone()), (Template::LowPass(20), matching)];
    (Sitter::new(&stack, &templates, parts).unwrap(), stack)
}

#[test]
fn a_portrait_is_what_its_layers_give_and_hardly_folds() {
    let (sitter, mut stack) = sitter();
    let gallery = VariantGallery::new(5, &sitter).unwrap();
    let variants = gallery.variants();
    let portraits = sitter.portray(&variants).unwrap();
    let rest = stack.original().clone();
    for (variant, portrait) in variants.into_iter().zip(&portraits) {
        let mut project = Project::new(ShapeSource::Sample("head".into()), 64);
        for layer in &portrait.layers {
            project.push(layer.clone()).unwrap();
        }
        let result = stack.evaluate(&project).result;
        let moved =
            |a: &[[f64; 3]]| a.iter().zip(&rest.positions).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
        let far = moved(&result.positions);
        assert!(far > 0.02, "{}", sitter.title(variant));
        for (p, q) in portrait.positions.iter().zip(&result.positions) {
            let off = distance(p.map(f64::from), *q);
            assert!(off < 2e-3 * far, "{}: {off} of {far}", sitter.title(variant));
        }
        let folded = crate::flipped_triangles(stack.surface(), &rest.positions, &result.positions).len();
        assert!(folded as f64 <= MOST_FOLDS * stack.body().triangles.len() as f64, "{folded}");
        assert!(portrait.kept > 0.0 && portrait.kept <= 1.0);
    }
}

/// The least mean distance of two, each made as strong as the other.
fn least_distance(sitter: &Sitter, variants: &[&Variant]) -> f32 {
    let all: Vec<Descriptor> = variants.iter().map(|variant| sitter.describe(variant).unwrap()).collect();
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| all[i].distance(&all[j])).fold(f32::MAX, f32::min)
}

#[test]
fn the_first_twelve_differ_more_than_random_ones_and_children_resemble_their_parent() {
    let (sitter, _) = sitter();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let random: Vec<Variant> = (0..12).map(|_| Variant::random(10, 2, &mut rng)).collect();
    let mut gallery = VariantGallery::new(3, &sitter).unwrap();
    assert_eq!(gallery, VariantGallery::new(3, &sitter).unwrap());
    let ours = least_distance(&sitter, &gallery.variants());
    let theirs = least_distance(&sitter, &random.iter().collect::<Vec<_>>());
    assert!(ours > 1.5 * theirs, "{ours} against {theirs}");

    assert!(gallery.breed(&sitter).is_err(), "nothing is chosen");
    let liked = sitter.describe(gallery.variants()[4]).unwrap();
    let away = |gallery: &VariantGallery| -> f32 {
        gallery.variants().iter().map(|v| sitter.describe(v).unwrap().distance(&liked)).sum()
    };
    let before = away(&gallery);
    gallery.choose(4, true).unwrap();
    gallery.lock(Group::Parts, true);
    let parts = gallery.variants()[4].genes(Group::Parts).to_vec();
    gallery.breed(&sitter).unwrap();
    assert!(away(&gallery) < before);
    assert!(gallery.is_locked(Group::Parts));
    assert!(gallery.variants().iter().all(|variant| variant.genes(Group::Parts) == parts));
    gallery.favor(2, true).unwrap();
    let id = gallery.generations().items()[2].id;
    assert!(gallery.back() && !gallery.back() && gallery.is_favorite(id));
    let before = gallery.generations().items().to_vec();
    gallery.lock_place(7, true).unwrap();
    gallery.restart(4, &sitter).unwrap();
    let mut others = gallery.variants();
    others.remove(7);
    assert!(others.iter().all(|variant| variant.genes(Group::Parts) == parts));
    for (index, (item, old)) in gallery.generations().items().iter().zip(&before).enumerate() {
        let stays = item.id == old.id && item.genome == old.genome && item.locked;
        assert_eq!(stays, index == 7, "{index}");
        assert!(!item.chosen);
    }
}

#[test]
fn a_surprise_moves_the_shape_and_is_the_same_for_the_same_seed() {
    let (sitter, stack) = sitter();
    let (variant, portrait) = surprise(7, &sitter).unwrap();
    assert_eq!(variant, surprise(7, &sitter).unwrap().0);
    assert_ne!(variant, surprise(8, &sitter).unwrap().0);
    let far = portrait.positions.iter().zip(&stack.original().positions);
    let far = far.map(|(p, q)| length([0, 1, 2].map(|i| f64::from(p[i]) - q[i]))).fold(0.0, f64::max);
    assert!(far > 0.02 && portrait.folded as f64 <= MOST_FOLDS * stack.body().triangles.len() as f64);
}

/// A small shape made smooth by few harmonics, or by all that it has, where only the normal model finds a difference.
fn sitter_that_some_leave_still() -> Sitter {
    let mut mesh = icosphere(2);
    mesh.positions.iter_mut().for_each(|p| *p = [1.5 * p[0], p[1], 0.7 * p[2] + 0.3 * p[0] * p[0]]);
    let body = Body::build(&mesh, &BasisSettings::new(12), &Task::new()).unwrap();
    let stack = Stack::new(Arc::new(body)).unwrap();
    let templates = [4, 12].map(|k| (Template::LowPass(k), MatchSettings::default()));
    Sitter::new(&stack, &templates, Vec::new()).unwrap()
}

#[test]
fn children_and_changes_that_leave_the_shape_as_it_is_are_not_shown() {
    let sitter = sitter_that_some_leave_still();
    let is_still = |variant: &Variant| sitter.describe(variant).unwrap().is_still();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let random: Vec<Variant> = (0..400).map(|_| Variant::random(0, 2, &mut rng)).collect();
    let mut gallery = VariantGallery::new(1, &sitter).unwrap();

    let still = random.iter().find(|variant| is_still(variant)).unwrap();
    assert!(sitter.portray_one(still).unwrap().moved < 1e-4);
    gallery.generations.item_mut(0).unwrap().genome = still.clone();
    gallery.choose(0, true).unwrap();
    gallery.choose(1, true).unwrap();
    gallery.breed(&sitter).unwrap();
    assert!(!gallery.variants().into_iter().any(is_still));

    // One of whose changes many leave the shape as it is.
    let mut stilled =
        |variant: &Variant| (0..24).filter(|_| is_still(&variant.mutant(0.3, &mut rng))).count();
    let near =
        random.iter().find(|variant| !is_still(variant) && (6..16).contains(&stilled(variant))).unwrap();
    gallery.generations.item_mut(0).unwrap().genome = near.clone();
    for _ in 0..24 {
        gallery.mutate(0, &sitter).unwrap();
        assert!(!is_still(gallery.variants()[0]));
        assert!(gallery.back());
    }
}
