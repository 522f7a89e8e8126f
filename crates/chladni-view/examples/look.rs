//! Scratch: draws an OBJ in every material.
use chladni_view::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let (mut p, mut t) = (vec![], vec![]);
    let off = args[1].ends_with(".off");
    if off {
        let mut n = text.split_whitespace().skip(1).map(|x| x.parse::<f64>().unwrap());
        let (nv, nf) = (n.next().unwrap() as usize, n.next().unwrap() as usize);
        n.next();
        for _ in 0..nv {
            p.push([n.next().unwrap() as f32, n.next().unwrap() as f32, n.next().unwrap() as f32]);
        }
        for _ in 0..nf {
            n.next();
            t.push([n.next().unwrap() as u32, n.next().unwrap() as u32, n.next().unwrap() as u32]);
        }
    } else {
        for line in text.lines() {
            let mut w = line.split_whitespace();
            match w.next() {
                Some("v") => {
                    let v: Vec<f32> = w.map(|x| x.parse().unwrap()).collect();
                    p.push([v[0], v[1], v[2]]);
                }
                Some("f") => {
                    let f: Vec<u32> =
                        w.map(|x| x.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect();
                    for i in 1..f.len() - 1 {
                        t.push([f[0], f[i], f[i + 1]]);
                    }
                }
                _ => {}
            }
        }
    }
    let t0 = std::time::Instant::now();
    let gpu = Gpu::headless().unwrap();
    println!("{} {:?}", gpu.description(), t0.elapsed());
    let mut renderer = Renderer::new(&gpu);
    println!("renderer {:?}", t0.elapsed());
    let shape = PictureShape { positions: &p, triangles: &t, ..Default::default() };
    let values: Vec<f32> = p.iter().map(|p| (p[0] * 9.0).sin() * p[1]).collect();
    for (i, (name, material)) in Material::PRESETS.iter().enumerate() {
        let lights = if i == 4 { Lights::STAGE } else { Lights::STUDIO };
        let background =
            [Background::PAPER, Background::SLATE, Background::SLATE, Background::PAPER, Background::NIGHT]
                [i];
        let t0 = std::time::Instant::now();
        let pic = render_picture_with(
            &mut renderer,
            &PictureRequest {
                shapes: &[shape],
                width: 640,
                height: 640,
                camera: None,
                style: Style { material: *material, lights, background, wire: None },
            },
        )
        .unwrap();
        println!("{name} {:?}", t0.elapsed());
        std::fs::write(format!("/tmp/view_{name}.png"), pic.to_png().unwrap()).unwrap();
    }
    let heat = PictureShape { values: Some((&values, Scale::of(ColorMap::BlueRed, &values))), ..shape };
    let heat2 = PictureShape { values: Some((&values, Scale::of(ColorMap::Viridis, &values))), ..shape };
    for (name, style) in [
        ("heat", Style { background: Background::WHITE, ..Style::default() }),
        (
            "wire",
            Style { wire: Some(Wire::default()), background: Background::TRANSPARENT, ..Style::default() },
        ),
    ] {
        let pic = render_picture_with(
            &mut renderer,
            &PictureRequest { shapes: &[heat, heat2], width: 960, height: 540, camera: None, style },
        )
        .unwrap();
        std::fs::write(format!("/tmp/view_{name}.png"), pic.to_png().unwrap()).unwrap();
    }
    // timing
    let topology = Topology::new(&gpu, p.len(), &t).unwrap();
    let buffers = ItemBuffers::new(&gpu, p.len(), 1);
    buffers.write(&gpu, 0, &p, &smooth_normals(&p, &t)).unwrap();
    for (w, h) in [(480, 360), (640, 480), (1280, 720)] {
        let canvas = Canvas::new(&gpu, w, h).unwrap();
        let mut camera = Camera::looking(View::ThreeQuarter);
        camera.fit(p.iter().copied(), w as f32 / h as f32, 0.9);
        for shadow in [0.0, 0.8] {
            let cell = Cell {
                viewport: Rect::of_size(w, h),
                camera,
                lights: Lights { shadow, ..Lights::STUDIO },
                background: Background::SLATE,
                figures: &[Figure::new(&topology, &buffers, 0)],
                markers: &[],
            };
            let mut best = f64::MAX;
            for _ in 0..6 {
                let t0 = std::time::Instant::now();
                renderer.draw(&canvas, &[cell]).unwrap();
                canvas.read(&gpu).unwrap();
                best = best.min(t0.elapsed().as_secs_f64());
            }
            println!("{w}x{h} shadow {shadow}: {:.1} ms", best * 1e3);
        }
    }
}
