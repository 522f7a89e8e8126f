//! A shape as it is worked on: whole, or, where it is very large, through a proxy.

use std::collections::HashSet;
use std::fmt::Display;
use std::sync::Arc;

use chladni_caricature::{Project, ProxyKey, Resolution, ShapeSource};
use chladni_match::Landmark;
use chladni_mesh::{Proxy, TriMesh, total_area, weld};

use super::{Error, Warning, Watcher, source};

/// Shapes with more vertices than this are worked on through a proxy, where nobody says otherwise.
const MOST_VERTICES: usize = 400_000;
/// Vertices of such a proxy.
const PROXY_VERTICES: usize = 150_000;

/// A shape as it is worked on. Everything is computed on `mesh`; files are written with all of the shape.
#[derive(Clone)]
pub struct Subject {
    /// The shape as its file holds it, or fewer of its vertices.
    pub mesh: Arc<TriMesh>,
    /// Carries displacements of `mesh` to the whole shape, where `mesh` has fewer vertices.
    pub proxy: Option<Arc<Proxy>>,
}

impl From<TriMesh> for Subject {
    fn from(mesh: TriMesh) -> Self {
        Arc::new(mesh).into()
    }
}

impl From<Arc<TriMesh>> for Subject {
    fn from(mesh: Arc<TriMesh>) -> Self {
        Self { mesh, proxy: None }
    }
}

impl Subject {
    /// Reads or makes a shape; warns where it is so large that a proxy is taken.
    ///
    /// # Errors
    /// As [`source::shape`].
    pub fn open(shape: &ShapeSource, watcher: &impl Watcher) -> Result<Self, Error> {
        Self::open_at(Resolution::Usual, shape, watcher)
    }

    /// The same as finely as `resolution` says.
    ///
    /// # Errors
    /// As [`source::shape`]; [`Error::Input`] where a proxy that is asked for cannot be made.
    pub fn open_at(
        mut resolution: Resolution,
        shape: &ShapeSource,
        watcher: &impl Watcher,
    ) -> Result<Self, Error> {
        Ok(Self::at(&mut resolution, shape, source::shape(shape, watcher)?, watcher)?.0)
    }

    /// The shape of `project`. Where it is very large, its resolution is decided then and kept in the project.
    ///
    /// # Errors
    /// As [`source::shape`] and [`of_mesh`](Self::of_mesh).
    pub fn of(project: &mut Project, watcher: &impl Watcher) -> Result<Self, Error> {
        let mesh = source::shape(&project.shape, watcher)?;
        Self::of_mesh(mesh, project, watcher)
    }

    /// The shape of `project` with all of its vertices, however many they are, unless the project states a proxy.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn whole_of(project: &mut Project, watcher: &impl Watcher) -> Result<Self, Error> {
        let mesh = source::shape(&project.shape, watcher)?;
        Ok(Self::decided(mesh, project, true, watcher)?.0)
    }

    /// The same as [`of`](Self::of) of a mesh that is in memory.
    ///
    /// # Errors
    /// [`Error::Input`] where the proxy that the project asks for cannot be made, or is not the one whose
    /// vertices its regions and landmarks name.
    pub fn of_mesh(mesh: TriMesh, project: &mut Project, watcher: &impl Watcher) -> Result<Self, Error> {
        // Where nothing else is said, regions and landmarks belong to all vertices.
        let needs_all = project.names_vertices();
        let (subject, is_other) = Self::decided(mesh, project, needs_all, watcher)?;
        if is_other && project.names_vertices() {
            return Err(Error::input(format_args!(
                "{}: the regions and landmarks of this project belong to another selection of its vertices: the file \
                 has changed, or the project was made on another kind of processor",
                project.shape
            )));
        }
        Ok(subject)
    }

    /// The shape of `project`, its `mesh`, to which its layers, made on another one, are still to be carried: the vertices
    /// that they name are not this shape's.
    ///
    /// # Errors
    /// As [`of_mesh`](Self::of_mesh).
    pub fn before_carrying(
        mesh: TriMesh,
        project: &mut Project,
        watcher: &impl Watcher,
    ) -> Result<Self, Error> {
        Ok(Self::decided(mesh, project, false, watcher)?.0)
    }

    /// The shape at the project's resolution, which is settled here. Without a stated one, a very large shape stays whole if
    /// all vertices are needed (`needs_all`) or a layer matches vertex by vertex. Such a layer makes the shape whole even
    /// where a proxy is stated, unless `needs_all`: then regions or landmarks name that proxy's vertices. Also returns
    /// whether the proxy differs from the project's.
    fn decided(
        mesh: TriMesh,
        project: &mut Project,
        needs_all: bool,
        watcher: &impl Watcher,
    ) -> Result<(Self, bool), Error> {
        let matches = project.layers().iter().any(|(_, layer)| layer.matches_vertices());
        match project.resolution {
            Resolution::Usual if (needs_all || matches) && is_large(&mesh) => {
                project.resolution = Resolution::Whole;
            }
            Resolution::Proxy(_) if matches && !needs_all => {
                let message = "a layer matches vertex by vertex: all vertices are taken";
                watcher.warn(Warning::of(&project.shape, message));
                project.resolution = Resolution::Whole;
            }
            Resolution::Usual | Resolution::Proxy(_) | Resolution::Whole => {}
        }
        Self::at(&mut project.resolution, &project.shape, mesh, watcher)
    }

    /// As `resolution` says, which is decided then where the shape is very large; and whether it is another proxy than that.
    fn at(
        resolution: &mut Resolution,
        name: impl Display,
        mesh: TriMesh,
        watcher: &impl Watcher,
    ) -> Result<(Self, bool), Error> {
        let mesh = Arc::new(mesh);
        let (key, is_asked) = match &*resolution {
            Resolution::Proxy(key) => (key.clone(), true),
            Resolution::Usual if is_large(&mesh) => {
                (ProxyKey { vertices: PROXY_VERTICES, fingerprint: None }, false)
            }
            Resolution::Usual | Resolution::Whole => return Ok((mesh.into(), false)),
        };
        let made = watcher.watch("choosing fewer vertices", |_| proxy(&mesh, key.vertices));
        watcher.task().check()?;
        let Some(proxy) = made else {
            let why = if cfg!(not(feature = "desktop")) {
                ", except in the desktop program"
            } else if weld(&mesh).positions.len() / 2 < key.vertices {
                ", as it has fewer than twice as many"
            } else {
                ""
            };
            let message = format!("cannot be worked on through about {} vertices{why}", key.vertices);
            if is_asked {
                return Err(Error::input(format_args!("{name}: {message}")));
            }
            watcher.warn(Warning::of(name, format_args!("{message}: all are taken, which is slow")));
            *resolution = Resolution::Whole;
            return Ok((mesh.into(), false));
        };
        let size = (total_area(&mesh.positions, &mesh.triangles) / std::f64::consts::PI).sqrt();
        let share = 100.0 * proxy.farthest() / size;
        watcher.warn(Warning::of(
            name,
            format_args!(
                "of {} vertices {} are worked on, whose surface lies within {share:.2} % of the shape's size; meshes are \
                 written with all",
                mesh.positions.len(),
                proxy.mesh().positions.len(),
            ),
        ));
        let fingerprint = Some(fingerprint(&proxy));
        let is_other = key.fingerprint.is_some() && key.fingerprint != fingerprint;
        *resolution = Resolution::Proxy(ProxyKey { fingerprint, ..key });
        Ok((Self { mesh: Arc::clone(proxy.mesh()), proxy: Some(Arc::new(proxy)) }, is_other))
    }

    /// `landmarks` whose shape's ends are numbers of its file, with those of [`mesh`](Self::mesh) instead: of the
    /// nearest vertices. Of those that come to one vertex the first is kept, with a warning.
    ///
    /// # Errors
    /// [`Error::Input`] for a vertex that is not there.
    pub fn renumbered(&self, landmarks: Vec<Landmark>) -> Result<(Vec<Landmark>, Option<Warning>), Error> {
        let Some(proxy) = &self.proxy else { return Ok((landmarks, None)) };
        let all = landmarks.len();
        let mut kept: Vec<Landmark> = Vec::with_capacity(all);
        let mut known = HashSet::new();
        for landmark in landmarks {
            let Some(shape) = proxy.nearest(landmark.shape) else {
                let vertex = landmark.shape;
                return Err(Error::input(format_args!("the shape has no vertex {vertex} to be a landmark")));
            };
            if known.insert(shape) {
                kept.push(Landmark { shape, ..landmark });
            }
        }
        let lost = all - kept.len();
        let warning = (lost > 0).then(|| {
            Warning::Plain(format!(
                "{lost} of {all} landmarks are left out: among the vertices that are worked on, theirs has one already"
            ))
        });
        Ok((kept, warning))
    }

    /// The other way round: `landmarks` with the numbers of the shape's file.
    pub fn numbered_in_file(&self, landmarks: &[Landmark]) -> Vec<Landmark> {
        let whole = self.proxy.as_ref().map(|proxy| proxy.whole_vertex());
        let of = |shape: u32| whole.and_then(|whole| whole.get(shape as usize)).copied().unwrap_or(shape);
        landmarks.iter().map(|landmark| Landmark { shape: of(landmark.shape), ..*landmark }).collect()
    }

    /// What the vertices of [`mesh`](Self::mesh) have, such as the numbers of parts, at those of the whole shape: of
    /// the nearest; `none` where no triangle uses a vertex.
    pub fn at_whole<T: Copy>(&self, values: &[T], none: T) -> Vec<T> {
        let Some(proxy) = &self.proxy else { return values.to_vec() };
        let of = |v| proxy.nearest(v).and_then(|v| values.get(v as usize)).copied().unwrap_or(none);
        (0..proxy.whole().positions.len() as u32).map(of).collect()
    }

    /// The shape with all that its file holds.
    pub fn whole(&self) -> &Arc<TriMesh> {
        self.proxy.as_ref().map_or(&self.mesh, |proxy| proxy.whole())
    }
}

/// Coincident vertices count once, as in a proxy.
fn is_large(mesh: &TriMesh) -> bool {
    mesh.positions.len() > MOST_VERTICES && weld(mesh).positions.len() > MOST_VERTICES
}

#[cfg(feature = "desktop")]
fn proxy(mesh: &Arc<TriMesh>, vertices: usize) -> Option<Proxy> {
    Proxy::of(mesh, vertices)
}

/// The simplifier is C++, and a build without desktop has no compiler for it.
#[cfg(not(feature = "desktop"))]
fn proxy(_: &Arc<TriMesh>, _: usize) -> Option<Proxy> {
    None
}

/// A hash of the proxy's vertices and triangles.
fn fingerprint(proxy: &Proxy) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::cast_slice(proxy.whole_vertex()));
    hasher.update(bytemuck::cast_slice(&proxy.mesh().triangles));
    hasher.finalize().to_hex()[..16].to_owned()
}

#[cfg(test)]
mod tests {
    use chladni_caricature::{Layer, Painted, Template};
    use chladni_match::Method;
    use chladni_mesh::samples::icosphere;
    use chladni_task::Task;

    use super::*;
    use crate::work::Aside;

    #[test]
    fn only_very_large_shapes_are_worked_on_through_a_proxy_unasked() {
        let task = Task::new();
        let open = |mesh: TriMesh| {
            let aside = Aside::new(&task);
            let mut project = Project::new(ShapeSource::Sample("ball".into()), 8);
            let subject = Subject::of_mesh(mesh, &mut project, &aside).unwrap();
            let said: Vec<String> = aside.warnings().iter().map(ToString::to_string).collect();
            (subject, project.resolution, said)
        };
        let (small, resolution, said) = open(icosphere(4));
        assert_eq!((resolution, small.proxy.is_none(), said.len()), (Resolution::Usual, true, 0));
        let (large, resolution, said) = open(icosphere(8));
        assert_eq!((large.mesh.positions.len(), large.whole().positions.len()), (PROXY_VERTICES, 655_362));
        let Resolution::Proxy(key) = resolution else { panic!("{resolution:?}") };
        assert!(key.vertices == PROXY_VERTICES && key.fingerprint.is_some_and(|f| f.len() == 16));
        assert!(said.len() == 1 && said[0].contains("of 655362 vertices 150000 are worked on"), "{said:?}");
        // A match vertex by vertex needs all of them.
        let mut registered = Project::new(ShapeSource::Sample("ball".into()), 8);
        let mut layer = Layer::new("same", Template::File("other.obj".into()));
        layer.matching.method = Method::Same;
        registered.push(layer).unwrap();
        let whole =
            Subject::of_mesh(TriMesh::clone(large.whole()), &mut registered, &Aside::new(&task)).unwrap();
        assert!(whole.proxy.is_none() && registered.resolution == Resolution::Whole);
        // Also where a proxy was chosen before; but regions that were painted on it belong to it.
        for is_painted in [false, true] {
            registered.resolution = Resolution::Proxy(ProxyKey { vertices: 1000, fingerprint: None });
            if is_painted {
                let mut layer = Layer::new("painted", Template::Sphere);
                layer.region.painted = Painted::Vertices(vec![1.0_f32; 1000].into());
                registered.push(layer).unwrap();
            }
            let aside = Aside::new(&task);
            let opened = Subject::of_mesh(icosphere(4), &mut registered, &aside).unwrap();
            assert_eq!(opened.proxy.is_some(), is_painted);
            let said: Vec<String> = aside.warnings().iter().map(ToString::to_string).collect();
            let says_so = said.iter().any(|warning| warning.contains("all vertices are taken"));
            assert_eq!(says_so, !is_painted, "{said:?}");
        }
        let mark = |shape| Landmark { shape, template: 7 };
        // Landmarks belong to the shape that they were set on, not to one that they will be carried to.
        for (is_its_own, expected) in [(true, 655_362), (false, PROXY_VERTICES)] {
            let mut marked = Project::new(ShapeSource::Sample("ball".into()), 8);
            let mut layer = Layer::new("marked", Template::File("other.obj".into()));
            layer.matching.landmarks = vec![mark(3)];
            marked.push(layer).unwrap();
            let (mesh, aside) = (TriMesh::clone(large.whole()), Aside::new(&task));
            let subject = match is_its_own {
                true => Subject::of_mesh(mesh, &mut marked, &aside).unwrap(),
                false => Subject::decided(mesh, &mut marked, false, &aside).unwrap().0,
            };
            assert_eq!(subject.mesh.positions.len(), expected);
        }
        let chosen = large.proxy.as_ref().unwrap().whole_vertex()[5];
        assert_eq!(large.renumbered(vec![mark(chosen)]).unwrap(), (vec![mark(5)], None));
        // One that the proxy lacks, and the one that takes its place.
        let proxy = large.proxy.as_ref().unwrap();
        let beside = (0..655_362).find(|v| !proxy.whole_vertex().contains(v)).unwrap();
        let nearest = proxy.nearest(beside).unwrap();
        let both = vec![mark(beside), mark(proxy.whole_vertex()[nearest as usize])];
        let (kept, warning) = large.renumbered(both).unwrap();
        assert_eq!(kept, [mark(nearest)]);
        assert!(warning.unwrap().to_string().contains("1 of 2 landmarks"));
        assert_eq!(large.numbered_in_file(&[mark(5)]), [mark(chosen)]);
        assert_eq!(small.numbered_in_file(&[mark(5)]), [mark(5)]);
        assert!(large.renumbered(vec![mark(700_000)]).is_err());
        assert_eq!(small.renumbered(vec![mark(700_000)]).unwrap(), (vec![mark(700_000)], None));
    }

    #[test]
    fn a_shape_of_many_pieces_is_taken_whole_and_says_so() {
        let mut soup = TriMesh::default();
        for i in 0..101_000_u32 {
            let x = f64::from(i);
            let corner = [[x, 0.0, 0.0], [x + 0.5, 0.0, 0.0], [x, 0.5, 0.0], [x, 0.0, 0.5 + x % 7.0]];
            soup.positions.extend(corner);
            soup.triangles
                .extend([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map(|t| t.map(|v: u32| 4 * i + v)));
        }
        let task = Task::new();
        let aside = Aside::new(&task);
        let mut project = Project::new(ShapeSource::Sample("soup".into()), 8);
        let subject = Subject::of_mesh(soup, &mut project, &aside).unwrap();
        assert_eq!((project.resolution, subject.mesh.positions.len()), (Resolution::Whole, 404_000));
        assert!(aside.warnings()[0].to_string().contains("which is slow"));
    }

    #[test]
    fn vertices_that_coincide_make_no_shape_large() {
        let mut mesh = icosphere(4);
        mesh.positions = mesh.positions.repeat(160);
        assert!(mesh.positions.len() > MOST_VERTICES);
        let task = Task::new();
        let aside = Aside::new(&task);
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 8);
        let subject = Subject::of_mesh(mesh, &mut project, &aside).unwrap();
        assert!(subject.proxy.is_none() && project.resolution == Resolution::Usual);
        assert_eq!(aside.warnings(), []);
    }
}
