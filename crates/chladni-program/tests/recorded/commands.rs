//! The commands, on shapes and sounds of our own.

/// One or several commands in an empty folder.
pub struct Recorded {
    /// Also the name of the record's file.
    pub name: &'static str,
    /// The words of each command, without the program's name.
    pub steps: &'static [&'static str],
}

macro_rules! recorded {
    ($($name:literal: $($step:literal),+;)+) => {
        &[$(Recorded { name: $name, steps: &[$($step),+] }),+]
    };
}

/// Commands whose output a mere restructuring must not change.
pub const COMMANDS: &[Recorded] = recorded! {
    "info-head": "info sample:head --json";
    "info-template": "info sample:template";
    "info-octopus": "info sample:octopus --json";
    "info-missing": "info nowhere.obj";
    "info-unknown-sample": "info sample:unicorn";
    "basis-octopus": "basis sample:octopus -k 40 -o basis.npz";
    "basis-octopus-json": "basis sample:octopus -k 40 --json";
    "basis-operator": "basis sample:head -k 8 -o basis.npz --operator operator.npz";
    "basis-too-many": "basis sample:octopus -k 4000000 -o basis.npz";
    "caricature-coordinate": "caricature sample:head ellipsoid -k 48 --mu -0.8 -o out.obj";
    "caricature-normal": "caricature sample:head ellipsoid -k 48 --model normal --mu -0.8 -o out.ply";
    "caricature-distance": "caricature sample:head ellipsoid -k 48 --model distance --mu -1.5 -o out.stl";
    "caricature-sphere": "caricature sample:octopus sphere -k 48 --mu -0.4 -o out.glb";
    "caricature-self-scaled": "caricature sample:head self:scale=0.9 -k 48 --mu -2 -o out.obj";
    "caricature-self-low-passed": "caricature sample:head self:lowpass=12 -k 48 --mu -1 -o out.obj";
    "caricature-matched": "caricature sample:head sample:template -k 48 --mu -1 -o out.obj";
    "caricature-icp": "caricature sample:head sample:template --match icp -k 48 --mu -1 -o out.obj";
    "caricature-region": "caricature sample:head ellipsoid -k 48 --mu -1 --region 0,0,1,0.4 -o out.obj";
    "caricature-sharp-region":
        "caricature sample:head ellipsoid -k 48 --mu -1 --region 0,0,1,0.4 --roll-off sharp --cutoff 24 -o out.obj";
    "caricature-broad": "caricature sample:head ellipsoid -k 48 --mu -1 --scale-curve broad -o out.obj";
    "caricature-fine": "caricature sample:head ellipsoid -k 48 --mu -1 --scale-curve fine -o out.obj";
    "caricature-mu-zero": "caricature sample:octopus ellipsoid -k 16 --mu 0 -o out.obj";
    "caricature-rendered":
        "caricature sample:head ellipsoid -k 48 --mu -1 -o out.obj --render out.png --size 320x180";
    "project":
        "project new sample:head -k 48 -o me.chladni",
        "project add-layer me.chladni --template ellipsoid --model distance --mu -1.5",
        "project add-layer me.chladni --template self:scale=0.9 --mu -1",
        "project show me.chladni",
        "caricature --recipe me.chladni -o me.glb",
        "caricature sample:template --recipe me.chladni -o other.obj";
    "project-twice": "project new sample:head -o me.chladni", "project new sample:octopus -o me.chladni";
    "match-ellipsoid": "match sample:head --method ellipsoid --json -o match.npz";
    "match-fit": "match sample:head sample:template --json -o match.npz";
    "match-icp": "match sample:head sample:template --method icp --json -o match.npz";
    "match-rendered": "match sample:octopus --method sphere --render match.png";
    "symmetry-octopus": "symmetry sample:octopus -k 24 --json";
    "symmetry-head": "symmetry sample:head -k 24 --json";
    "symmetry-rendered": "symmetry sample:head -k 24 --render symmetry.png";
    "beats": "beats sample:tune --json";
    "beats-causal": "beats sample:tune --causal --json";
    "spectrum": "spectrum sample:tune --json --bands 24 --duration 2";
    "spectrum-linear": "spectrum sample:tune --json --bands 24 --duration 2 --linear --fixed-level";
    "spectrum-rendered": "spectrum sample:tune --render spectrum.png --duration 4";
    "dance-default": "dance sample:octopus sample:tune -k 48 --duration 1 --coefficients dance.npz";
    "dance-filter": "dance sample:octopus sample:tune -k 48 --duration 1 --form filter --coefficients dance.npz";
    "dance-modal": "dance sample:octopus sample:tune -k 48 --duration 1 --form modal --coefficients dance.npz";
    "dance-half-mask":
        "dance sample:octopus sample:tune -k 48 --duration 1 --form half-mask --coefficients dance.npz";
    "dance-head-later":
        "dance sample:head sample:tune -k 48 --start 8 --duration 1 --seed 3 --coefficients dance.npz";
    "dance-frames":
        "dance sample:octopus sample:tune -k 48 --duration 0.2 --fps 10 --size 192x144 --frames frames";
    "dance-gallery":
        "dance sample:octopus sample:tune -k 48 --duration 0.2 --fps 10 --size 320x240 --gallery 6 --frames frames";
    "dance-looks":
        "dance sample:octopus sample:tune -k 48 --duration 0.2 --fps 10 --size 192x144 --look neon --frames neon",
        "dance sample:octopus sample:tune -k 48 --duration 0.2 --fps 10 --size 192x144 --look porcelain --palette prism --frames paler";
    "dance-project":
        "project new sample:head -k 48 -o me.chladni",
        "project add-layer me.chladni --template ellipsoid --mu -1",
        "dance me.chladni sample:tune -k 512 --duration 1 --coefficients dance.npz";
    "no-such-command": "sing";
    "no-arguments": "caricature";
};
