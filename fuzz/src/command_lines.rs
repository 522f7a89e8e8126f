//! A command line of each command, an argument between two spaces.

pub const COMMAND_LINES: [(&str, &str); 25] = [
    ("window", "--quiet"),
    ("open", "open head.obj song.flac --live=Mic --autopilot --measure 5 -o set.mp4 --size 640x360"),
    ("open_pipe", "open head.obj song.flac -o - --format rgba --draw cpu"),
    ("demo", "demo -o folder --quiet"),
    ("info", "info sample:octopus --json"),
    ("caricature", "caricature head.obj sphere --mu -2.5 -o out.ply"),
    (
        "caricature_layer",
        "caricature sample:head self:lowpass=20 -k 64 --model normal --strength 0.5 --cutoff 30% --roll-off sharp \
         --no-clamp --mask m.npz --mask-channel mask --up z --front -y -o out.glb",
    ),
    (
        "caricature_gallery",
        "caricature head.ply --gallery --choose 1,4 --lock scales --seed 7 -o gallery.png",
    ),
    (
        "caricature_ink",
        "caricature head.ply sphere:0,0,0,1 --ink --ink-detail 0.5 --ink-colors #102030,#ffffff --render p.svg",
    ),
    ("caricature_batch", "caricature --recipe r.chladni --batch list.txt --piece 2/8 --resume -o out"),
    ("project_new", "project new sample:head -o p.chladni -k 128"),
    ("project_layer", "project add-layer p.chladni --template ellipsoid --mu 1.5"),
    ("project_show", "project show p.chladni --json"),
    ("dance", "dance sample:octopus song.flac -o out.mp4 --size 640x360 --set gain=0.5"),
    (
        "dance_show",
        "dance --show s.toml --frames out --piece 10..20 --resume --fps 30000/1001 --start 1.5 --duration 2 \
         --without glow --yaw 30 --samples 1 --allow-flashes --json",
    ),
    ("dance_set", "dance a.glb song.mp3 -o out.gif --form modal --choir symmetric --mu 0.5 --look ember"),
    ("match", "match a.obj b.obj --method icp --landmarks l.txt --rigid --seed 3 -o m.npz --json"),
    ("mean", "mean a.ply b.ply c.ply --match same -o mean.ply"),
    ("transfer", "transfer a.obj b.obj c.obj --amount -1 -o out.obj"),
    ("parts", "parts sample:head --level 0.5 --proxy 2000 --render p.png --view 30,-10"),
    ("mask", "mask head.ply --limb 1,2 --level 0.3 -o m.ply --as-colors"),
    (
        "basis",
        "basis a.obj -k 64 -o folder/ --engine slepc --ranks 4 --groups 2 --hosts hosts.txt --memory 2.5",
    ),
    ("beats", "beats song.ogg --causal --json"),
    (
        "spectrum",
        "spectrum song.wav --render s.png --fps 20 --bands 64 --linear --decay 0.5 --start 1 --duration 2",
    ),
    ("symmetry", "symmetry sample:starfish -k 50 --paper --render s.png"),
];
