//! A project evaluated on its shape, and the resulting mesh.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{Evaluation, LayerState, Project, Stack};
use chladni_harmonics::Body;
use chladni_mesh::surface::vec3::{Vec3, add, sub};
use chladni_mesh::{
    Format, MeshError, MorphTarget, Orientation, ShapeSource, TriMesh, add_morph_targets,
    add_morph_targets_in, save_mesh, write_glb, write_mesh,
};
use chladni_task::Task;

use super::left_out::{LEFT_OF_GLTF, is_gltf, left_by, pictures_apart, rounded_in_stl};
use super::writing::write_file;
use super::{Error, Subject, Warning, Watcher, matched};

/// The result of a project on its shape. Later edits of the project do not change it.
pub struct Sculpture {
    /// Where the shape comes from.
    pub source: ShapeSource,
    /// The shape.
    pub subject: Subject,
    /// With its harmonics.
    pub body: Arc<Body>,
    /// The evaluation of all layers.
    pub evaluation: Evaluation,
}

/// A sculpture that can be changed.
pub struct Made {
    /// As the project has it.
    pub sculpture: Sculpture,
    /// Evaluates other projects on the same shape with the same matches.
    pub stack: Stack,
    /// How the shape stands, if it takes that from a template that it was matched with.
    pub stands: Option<Orientation>,
}

/// Matches what `project` asks for with the mesh of `subject`, which `body` was built from, and evaluates it. A layer that
/// cannot act is an error, or, if `forgiven`, a warning, and the others continue without it.
///
/// # Errors
/// [`Error::Caricature`] or [`Error::Input`] with the first layer that cannot act.
pub fn make(
    subject: impl Into<Subject>,
    body: Arc<Body>,
    project: &Project,
    forgiven: bool,
    watcher: &impl Watcher,
) -> Result<Made, Error> {
    let subject = subject.into();
    let mesh = &subject.mesh;
    let mut stack = Stack::new(Arc::clone(&body))?;
    let mut stands = None;
    for request in stack.missing(project) {
        let found = match matched(&request, mesh, &body, watcher) {
            Err(why) if !forgiven => return Err(why.into()),
            found => found,
        };
        watcher.task().check()?;
        match &found {
            Ok(found) => stands = stands.or(found.stands),
            Err(why) => watcher.warn(Warning::Plain(why.to_string())),
        }
        stack.install(request, found);
    }
    let evaluation = settled(&mut stack, project, watcher)?;
    for layer in &evaluation.layers {
        if let LayerState::Failed(why) = &layer.state
            && !forgiven
        {
            return Err(Error::Input(format!("layer {}: {why}", layer.name)));
        }
        if layer.mask.as_ref().is_some_and(|mask| mask.iter().all(|share| *share == 0.0)) {
            watcher.warn(Warning::empty_region(Some(&layer.name), mesh));
        }
    }
    let source = project.shape.clone();
    Ok(Made { sculpture: Sculpture { source, subject, body, evaluation }, stack, stands })
}

/// Evaluates `project` on `stack` and, where it keeps triangles, limits its layers, the lowest first.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn settled(stack: &mut Stack, project: &Project, watcher: &impl Watcher) -> Result<Evaluation, Error> {
    while let Some(request) = stack.unsettled(project) {
        let kept = watcher.watch("keeping triangles", |task| request.run(task));
        watcher.task().check()?;
        stack.settle(request, kept);
    }
    Ok(stack.evaluate(project))
}

/// Takes the materials out of a mesh; whether it had any.
pub(super) fn leave_out_materials(mesh: &mut TriMesh) -> bool {
    mesh.appearance.face_materials.clear();
    !std::mem::take(&mut mesh.appearance.materials).is_empty()
}

impl Sculpture {
    /// Writes it in the format of the ending: GLB holds the original with one morph target per layer, other
    /// formats the result itself. Where the shape comes from a glTF file, all else in that file stays in the GLB; a warning
    /// says where that is not possible, where a GLB or an OBJ lacks pictures, and where an STL is too coarse. A canceled
    /// `task` writes nothing.
    ///
    /// # Errors
    /// [`Error::Unsaved`] or [`Error::Unwritten`], with the file's name; a canceled task.
    pub fn save(&self, path: &Path, task: &Task) -> Result<Option<Warning>, Error> {
        if Format::of_path(path) == Some(Format::Glb) {
            let (bytes, warning) = self.glb(None).map_err(|error| Error::unwritten(path, error))?;
            task.check()?;
            write_file(path, &bytes)?;
            return Ok(warning);
        }
        let result = self.result();
        task.check()?;
        save_mesh(&result, path).map_err(Error::unsaved)?;
        Ok(left_by(&self.source, &result, path))
    }

    /// The same in memory, as a file of `format`. `file` holds the bytes of the shape's file, where it comes from
    /// one.
    ///
    /// # Errors
    /// [`Error::Mesh`] for properties that the format cannot hold.
    pub fn to_bytes(&self, format: Format, file: Option<&[u8]>) -> Result<(Vec<u8>, Option<Warning>), Error> {
        if format == Format::Glb {
            return Ok(self.glb(file)?);
        }
        let mut result = self.result();
        let warning = match format {
            // In memory no library can be written beside it.
            Format::Obj => leave_out_materials(&mut result).then(|| {
                Warning::Plain(
                    "an OBJ alone has neither materials nor pictures: save GLB for these".to_owned(),
                )
            }),
            Format::Stl => rounded_in_stl(&result),
            _ => None,
        };
        Ok((write_mesh(&result, format)?, warning))
    }

    /// All of the shape, moved by the body's displacements.
    fn result(&self) -> TriMesh {
        let whole = self.subject.whole();
        let positions = match &self.subject.proxy {
            None => self.evaluation.file_positions(&self.body, &whole.positions),
            Some(proxy) => {
                let moved = self.body.displacements_in_file(&self.evaluation.displacement());
                whole.positions.iter().zip(proxy.carried(&moved)).map(|(p, d)| add(*p, d)).collect()
            }
        };
        TriMesh { positions, ..TriMesh::clone(whole) }
    }

    /// The displacements of the whole shape by each acting layer. They add up to the result.
    fn morph_targets(&self) -> Vec<MorphTarget> {
        let targets = self.evaluation.morph_targets(&self.body);
        let Some(proxy) = &self.subject.proxy else {
            let target = |(name, displacements)| MorphTarget { name, displacements };
            return targets.into_iter().map(target).collect();
        };
        // How detail turns depends on all layers up to this one.
        let mut moved = vec![[0.0; 3]; self.subject.mesh.positions.len()];
        let mut below = vec![[0.0; 3]; self.subject.whole().positions.len()];
        let target = |(name, displacements): (String, Vec<Vec3>)| {
            moved.iter_mut().zip(displacements).for_each(|(sum, d)| *sum = add(*sum, d));
            let carried = proxy.carried(&moved);
            let displacements = carried.iter().zip(&below).map(|(now, before)| sub(*now, *before)).collect();
            below = carried;
            MorphTarget { name, displacements }
        };
        targets.into_iter().map(target).collect()
    }

    /// `file` holds the bytes of the shape's file, where these are in memory.
    fn glb(&self, file: Option<&[u8]>) -> Result<(Vec<u8>, Option<Warning>), MeshError> {
        let (whole, targets) = (self.subject.whole(), self.morph_targets());
        let mut warning = None;
        if let ShapeSource::File(source) = &self.source
            && is_gltf(source)
        {
            let added = match file {
                Some(bytes) => add_morph_targets_in(bytes, whole, &targets),
                None => add_morph_targets(source, whole, &targets),
            };
            match added {
                Ok(bytes) => {
                    let apart = pictures_apart(source, &bytes);
                    return Ok((bytes, apart));
                }
                Err(why) => {
                    warning = Some(Warning::of(source.display(), format_args!("{why}: {LEFT_OF_GLTF}")));
                }
            }
        }
        Ok((write_glb(whole, &targets)?, warning))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Aside;
    use super::*;
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{Material, samples::icosphere};

    #[test]
    fn an_obj_in_memory_names_no_library() {
        let mut mesh = icosphere(1);
        mesh.appearance.materials = vec![Material::named("skin")];
        mesh.appearance.face_materials = vec![Some(0); mesh.triangles.len()];
        let task = Task::new();
        let body = Arc::new(Body::build(&mesh, &BasisSettings::new(4), &task).unwrap());
        let project = Project::new(ShapeSource::Sample("ball".into()), 4);
        let made = make(mesh, body, &project, false, &Aside::new(&task)).unwrap();
        let (bytes, warning) = made.sculpture.to_bytes(Format::Obj, None).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.contains("mtllib") && !text.contains("usemtl") && text.contains("\nf "));
        assert!(warning.unwrap().to_string().contains("save GLB"));
        assert_eq!(made.sculpture.to_bytes(Format::Ply, None).unwrap().1, None);
    }

    #[test]
    fn an_stl_far_from_the_origin_is_warned_of() {
        let mut mesh = icosphere(1);
        assert_eq!(rounded_in_stl(&mesh), None);
        mesh.positions.iter_mut().for_each(|p| p[1] += 5_654_321.0);
        let warning = rounded_in_stl(&mesh).unwrap().to_string();
        assert!(warning.contains("7e-1") && warning.contains("save PLY"), "{warning}");
    }
}
