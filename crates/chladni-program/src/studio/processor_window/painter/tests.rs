//! Tests of the pixels that the painter covers, and of their colors.

use egui::{Color32, Rect, TextureOptions, pos2, vec2};
use epaint::TextureManager;
use proptest::prelude::*;

use super::*;

const SIZE: [usize; 2] = [64, 80];
const BLACK: u32 = 0xff00_0000;

/// A painter with a white texture and one of 8 × 8 texels, each of its own color.
fn painter() -> (Painter, [TextureId; 2]) {
    let mut textures = TextureManager::default();
    let options = TextureOptions::LINEAR;
    let white = ColorImage::filled([1, 1], Color32::WHITE);
    let colors = ColorImage::new([8, 8], (0..64).map(|i| Color32::from_rgb(4 * i, 255 - i, i)).collect());
    let ids = [white, colors].map(|image| textures.alloc("test".into(), image.into(), options));
    let mut painter = Painter::default();
    painter.update(&mut textures.take_delta());
    (painter, ids)
}

fn paint(painter: &mut Painter, clip_rect: Rect, mesh: Mesh) -> Vec<u32> {
    let mut pixels = vec![0; SIZE[0] * SIZE[1]];
    let primitive = ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) };
    painter.paint(&[primitive], 1.0, SIZE[0], BLACK, &mut pixels);
    pixels
}

fn fan(texture: TextureId, color: Color32, center: [f32; 2], rim: &[[f32; 2]]) -> Mesh {
    let mut mesh = Mesh::with_texture(texture);
    for [x, y] in [center].iter().chain(rim) {
        mesh.vertices.push(Vertex { pos: pos2(*x, *y), uv: pos2(0.0, 0.0), color });
    }
    let count = rim.len() as u32;
    mesh.indices.extend((0..count).flat_map(|i| [0, i + 1, (i + 1) % count + 1]));
    mesh
}

fn columns(pixels: &[u32]) -> impl Iterator<Item = (f32, f32, u32)> {
    pixels.iter().zip(0..).map(|(pixel, i): (&u32, usize)| {
        ((i % SIZE[0]) as f32 + 0.5, (i / SIZE[0]) as f32 + 0.5, pixel & 0xff)
    })
}

proptest! {
    /// Triangles around a point leave no gap between them and share no pixel, wherever the point lies.
    #[test]
    fn triangles_that_meet_cover_each_pixel_once(x in 5.0f32..59.0, y in 5.0f32..75.0, flips in 0u8..16) {
        let (mut painter, [white, _]) = painter();
        let corners = [[2.0, 3.0], [61.0, 3.0], [61.0, 77.0], [2.0, 77.0]];
        let mut mesh = fan(white, Color32::from_white_alpha(128), [x, y], &corners);
        // egui winds its triangles either way.
        for (triangle, i) in mesh.indices.as_chunks_mut::<3>().0.iter_mut().zip(0..) {
            if flips >> i & 1 == 1 {
                triangle.swap(1, 2);
            }
        }
        let pixels = paint(&mut painter, Rect::EVERYTHING, mesh);
        for (x, y, blue) in columns(&pixels) {
            let inside = (2.0..61.0).contains(&x) && (3.0..77.0).contains(&y);
            prop_assert_eq!(blue, if inside { 128 } else { 0 }, "{} {}", x, y);
        }
    }

    /// No coordinates, however large or damaged, leave the picture.
    #[test]
    fn any_triangle_stays_within_the_picture(numbers in prop::array::uniform6(prop::num::f32::ANY)) {
        let (mut painter, [_, colors]) = painter();
        let [a, b, c, d, e, f] = numbers;
        let mut mesh = fan(colors, Color32::WHITE, [a, b], &[[c, d], [e, f]]);
        mesh.vertices[1].uv = pos2(f, a);
        paint(&mut painter, Rect::EVERYTHING, mesh.clone());
        let clip = Rect::from_min_max(pos2(a, b), pos2(c, d));
        paint(&mut painter, clip, mesh);
    }
}

#[test]
fn nothing_is_painted_outside_of_a_clip_rectangle() {
    let (mut painter, [white, _]) = painter();
    let clip = Rect::from_min_max(pos2(10.0, 20.0), pos2(30.0, 70.0));
    let mut mesh = Mesh::with_texture(white);
    mesh.add_colored_rect(Rect::from_min_size(pos2(-9.0, -9.0), vec2(300.0, 300.0)), Color32::WHITE);
    for (x, y, blue) in columns(&paint(&mut painter, clip, mesh)) {
        assert_eq!(blue == 255, clip.contains(pos2(x, y)), "{x} {y}");
    }
}

#[test]
fn a_texture_that_lies_on_the_pixels_is_copied_and_a_larger_one_is_filtered() {
    let (mut painter, [_, colors]) = painter();
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let mut show = |scale: f32| {
        let mut mesh = Mesh::with_texture(colors);
        mesh.add_rect_with_uv(
            Rect::from_min_size(pos2(8.0, 16.0), vec2(8.0, 8.0) * scale),
            whole,
            Color32::WHITE,
        );
        paint(&mut painter, Rect::EVERYTHING, mesh)
    };
    let (copied, doubled) = (show(1.0), show(2.0));
    let green = |pixel: u32| i64::from(pixel >> 8 & 0xff);
    for i in 0..64_usize {
        let (x, y) = (i % 8, i / 8);
        assert_eq!(copied[(16 + y) * SIZE[0] + 8 + x], BLACK | ((4 * i) << 16 | (255 - i) << 8 | i) as u32);
    }
    // Between two columns it changes by a half.
    let row = &doubled[20 * SIZE[0]..][8..24];
    assert!(row.windows(2).all(|pair| (0..=1).contains(&(green(pair[0]) - green(pair[1])))), "{row:x?}");
}

#[test]
fn a_part_of_a_texture_can_change_and_what_is_gone_is_not_painted() {
    let (mut painter, [_, colors]) = painter();
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let mut mesh = Mesh::with_texture(colors);
    mesh.add_rect_with_uv(Rect::from_min_size(pos2(0.0, 0.0), vec2(8.0, 8.0)), whole, Color32::WHITE);
    let red = ColorImage::filled([2, 3], Color32::RED);
    for pos in [[3, 4], [7, 7]] {
        painter.change(colors, ImageDelta::partial(pos, red.clone(), TextureOptions::LINEAR));
    }
    let pixels = paint(&mut painter, Rect::EVERYTHING, mesh.clone());
    let is_red = |x: usize, y: usize| pixels[y * SIZE[0] + x] == 0xffff_0000;
    assert!(is_red(3, 4) && is_red(4, 6) && !is_red(5, 4) && !is_red(3, 7) && !is_red(2, 4));
    let mut gone = TexturesDelta::default();
    gone.free(colors);
    painter.forget(&mut gone);
    assert!(paint(&mut painter, Rect::EVERYTHING, mesh).iter().all(|pixel| *pixel == BLACK));
}

#[test]
fn colors_blend_from_corner_to_corner_and_light_is_cut_off() {
    let (mut painter, [white, _]) = painter();
    let mut mesh = Mesh::with_texture(white);
    mesh.add_colored_rect(Rect::from_min_size(pos2(0.0, 0.0), vec2(64.0, 80.0)), Color32::BLACK);
    for vertex in mesh.vertices.iter_mut().filter(|vertex| vertex.pos.x > 1.0) {
        vertex.color = Color32::from_rgb(0, 0, 255);
    }
    for (x, _, blue) in columns(&paint(&mut painter, Rect::EVERYTHING, mesh.clone())) {
        assert!((blue as f32 - 255.0 * x / 64.0).abs() <= 0.75, "{x} {blue}");
    }
    // Color32::from_rgb_additive: light that hides nothing.
    for vertex in &mut mesh.vertices {
        vertex.color = Color32::from_rgb_additive(0, 0, 200);
    }
    let mut twice = mesh.clone();
    twice.append(mesh);
    assert!(paint(&mut painter, Rect::EVERYTHING, twice).iter().all(|pixel| *pixel == 0xff00_00ff));
}
