//! The octopus at the fifth second of the sample tune, moved by each of twelve mappings; writes dance-0.obj
//! and so on.

use std::sync::Arc;

use chladni::harmonics::{BasisSettings, Body};
use chladni::mesh::{Orientation, TriMesh, samples, save_mesh};
use chladni::music::{Bands, Beat, Dancer, Ensemble, GalleryShape, Instrument, Symmetry};
use chladni::sound::{SongSpectrum, SpectrumSettings, sample_tune};
use chladni::synth::displacements_f64;
use chladni::task::Task;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = samples::sample("octopus").ok_or("there is an octopus")?;
    let task = Task::new();
    let body = Body::build(&mesh, &BasisSettings::new(128), &task)?;
    let classes = Symmetry::of(&body, &task)?.classes;
    let mut ensemble = Ensemble::new(Arc::new(Dancer::new(&body, &classes, &Orientation::default())?));

    let song = Arc::new(sample_tune());
    let mut ears = SongSpectrum::new(song.clone(), SpectrumSettings::new(song.rate_hz), 0.0)?;
    let (side_gain, heard) = (ears.settings().side_gain, ears.at(5.0));
    let bands = Bands {
        left: &heard.left,
        right: &heard.right,
        mid: &heard.mid,
        side: &heard.side,
        side_gain,
        // The harmonics follow the level directly.
        ringing: None,
    };

    let shape = GalleryShape { eigenvalues: body.basis.eigenvalues.clone(), bands: heard.mid.len() };
    let instrument = Instrument::new(2012, 12, shape)?;
    for (i, item) in ensemble.play(&instrument, &bands, Beat::default())?.iter().enumerate() {
        let moved = displacements_f64(&body, item)?;
        let positions = body.displaced_file_positions(&mesh.positions, &moved);
        save_mesh(&TriMesh { positions, ..mesh.clone() }, format!("dance-{i}.obj").as_ref())?;
    }
    Ok(())
}
