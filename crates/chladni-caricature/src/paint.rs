//! Painting χ01 on the surface.

use std::sync::Arc;

use chladni_mesh::surface::components;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::region::check_painted;
use crate::{Brush, CaricatureError, Painted, Reach, Surface, SurfacePoint};

/// One change to a painted region. Replaying the same edits on the same surface gives the same
/// region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PaintEdit {
    /// A press of the brush.
    Dab(Dab),
    /// Everything connected with this point.
    FillComponent {
        /// Where it was clicked.
        at: SurfacePoint,
        /// The value that the component takes, in [0, 1].
        intensity: f32,
    },
    /// Each vertex takes the largest value among its neighbors.
    Grow,
    /// Each vertex takes the smallest value among its neighbors.
    Shrink,
    /// Each vertex takes the mean over the corners of its triangles.
    Smooth,
    /// χ01 becomes 1 − χ01.
    Invert,
    /// χ01 becomes 0.
    Clear,
    /// The whole region at once.
    Set(Painted),
}

/// One press of the brush. It lists the vertices that it covered on the displayed shape, so later changes to
/// the layers below do not affect it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dab {
    /// The vertices under the brush, each < N.
    pub vertices: Vec<u32>,
    /// How much of the intensity each of them gets, in [0, 1]; empty where all get all of it, as from a hard brush.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<f32>,
    /// In [0, 1]: painting raises χ01 to it, erasing lowers χ01 to 1 − it. Passing over the same
    /// place again changes nothing, also with a soft brush.
    pub intensity: f32,
    /// Whether to erase.
    pub erase: bool,
}

impl PaintEdit {
    /// Edits with `brush` that fill everything that is connected with a place, and with its mirror image where the brush
    /// mirrors.
    pub fn fills(
        brush: &Brush,
        at: SurfacePoint,
        surface: &Surface,
        intensity: f32,
    ) -> impl Iterator<Item = Self> {
        let twin = brush.twin(&at, surface);
        std::iter::once(at).chain(twin).map(move |at| Self::FillComponent { at, intensity })
    }

    /// The region after this edit. A first dab or fill on a region that is everywhere starts from an empty
    /// one, unless it erases: painting means choosing where.
    ///
    /// # Errors
    /// A region of another shape, an intensity outside [0, 1], a vertex that is not there.
    pub fn apply(&self, painted: &Painted, surface: &Surface) -> Result<Painted, CaricatureError> {
        // These replace a region, even one of another shape.
        match self {
            Self::Set(whole) => {
                if let Painted::Vertices(values) = whole {
                    check_painted(values.len(), surface.vertices())?;
                }
                return Ok(whole.clone());
            }
            Self::Clear => return Ok(Painted::Vertices(vec![0.0; surface.vertices()].into())),
            _ => {}
        }
        let mut values = match (painted, self) {
            (Painted::Everywhere, Self::Dab(dab)) if !dab.erase => vec![0.0; surface.vertices()],
            (Painted::Everywhere, Self::FillComponent { intensity, .. }) if *intensity > 0.0 => {
                vec![0.0; surface.vertices()]
            }
            (Painted::Spheres(_), _) => painted.values(&surface.file_positions()).to_vec(),
            (Painted::Everywhere, _) => vec![1.0; surface.vertices()],
            (Painted::Vertices(values), _) => values.to_vec(),
        };
        check_painted(values.len(), surface.vertices())?;
        match self {
            Self::Dab(dab) => dab.paint(&mut values)?,
            Self::FillComponent { at, intensity } => {
                check_intensity(*intensity)?;
                component(surface, at).into_iter().for_each(|v| values[v as usize] = *intensity);
            }
            Self::Grow => values = ring(surface, &values, f32::max),
            Self::Shrink => values = ring(surface, &values, f32::min),
            Self::Smooth => values = means(surface, &values),
            Self::Invert => values.iter_mut().for_each(|x| *x = 1.0 - *x),
            Self::Clear | Self::Set(_) => {}
        }
        Ok(Painted::Vertices(Arc::from(values)))
    }
}

impl PaintEdit {
    /// A click on the parts `taken`, where each vertex lies in one of the parts `of`: they become the region, or, with
    /// `besides`, are added to it; `erase` takes them away.
    pub fn taking(taken: &[usize], of: &[u32], besides: bool, erase: bool) -> Self {
        let belongs = |part: &u32| taken.contains(&(*part as usize));
        if erase || besides {
            let vertices = (0..).zip(of).filter(|(_, part)| belongs(part)).map(|(v, _)| v).collect();
            return Self::Dab(Dab::even(vertices, 1.0, erase));
        }
        Self::Set(Painted::Vertices(of.iter().map(|part| f32::from(u8::from(belongs(part)))).collect()))
    }

    /// The same where only this much of the layer acts, in [0, 1]: a dab has this intensity, and the values of a region that
    /// is set are multiplied by it. Other edits stay as they are.
    #[must_use]
    pub fn with_intensity(self, intensity: f32) -> Self {
        match self {
            Self::Dab(dab) => Self::Dab(Dab { intensity, ..dab }),
            Self::Set(Painted::Vertices(values)) => {
                Self::Set(Painted::Vertices(values.iter().map(|x| x * intensity).collect()))
            }
            other => other,
        }
    }
}

impl Dab {
    /// A press of the brush that covers what `reach` shows.
    pub fn of(reach: &Reach, intensity: f32, erase: bool) -> Self {
        Self { weights: reach.weights(), ..Self::even(reach.vertices(), intensity, erase) }
    }

    /// The same intensity for all `vertices`.
    pub fn even(vertices: Vec<u32>, intensity: f32, erase: bool) -> Self {
        Self { vertices, weights: Vec::new(), intensity, erase }
    }

    fn paint(&self, values: &mut [f32]) -> Result<(), CaricatureError> {
        check_intensity(self.intensity)?;
        let (found, expected) = (self.weights.len(), self.vertices.len());
        if found != 0 && found != expected {
            return Err(CaricatureError::VertexCount { what: "the brush's weights", found, expected });
        }
        let weights = self.weights.iter().copied().chain(std::iter::repeat(1.0));
        for (v, weight) in self.vertices.iter().zip(weights) {
            let Some(x) = values.get_mut(*v as usize) else {
                let (what, range) = ("a painted vertex", "one of the shape's");
                return Err(CaricatureError::Range { what, value: f64::from(*v), range });
            };
            if !(0.0..=1.0).contains(&weight) {
                let (what, range) = ("a weight of the brush", "0 to 1");
                return Err(CaricatureError::Range { what, value: f64::from(weight), range });
            }
            let share = weight * self.intensity;
            *x = if self.erase { x.min(1.0 - share) } else { x.max(share) };
        }
        Ok(())
    }
}

fn check_intensity(intensity: f32) -> Result<(), CaricatureError> {
    if (0.0..=1.0).contains(&intensity) {
        Ok(())
    } else {
        Err(CaricatureError::Range {
            what: "the brush's intensity",
            value: f64::from(intensity),
            range: "0 to 1",
        })
    }
}

/// All vertices connected with the triangle of `at`.
fn component(surface: &Surface, at: &SurfacePoint) -> Vec<u32> {
    let Some([first, ..]) = surface.triangles.get(at.triangle as usize) else { return Vec::new() };
    let component = components(surface.vertices(), &surface.triangles);
    let own = component.get(*first as usize);
    component.iter().zip(0..).filter(|(c, _)| Some(*c) == own).map(|(_, v)| v).collect()
}

/// Each vertex with the values of its one-ring folded in.
fn ring(surface: &Surface, values: &[f32], fold: fn(f32, f32) -> f32) -> Vec<f32> {
    (0..values.len())
        .into_par_iter()
        .map(|v| {
            let around = surface.triangles_around(v as u32).iter();
            let neighbors = around.flat_map(|t| surface.triangles[*t as usize]).map(|w| values[w as usize]);
            neighbors.fold(values[v], fold)
        })
        .collect()
}

/// For each vertex the mean over the corners of its triangles; its own value where it has none.
fn means(surface: &Surface, values: &[f32]) -> Vec<f32> {
    (0..values.len())
        .into_par_iter()
        .map(|v| {
            let around = surface.triangles_around(v as u32);
            let corners = around.iter().flat_map(|t| surface.triangles[*t as usize]);
            let sum: f32 = corners.map(|w| values[w as usize]).sum();
            if around.is_empty() { values[v] } else { sum / (3 * around.len()) as f32 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seen;
    use crate::fixture::{bumpy_sphere, icosphere};
    use chladni_mesh::MirrorPlane;
    use chladni_mesh::surface::vec3::{Vec3, add, single};

    fn count(painted: &Painted, surface: &Surface) -> (usize, f32) {
        let values = painted.values(&surface.file_positions());
        (values.iter().filter(|x| **x > 0.0).count(), values.iter().copied().fold(0.0, f32::max))
    }

    fn at(triangle: u32) -> SurfacePoint {
        SurfacePoint { triangle, weights: [1.0, 0.0, 0.0] }
    }

    fn dab(surface: &Surface, triangle: u32) -> Dab {
        brushed(surface, triangle, 1.0)
    }

    fn brushed(surface: &Surface, triangle: u32, hardness: f64) -> Dab {
        let positions = single(&surface.positions);
        let seen = Seen { surface, positions: &positions, eye: None, blocked: None };
        Dab::of(&Brush { radius: 0.3, hardness, mirror: None }.reach(&seen, &at(triangle)), 0.75, false)
    }

    #[test]
    fn a_region_of_another_shape_can_be_replaced_but_not_taken() {
        let (_, surface) = bumpy_sphere();
        let other = Painted::Vertices(vec![1.0; surface.vertices() + 1].into());
        assert!(PaintEdit::Grow.apply(&other, &surface).is_err());
        let everywhere = PaintEdit::Set(Painted::Everywhere).apply(&other, &surface).unwrap();
        assert_eq!(everywhere, Painted::Everywhere);
        assert_eq!(count(&PaintEdit::Clear.apply(&other, &surface).unwrap(), &surface).0, 0);
        assert!(PaintEdit::Set(other).apply(&Painted::Everywhere, &surface).is_err());
    }

    #[test]
    fn parts_are_taken_with_the_intensity_of_the_brush() {
        let taken = |besides: bool, erase: bool| {
            PaintEdit::taking(&[1], &[0, 1, 1], besides, erase).with_intensity(0.25)
        };
        let set = |values: [f32; 3]| PaintEdit::Set(Painted::Vertices(values.into()));
        assert_eq!(taken(false, false), set([0.0, 0.25, 0.25]));
        for erase in [false, true] {
            assert_eq!(taken(true, erase), PaintEdit::Dab(Dab::even(vec![1, 2], 0.25, erase)));
        }
        assert_eq!(PaintEdit::Clear.with_intensity(0.25), PaintEdit::Clear);
    }

    #[test]
    fn painting_twice_is_painting_once_and_erasing_undoes_it() {
        let (_, surface) = bumpy_sphere();
        let once = PaintEdit::Dab(dab(&surface, 7)).apply(&Painted::Everywhere, &surface).unwrap();
        let (touched, most) = count(&once, &surface);
        assert!(touched > 5 && touched < 300 && most == 0.75, "{touched}");
        assert_eq!(PaintEdit::Dab(dab(&surface, 7)).apply(&once, &surface).unwrap(), once);
        let eraser = Dab { erase: true, intensity: 1.0, ..dab(&surface, 7) };
        let gone = PaintEdit::Dab(eraser).apply(&once, &surface).unwrap();
        assert_eq!(count(&gone, &surface).0, 0);
        let beyond = Dab { vertices: vec![1_000_000], ..dab(&surface, 7) };
        assert!(PaintEdit::Dab(beyond).apply(&once, &surface).is_err());
        assert!(PaintEdit::Dab(Dab { intensity: 1.5, ..dab(&surface, 7) }).apply(&once, &surface).is_err());
    }

    #[test]
    fn dabs_of_a_soft_brush_do_not_add_up_and_fade_out_when_they_erase() {
        let (_, surface) = bumpy_sphere();
        let painted = |dabs: &[&Dab], start: &Painted| {
            dabs.iter().fold(start.clone(), |painted, dab| {
                PaintEdit::Dab((*dab).clone()).apply(&painted, &surface).unwrap()
            })
        };
        let values = |painted: &Painted| painted.values(&surface.file_positions()).to_vec();
        let (one, two) = (brushed(&surface, 7, 0.2), brushed(&surface, 8, 0.2));
        let weight = |dab: &Dab, v: u32| {
            dab.vertices.binary_search(&v).map_or(0.0, |at| dab.weights.get(at).copied().unwrap_or(1.0))
        };
        let stroke = painted(&[&one, &two, &one, &one, &two], &Painted::Everywhere);
        let mut between = 0;
        for (x, v) in values(&stroke).into_iter().zip(0..) {
            assert_eq!(x, 0.75 * weight(&one, v).max(weight(&two, v)), "{v}");
            between += usize::from(x > 0.0 && x < 0.75);
        }
        assert!(between > 5, "{between}");
        // An eraser of full intensity leaves what its edge does not reach.
        let eraser = Dab { intensity: 1.0, erase: true, ..one.clone() };
        for (x, v) in values(&painted(&[&eraser, &eraser], &Painted::Everywhere)).into_iter().zip(0..) {
            assert_eq!(x, 1.0 - weight(&one, v), "{v}");
        }
        for weights in [vec![0.5], vec![1.5; one.vertices.len()], vec![f32::NAN; one.vertices.len()]] {
            let wrong = Dab { weights, ..one.clone() };
            assert!(PaintEdit::Dab(wrong).apply(&Painted::Everywhere, &surface).is_err());
        }
    }

    #[test]
    fn a_hard_dab_is_written_as_before_and_an_old_one_is_read() {
        let old = r#"{"vertices":[3,5],"intensity":0.5,"erase":true}"#;
        let hard = Dab::even(vec![3, 5], 0.5, true);
        assert_eq!(serde_json::to_string(&hard).unwrap(), old);
        assert_eq!(serde_json::from_str::<Dab>(old).unwrap(), hard);
        let soft = Dab { weights: vec![1.0, 0.25], ..hard };
        assert_eq!(serde_json::from_str::<Dab>(&serde_json::to_string(&soft).unwrap()).unwrap(), soft);
    }

    #[test]
    fn grow_shrink_smooth_invert_and_clear() {
        let (_, surface) = bumpy_sphere();
        let once = PaintEdit::Dab(dab(&surface, 7)).apply(&Painted::Everywhere, &surface).unwrap();
        let grown = PaintEdit::Grow.apply(&once, &surface).unwrap();
        assert!(count(&grown, &surface).0 > count(&once, &surface).0);
        assert_eq!(PaintEdit::Shrink.apply(&grown, &surface).unwrap(), once);
        let twice = PaintEdit::Invert.apply(&PaintEdit::Invert.apply(&once, &surface).unwrap(), &surface);
        assert_eq!(twice.unwrap(), once);
        let smooth = PaintEdit::Smooth.apply(&once, &surface).unwrap();
        let (touched, most) = count(&smooth, &surface);
        assert!(touched > count(&once, &surface).0 && most <= 0.75);
        let values = smooth.values(&surface.file_positions());
        assert!(values.iter().any(|x| *x > 0.0 && *x < 0.75), "an edge in between");
        let whole = PaintEdit::Smooth.apply(&Painted::Everywhere, &surface).unwrap();
        assert!(whole.values(&surface.file_positions()).iter().all(|x| *x == 1.0));
        assert_eq!(count(&PaintEdit::Clear.apply(&once, &surface).unwrap(), &surface).0, 0);
    }

    /// Two balls with as many vertices each, the second of which is the first moved by 3 along x.
    fn two_balls() -> (Surface, usize) {
        let (points, triangles) = icosphere(2);
        let n = points.len() as u32;
        let two: Vec<Vec3> =
            points.iter().copied().chain(points.iter().map(|p| add(*p, [3.0, 0.0, 0.0]))).collect();
        let second = triangles.iter().map(|t| t.map(|v| v + n));
        let both: Vec<[u32; 3]> = triangles.iter().copied().chain(second).collect();
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        (Surface::of(two, both, frame), points.len())
    }

    #[test]
    fn a_component_is_filled_alone() {
        let (surface, n) = two_balls();
        // Painted on, only the component is in the region; painted away, only it is not.
        for intensity in [1.0, 0.0] {
            let fill = PaintEdit::FillComponent { at: at(3), intensity };
            let filled = fill.apply(&Painted::Everywhere, &surface).unwrap();
            let values = filled.values(&surface.positions);
            let expected = |v: usize| if v < n { intensity } else { 1.0 - intensity };
            assert!(values.iter().enumerate().all(|(v, x)| *x == expected(v)), "{intensity}");
        }
    }

    #[test]
    fn what_is_filled_is_filled_on_both_sides_of_a_mirror() {
        let (surface, n) = two_balls();
        let plane = MirrorPlane { normal: [1.0, 0.0, 0.0], offset: 1.5, misfit: 0.0 };
        for (mirror, expected) in [(None, n), (Some(plane), 2 * n)] {
            let brush = Brush { radius: 0.1, hardness: 1.0, mirror };
            let painted = PaintEdit::fills(&brush, at(3), &surface, 0.75)
                .try_fold(Painted::Everywhere, |painted, edit| edit.apply(&painted, &surface))
                .unwrap();
            assert_eq!(count(&painted, &surface), (expected, 0.75));
        }
    }
}
