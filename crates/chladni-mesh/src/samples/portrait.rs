//! A human head with sliders: of its width, its age, its nose and what else tells one face from another.

mod ear;
mod eye;
mod fit;
mod mouth;
mod nose;

pub use fit::{FitPoint, FittedPortrait, fitted_portrait};

use super::field::{carve, common, ellipsoid, join, rod, sphere};
use super::head::plain_forms;
use super::head_parts;
use super::surface_nets::{Grid, surface};
use crate::surface::components;
use crate::surface::vec3::{Vec3, sub};
use crate::{MeshError, TriMesh};

/// The sliders by name, and their effects; each goes from −1 to 1, and 0 is a plain head.
pub const SLIDERS: [(&str, &str); 17] = [
    ("width", "narrow to broad"),
    ("length", "a short face to a long one"),
    ("age", "a child to an old man"),
    ("forehead", "low to high"),
    ("brow", "smooth to a heavy ridge"),
    ("eyes", "small to large"),
    ("eye-spacing", "close to far apart"),
    ("cheeks", "hollow to full"),
    ("nose", "short to long"),
    ("nose-width", "narrow to broad"),
    ("bridge", "a saddle to a hump"),
    ("lips", "thin to full"),
    ("mouth", "small to wide"),
    ("jaw", "tapering to square"),
    ("chin", "receding to jutting"),
    ("ears", "small and flat to large and standing off"),
    ("neck", "thin to thick"),
];

/// Name of the head among the samples; its sliders follow a question mark.
const NAME: &str = "portrait";

/// The values of the sliders that a sample's name gives, in the order of [`SLIDERS`]; `None` of other samples. The error is
/// [`MeshError::Sliders`].
pub fn portrait_sliders(name: &str) -> Option<Result<[f64; SLIDERS.len()], MeshError>> {
    match name.split_once('?') {
        None if name == NAME => Some(Ok([0.0; SLIDERS.len()])),
        Some((NAME, sliders)) => Some(parse(name, sliders)),
        _ => None,
    }
}

/// The name of the head with these sliders, to a hundredth.
pub fn portrait_name(values: &[f64; SLIDERS.len()]) -> String {
    let moved = SLIDERS.iter().zip(values).filter(|(_, value)| value.abs() >= 0.005);
    let moved: Vec<String> = moved.map(|((name, _), value)| format!("{name}={:.2}", value)).collect();
    if moved.is_empty() { NAME.to_owned() } else { format!("{NAME}?{}", moved.join(",")) }
}

/// From the `name=value,…` of a `sample`.
fn parse(sample: &str, text: &str) -> Result<[f64; SLIDERS.len()], MeshError> {
    let wrong = |why: String| MeshError::Sliders { name: sample.to_owned(), why };
    let mut values = [0.0; SLIDERS.len()];
    for pair in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()) {
        let known = || SLIDERS.map(|(name, _)| name).join(", ");
        let (name, value) =
            pair.split_once('=').ok_or_else(|| wrong(format!("write jaw=0.5, not {pair:.20}")))?;
        let place = SLIDERS.iter().position(|(slider, _)| *slider == name.trim());
        let place =
            place.ok_or_else(|| wrong(format!("there is no slider {name:.20}; there are {}", known())))?;
        let value: Option<f64> = value.trim().parse().ok().filter(|x| (-1.0..=1.0).contains(x));
        values[place] = value.ok_or_else(|| wrong(format!("{name} must be a number from -1 to 1")))?;
    }
    Ok(values)
}

/// Values of the sliders, from which the lengths of a plain head follow, in units of half a head's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    width: f64,
    length: f64,
    age: f64,
    forehead: f64,
    brow: f64,
    eyes: f64,
    spacing: f64,
    cheeks: f64,
    nose: f64,
    nose_width: f64,
    bridge: f64,
    lips: f64,
    mouth: f64,
    jaw: f64,
    chin: f64,
    ears: f64,
    neck: f64,
}

/// Side of the finest cells.
const CELL: f64 = 0.0165;

impl Face {
    /// With sliders as [`portrait_sliders`] gives them.
    pub fn of(values: [f64; SLIDERS.len()]) -> Self {
        let [
            width,
            length,
            age,
            forehead,
            brow,
            eyes,
            spacing,
            cheeks,
            nose,
            nose_width,
            bridge,
            lips,
            mouth,
            jaw,
            chin,
            ears,
            neck,
        ] = values;
        let (old, young) = (age.max(0.0), (-age).max(0.0));
        Self {
            width,
            length: length - 0.5 * young,
            age,
            forehead: forehead + 0.5 * young,
            brow: brow + 0.25 * old - 0.8 * young,
            eyes: eyes + 0.5 * young - 0.15 * old,
            spacing: spacing + 0.1 * young,
            cheeks: cheeks + 0.7 * young - 0.5 * old,
            nose: nose + 0.35 * old - 0.8 * young,
            nose_width: nose_width + 0.2 * old - 0.15 * young,
            bridge: bridge - 0.5 * young,
            lips: lips - 0.5 * old + 0.2 * young,
            mouth: mouth - 0.35 * young,
            jaw: jaw - 0.6 * young,
            chin: chin + 0.2 * old - 0.4 * young,
            ears: ears + 0.45 * old,
            neck: neck - 0.5 * young - 0.15 * old,
        }
    }

    /// The head.
    pub fn mesh(&self) -> TriMesh {
        self.modeled(CELL)
    }

    fn modeled(&self, cell: f64) -> TriMesh {
        let grid = Grid {
            center: [0.0, -0.2, 0.45],
            low: [-1.3, -1.75, -1.35],
            high: [1.3, 1.6, 1.6],
            cell,
            growth: 0.45,
        };
        outermost(surface(|p| self.solid(p), &grid))
    }

    /// The half of the head at x ≥ 0.
    fn solid(&self, p: Vec3) -> f64 {
        let (q, scale) = self.straight(p);
        let mut d = self.skull(q);
        d = join(d, self.column(q), 0.20);
        d = eye::add(d, q, self);
        d = nose::add(d, q, self);
        d = mouth::add(d, q, self);
        d = ear::add(d, q, self);
        common(d * scale, -1.45 - p[1], 0.10)
    }

    /// Where the point lies on a head of usual width and length, and how much shorter distances are there.
    fn straight(&self, [x, y, z]: Vec3) -> (Vec3, f64) {
        let wide = 1.0 + 0.16 * self.width;
        // Below the eyes the face is longer, above the forehead is higher.
        let low = 1.0 + 0.16 * self.length;
        let high = 1.0 + 0.14 * self.forehead;
        let y = if y < 0.0 { y.max(-1.0) / low + (y + 1.0).min(0.0) } else { y / high };
        ([x / wide, y, z], wide.min(low).min(high).min(1.0))
    }

    fn skull(&self, p: Vec3) -> f64 {
        let Forms { cranium, face, jaw, chin, bone, flesh, brow } = self.forms(p);
        let mut d = join(cranium, face, 0.35);
        d = join(d, jaw, 0.25);
        d = join(d, chin, 0.16);
        d = join(d, bone, 0.22);
        d = join(d, flesh, 0.22);
        d = join(d, brow, 0.13);
        // The temples.
        d = carve(d, ellipsoid(p, [0.83, 0.12, 0.36], [0.17, 0.26, 0.24]), 0.20);
        let hollow = (-self.cheeks).max(0.0);
        if hollow > 0.0 {
            let pit = ellipsoid(p, [0.60, -0.42, 0.42], [0.08 + 0.09 * hollow, 0.24, 0.22]);
            d = carve(d, pit, 0.26);
        }
        if self.age > 0.0 { self.wrinkled(d, p) } else { d }
    }

    /// Folds from the nose to the mouth, jowls and a furrowed forehead.
    fn wrinkled(&self, d: f64, p: Vec3) -> f64 {
        let old = self.age;
        let jowl = sphere(p, [0.37, -0.70, 0.33], 0.10 + 0.05 * old);
        let mut d = join(d, jowl, 0.18);
        let cheek = rod(p, [0.26, -0.30, 0.60], [0.33, -0.50, 0.54], 0.07 + 0.03 * old, 0.08 + 0.03 * old);
        d = join(d, cheek, 0.10);
        let fold =
            rod(p, [0.155, -0.30, 0.715], [0.27, -0.60, 0.66], 0.010 + 0.012 * old, 0.008 + 0.010 * old);
        d = carve(d, fold, 0.04);
        let mark = rod(p, [0.26, -0.66, 0.63], [0.27, -0.80, 0.56], 0.008 + 0.008 * old, 0.004);
        d = carve(d, mark, 0.035);
        let near = |x: f64, middle: f64, width: f64| (-((x - middle) / width).powi(2)).exp();
        let forehead = near(p[1], 0.42, 0.13) * near(p[0], 0.0, 0.36) * if p[2] > 0.0 { 1.0 } else { 0.0 };
        d + 0.008 * old * forehead * (p[1] * 52.0 + 4.0 * p[0] * p[0]).sin()
    }

    fn forms(&self, p: Vec3) -> Forms {
        let (young, full) = ((-self.age).max(0.0), self.cheeks.max(0.0));
        let cranium = ellipsoid(p, [0.0, 0.30, -0.13], [0.70 + 0.02 * young, 0.70, 0.84]);
        let face = ellipsoid(p, [0.0, -0.26, 0.14], [0.56, 0.70, 0.57]);
        let (square, out) = (self.jaw, self.chin);
        let jaw = rod(
            p,
            [0.365 + 0.07 * square, -0.52 - 0.05 * square, 0.03],
            [0.125 + 0.05 * square, -0.83 - 0.03 * out.max(0.0), 0.44 + 0.08 * out],
            0.20 + 0.02 * square,
            0.155,
        );
        let chin = ellipsoid(p, self.chin(), [0.215 + 0.05 * square, 0.145 + 0.02 * out, 0.15]);
        let bone = sphere(p, [0.40, -0.12, 0.42 + 0.02 * full], 0.19 + 0.02 * full);
        let flesh =
            sphere(p, [0.29 + 0.05 * full, -0.44, 0.42 + 0.04 * full], 0.19 + 0.08 * self.cheeks.max(-0.6));
        let ridge = 0.080 + 0.032 * self.brow.max(-1.0);
        let out = 0.02 * self.brow.max(0.0);
        let brow = rod(p, [0.09, 0.165, 0.655 + out], [0.43, 0.185, 0.48 + out], ridge, 0.8 * ridge);
        Forms { cranium, face, jaw, chin, bone, flesh, brow }
    }

    /// The neck with its muscles and the throat.
    fn column(&self, p: Vec3) -> f64 {
        let thick = 1.0 + 0.22 * self.neck;
        let adult = (1.0 + self.age.min(0.0)).max(0.0);
        let column = rod(p, [0.0, -0.50, -0.20], [0.0, -1.20, -0.27], 0.41 * thick, 0.385 * thick);
        let base = ellipsoid(p, [0.0, -1.66, -0.27], [0.72 * thick, 0.36, 0.50 * thick]);
        let muscle = rod(p, [0.54, -0.40, -0.22], [0.15, -1.28, 0.10 * thick], 0.07, 0.06);
        let throat = rod(p, [0.0, -0.74, 0.24], [0.0, -1.06, 0.02 * thick], 0.19, 0.19 * thick);
        let larynx = sphere(
            p,
            [0.0, -1.04, 0.195 + 0.04 * (thick - 1.0)],
            0.05 + 0.025 * adult * (1.0 + 0.5 * self.jaw),
        );
        let d = join(join(join(column, base, 0.35), muscle, 0.13), throat, 0.25);
        join(d, larynx, 0.10)
    }

    /// The middle of the chin.
    fn chin(&self) -> Vec3 {
        [0.0, -0.87 - 0.05 * self.chin, 0.52 + 0.13 * self.chin]
    }

    /// The [`borders`](head_parts::borders) around a point.
    pub fn borders(&self, p: Vec3) -> [f64; head_parts::PARTS.len()] {
        self.borders_seen(p, p)
    }

    /// The same with the eyes looked for at `before`, the others at `p`.
    pub fn borders_seen(&self, before: Vec3, [x, y, z]: Vec3) -> [f64; head_parts::PARTS.len()] {
        let (before, _) = self.straight([before[0].abs(), before[1], before[2]]);
        let (p, _) = self.straight([x.abs(), y, z]);
        let features = head_parts::Features {
            nose: nose::form(p, self),
            eyes: eye::place(before, self),
            mouth: mouth::place(p, self),
            ears: ear::form(p, self),
        };
        let plain = Self::of([0.0; SLIDERS.len()]);
        let on_plain = head_parts::chin_back(p, self.chin(), sub(self.chin(), plain.chin()));
        head_parts::borders(&features, plain_forms(on_plain))
    }
}

/// The largest piece of `mesh`: pieces that carving leaves inside the head are not part of its surface.
fn outermost(mesh: TriMesh) -> TriMesh {
    let piece = components(mesh.positions.len(), &mesh.triangles);
    let mut sizes = vec![0_usize; mesh.positions.len()];
    piece.iter().for_each(|piece| sizes[*piece as usize] += 1);
    let largest = (0..sizes.len()).max_by_key(|piece| sizes[*piece]).unwrap_or(0) as u32;
    let mut number = vec![u32::MAX; piece.len()];
    let mut positions = Vec::with_capacity(piece.len());
    for (v, p) in mesh.positions.iter().enumerate().filter(|(v, _)| piece[*v] == largest) {
        number[v] = positions.len() as u32;
        positions.push(*p);
    }
    let kept = mesh.triangles.iter().filter(|t| piece[t[0] as usize] == largest);
    let triangles = kept.map(|t| t.map(|v| number[v as usize])).collect();
    TriMesh { positions, triangles, ..mesh }
}

/// The distances of a point from the large forms.
struct Forms {
    cranium: f64,
    face: f64,
    jaw: f64,
    chin: f64,
    bone: f64,
    flesh: f64,
    brow: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HealthReport;
    use crate::samples::{HEAD_PARTS, head_parts, sample};

    #[test]
    fn all_sliders_at_either_end_make_a_sound_head_and_move_it() {
        let modeled = |values| {
            let mesh = Face::of(values).modeled(3.0 * CELL);
            let report = HealthReport::of(&mesh);
            assert_eq!((report.topology.components, report.topology.genus), (1, Some(0)), "{values:?}");
            assert!(report.volume.unwrap() > 0.0 && report.degenerate_triangles == 0);
            mesh
        };
        let plain = modeled([0.0; SLIDERS.len()]);
        for (place, (name, _)) in SLIDERS.iter().enumerate() {
            for end in [-1.0, 1.0] {
                let mut values = [0.0; SLIDERS.len()];
                values[place] = end;
                modeled(values);
                let face = Face::of(values);
                let off = plain.positions.iter().map(|[x, y, z]| face.solid([x.abs(), *y, *z]).abs());
                let farthest = off.fold(0.0, f64::max);
                assert!(farthest > 0.003, "{name} = {end} moves the surface by {farthest} at most");
            }
        }
        let _ = [[-1.0; SLIDERS.len()], [1.0; SLIDERS.len()]].map(modeled);
    }

    #[test]
    fn the_plain_one_is_fine_mirrored_and_has_all_its_parts() {
        let mesh = sample("portrait").unwrap();
        let report = HealthReport::of(&mesh);
        assert!(report.vertices >= 20_000, "{}", report.vertices);
        assert_eq!((report.topology.components, report.topology.boundary_loops), (1, 0));
        assert_eq!(report.topology.genus, Some(0));
        let parts = head_parts("portrait?age=0", &mesh.positions).unwrap();
        for (i, name) in HEAD_PARTS.iter().enumerate() {
            let of = parts.iter().filter(|part| usize::from(**part) == i).count();
            assert!(of * 200 > parts.len(), "{name}: {of} vertices");
        }
    }

    #[test]
    fn names_are_read_as_written_and_refused_with_a_reason() {
        let mut values = [0.0; SLIDERS.len()];
        (values[2], values[13]) = (-1.0, 0.25);
        let name = portrait_name(&values);
        assert_eq!(name, "portrait?age=-1.00,jaw=0.25");
        assert!(matches!(portrait_sliders(&name), Some(Ok(read)) if read == values));
        assert_eq!(portrait_name(&[0.0; SLIDERS.len()]), "portrait");
        assert!(portrait_sliders("head?jaw=1").is_none());
        for bad in ["portrait?jaw", "portrait?jaw=2", "portrait?jaw=x", "portrait?tail=1"] {
            let why = portrait_sliders(bad).unwrap().unwrap_err().to_string();
            assert!(why.starts_with(&format!("sample:{bad}: ")), "{why}");
        }
    }
}
