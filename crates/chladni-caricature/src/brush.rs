//! Painting χ01 on the surface.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::vector::{Vec3, add, distance, dot, scale, sub};
use crate::{Error, Painted, Surface, SurfacePoint};

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
    /// Each vertex takes the largest value among its neighbours.
    Grow,
    /// Each vertex takes the smallest value among its neighbours.
    Shrink,
    /// χ01 becomes 1 − χ01.
    Invert,
    /// χ01 becomes 0.
    Clear,
    /// The whole region at once.
    Set(Painted),
}

/// One press of the brush: all that lies within `radius` along the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dab {
    /// The brush's centre.
    pub at: SurfacePoint,
    /// Radius along the surface, working frame.
    pub radius: f64,
    /// In [0, 1]: painting raises χ01 to it, erasing lowers χ01 to 1 − it. Passing over the same
    /// place again changes nothing.
    pub intensity: f32,
    /// Whether to erase.
    pub erase: bool,
    /// Paints the mirrored place too.
    pub mirror: Option<Mirror>,
}

/// A plane of symmetry, working frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mirror {
    /// A point of the plane.
    pub point: Vec3,
    /// Its unit normal.
    pub normal: Vec3,
}

impl Mirror {
    /// The mirror image of `p`.
    pub fn image(&self, p: Vec3) -> Vec3 {
        add(p, scale(self.normal, -2.0 * dot(sub(p, self.point), self.normal)))
    }

    /// The plane across x, y or z through the middle of the bounding box in which the surface
    /// comes closest to its own mirror image, and the mean distance between the two (working
    /// frame). Shapes that face no axis get a plane too, with a distance that tells.
    pub fn of(surface: &Surface) -> Option<(Self, f64)> {
        let bound = |pick: fn(f64, f64) -> f64, from: f64| {
            surface.positions.iter().fold([from; 3], |b, p| std::array::from_fn(|i| pick(b[i], p[i])))
        };
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        let point = scale(add(low, high), 0.5);
        let planes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|normal| Self { point, normal });
        let measured = planes.map(|plane| (plane, plane.asymmetry(surface)));
        measured.into_iter().filter(|m| m.1.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The mean distance of a few hundred mirrored vertices to the nearest vertex.
    fn asymmetry(&self, surface: &Surface) -> f64 {
        let stride = surface.vertices().div_ceil(300).max(1);
        let sample: Vec<Vec3> = surface.positions.iter().step_by(stride).map(|p| self.image(*p)).collect();
        let nearest =
            |p: &Vec3| surface.positions.iter().map(|q| distance(*p, *q)).fold(f64::INFINITY, f64::min);
        let distances: Vec<f64> = sample.par_iter().map(nearest).collect();
        distances.iter().sum::<f64>() / sample.len() as f64
    }
}

impl PaintEdit {
    /// The region after this edit. A first dab or fill on a region that is everywhere starts from
    /// an empty one, unless it erases: whoever paints wants to say where.
    pub fn apply(&self, painted: &Painted, surface: &Surface) -> Result<Painted, Error> {
        let mut values = match (painted, self) {
            (Painted::Everywhere, Self::Dab(dab)) if !dab.erase => vec![0.0; surface.vertices()],
            (Painted::Everywhere, Self::FillComponent { intensity, .. }) if *intensity > 0.0 => {
                vec![0.0; surface.vertices()]
            }
            (Painted::Spheres(_), _) => painted.values(&surface.file_positions()).to_vec(),
            (Painted::Everywhere, _) => vec![1.0; surface.vertices()],
            (Painted::Vertices(values), _) => values.to_vec(),
        };
        if values.len() != surface.vertices() {
            let (found, expected) = (values.len(), surface.vertices());
            return Err(Error::VertexCount { what: "the painted region", found, expected });
        }
        match self {
            Self::Dab(dab) => dab.paint(surface, &mut values)?,
            Self::FillComponent { at, intensity } => {
                check_intensity(*intensity)?;
                component(surface, at).into_iter().for_each(|v| values[v as usize] = *intensity);
            }
            Self::Grow => values = ring(surface, &values, f32::max),
            Self::Shrink => values = ring(surface, &values, f32::min),
            Self::Invert => values.iter_mut().for_each(|x| *x = 1.0 - *x),
            Self::Clear => values.fill(0.0),
            Self::Set(whole) => return Ok(whole.clone()),
        }
        Ok(Painted::Vertices(Arc::from(values)))
    }
}

impl Dab {
    fn paint(&self, surface: &Surface, values: &mut [f32]) -> Result<(), Error> {
        check_intensity(self.intensity)?;
        self.press(surface, &self.at, values);
        let image = self.mirror.and_then(|m| surface.position(&self.at).map(|p| m.image(p)));
        if let Some(twin) = image.and_then(|p| surface.nearest_vertex(p)) {
            self.press(surface, &twin, values);
        }
        Ok(())
    }

    fn press(&self, surface: &Surface, at: &SurfacePoint, values: &mut [f32]) {
        for (v, _) in surface.within(at, self.radius) {
            let x = &mut values[v as usize];
            *x = if self.erase { x.min(1.0 - self.intensity) } else { x.max(self.intensity) };
        }
    }
}

fn check_intensity(intensity: f32) -> Result<(), Error> {
    if (0.0..=1.0).contains(&intensity) {
        Ok(())
    } else {
        Err(Error::Range { what: "the brush's intensity", value: f64::from(intensity), range: "0 to 1" })
    }
}

/// All vertices connected with the triangle of `at`.
fn component(surface: &Surface, at: &SurfacePoint) -> Vec<u32> {
    let mut seen = vec![false; surface.vertices()];
    let mut found: Vec<u32> = Vec::new();
    let mut next: Vec<u32> =
        surface.triangles.get(at.triangle as usize).into_iter().flatten().copied().collect();
    while let Some(v) = next.pop() {
        if std::mem::replace(&mut seen[v as usize], true) {
            continue;
        }
        found.push(v);
        let around = surface.triangles_around(v).iter();
        next.extend(around.flat_map(|t| surface.triangles[*t as usize]).filter(|w| !seen[*w as usize]));
    }
    found
}

/// Each vertex with the values of its one-ring folded in.
fn ring(surface: &Surface, values: &[f32], fold: fn(f32, f32) -> f32) -> Vec<f32> {
    (0..values.len())
        .into_par_iter()
        .map(|v| {
            let around = surface.triangles_around(v as u32).iter();
            let neighbours = around.flat_map(|t| surface.triangles[*t as usize]).map(|w| values[w as usize]);
            neighbours.fold(values[v], fold)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{bumpy_sphere, icosphere};

    fn count(painted: &Painted, surface: &Surface) -> (usize, f32) {
        let values = painted.values(&surface.file_positions());
        (values.iter().filter(|x| **x > 0.0).count(), values.iter().copied().fold(0.0, f32::max))
    }

    fn dab(triangle: u32) -> Dab {
        let at = SurfacePoint { triangle, weights: [1.0, 0.0, 0.0] };
        Dab { at, radius: 0.3, intensity: 0.75, erase: false, mirror: None }
    }

    #[test]
    fn painting_twice_is_painting_once_and_erasing_undoes_it() {
        let (_, surface) = bumpy_sphere();
        let once = PaintEdit::Dab(dab(7)).apply(&Painted::Everywhere, &surface).unwrap();
        let (touched, most) = count(&once, &surface);
        assert!(touched > 5 && touched < 300 && most == 0.75, "{touched}");
        assert_eq!(PaintEdit::Dab(dab(7)).apply(&once, &surface).unwrap(), once);
        let eraser = Dab { erase: true, intensity: 1.0, ..dab(7) };
        let gone = PaintEdit::Dab(eraser).apply(&once, &surface).unwrap();
        assert_eq!(count(&gone, &surface).0, 0);
        assert!(PaintEdit::Dab(Dab { intensity: 1.5, ..dab(7) }).apply(&once, &surface).is_err());
    }

    #[test]
    fn grow_shrink_invert_and_clear() {
        let (_, surface) = bumpy_sphere();
        let once = PaintEdit::Dab(dab(7)).apply(&Painted::Everywhere, &surface).unwrap();
        let grown = PaintEdit::Grow.apply(&once, &surface).unwrap();
        assert!(count(&grown, &surface).0 > count(&once, &surface).0);
        assert_eq!(PaintEdit::Shrink.apply(&grown, &surface).unwrap(), once);
        let twice = PaintEdit::Invert.apply(&PaintEdit::Invert.apply(&once, &surface).unwrap(), &surface);
        assert_eq!(twice.unwrap(), once);
        assert_eq!(count(&PaintEdit::Clear.apply(&once, &surface).unwrap(), &surface).0, 0);
    }

    #[test]
    fn a_component_is_filled_alone_and_a_mirrored_dab_has_a_twin() {
        let (points, triangles) = icosphere(2);
        let n = points.len() as u32;
        let two: Vec<Vec3> =
            points.iter().copied().chain(points.iter().map(|p| add(*p, [3.0, 0.0, 0.0]))).collect();
        let second = triangles.iter().map(|t| t.map(|v| v + n));
        let both: Vec<[u32; 3]> = triangles.iter().copied().chain(second).collect();
        let frame = chladni_mesh::Frame { center: [0.0; 3], scale: 1.0 };
        let surface = Surface::of(two, both, frame);
        // Painted on, only the component is in the region; painted away, only it is not.
        for intensity in [1.0, 0.0] {
            let fill = PaintEdit::FillComponent { at: dab(3).at, intensity };
            let filled = fill.apply(&Painted::Everywhere, &surface).unwrap();
            let values = filled.values(&surface.positions);
            let expected = |v: usize| if v < n as usize { intensity } else { 1.0 - intensity };
            assert!(values.iter().enumerate().all(|(v, x)| *x == expected(v)), "{intensity}");
        }

        let (plane, distance) = Mirror::of(&surface).unwrap();
        assert!(distance < 1e-9 && (plane.point[0] - 1.5).abs() < 1e-9);
        let mirrored = Dab { mirror: Some(Mirror { point: plane.point, normal: [1.0, 0.0, 0.0] }), ..dab(3) };
        let painted = PaintEdit::Dab(mirrored).apply(&Painted::Everywhere, &surface).unwrap();
        let values = painted.values(&surface.positions);
        let (left, right) = values.split_at(n as usize);
        let sum = |x: &[f32]| x.iter().filter(|x| **x > 0.0).count();
        assert!(sum(left) > 0 && sum(left) == sum(right));
    }
}
