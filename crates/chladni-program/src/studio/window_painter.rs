//! Paints the window where the processor draws: egui's own triangles through a shader that is quick there.
//!
//! The shader of `egui_wgpu` can filter textures in two ways, and a uniform chooses. A software device
//! computes both sides of every branch: five more reads of the texture and dozens of integer divisions a
//! pixel, with which one filled window takes seven times as long.

use std::ops::Range;

use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use eframe::wgpu;
use egui::epaint::{ClippedShape, PaintCallbackInfo, Primitive, Vertex};
use egui::{ClippedPrimitive, Context, FullOutput, Plugin, Rect};

/// Takes what egui is about to paint, and paints it.
pub struct WindowPainter {
    state: RenderState,
    brush: Brush,
    vertices: Growing,
    indices: Growing,
}

impl WindowPainter {
    /// Has `ctx` painted this way where the processor draws; else, and where a target encodes colors by
    /// itself (no software device asks for one), egui goes on.
    pub fn install(ctx: &Context, state: &RenderState) {
        let software = state.device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        if software && !state.target_format.is_srgb() {
            ctx.add_plugin(Self::new(state.clone()));
        }
    }

    fn new(state: RenderState) -> Self {
        let device = &state.device;
        Self {
            brush: Brush::new(device, state.target_format),
            vertices: Growing::new(device, wgpu::BufferUsages::VERTEX),
            indices: Growing::new(device, wgpu::BufferUsages::INDEX),
            state,
        }
    }

    /// `primitives` as shapes that paint themselves, with what others paint between them.
    fn shapes(&mut self, primitives: Vec<ClippedPrimitive>) -> Vec<ClippedShape> {
        self.upload(&primitives);
        let textures = self.state.renderer.read();
        let (mut shapes, mut pieces) = (Vec::new(), Vec::new());
        let (mut first_index, mut first_vertex) = (0, 0);
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            match primitive {
                Primitive::Mesh(mesh) => {
                    let indices = first_index..first_index + mesh.indices.len() as u32;
                    first_index = indices.end;
                    if let Some(texture) = textures.texture(&mesh.texture_id) {
                        let texture = texture.bind_group.clone();
                        pieces.push(Piece { clip_rect, texture, indices, first_vertex });
                    }
                    first_vertex += mesh.vertices.len() as i32;
                }
                Primitive::Callback(callback) => {
                    shapes.push(self.painting(std::mem::take(&mut pieces)));
                    shapes.push(ClippedShape::new(clip_rect, callback));
                }
            }
        }
        shapes.push(self.painting(pieces));
        shapes
    }

    fn upload(&mut self, primitives: &[ClippedPrimitive]) {
        self.vertices.bytes.clear();
        self.indices.bytes.clear();
        for primitive in primitives {
            if let Primitive::Mesh(mesh) = &primitive.primitive {
                self.vertices.bytes.extend_from_slice(bytemuck::cast_slice(&mesh.vertices));
                self.indices.bytes.extend_from_slice(bytemuck::cast_slice(&mesh.indices));
            }
        }
        self.vertices.upload(&self.state);
        self.indices.upload(&self.state);
    }

    fn painting(&self, pieces: Vec<Piece>) -> ClippedShape {
        let (vertices, indices) = (self.vertices.buffer.clone(), self.indices.buffer.clone());
        let painting = Painting { brush: self.brush.clone(), vertices, indices, pieces };
        let callback = Callback::new_paint_callback(Rect::EVERYTHING, painting);
        ClippedShape::new(Rect::EVERYTHING, callback)
    }
}

impl Plugin for WindowPainter {
    fn debug_name(&self) -> &'static str {
        "window painter"
    }

    fn output_hook(&mut self, ctx: &Context, output: &mut FullOutput) {
        // What is painted names its textures, which egui would bring up to date only now.
        for (id, deltas) in output.textures_delta.set.drain() {
            let mut renderer = self.state.renderer.write();
            for delta in deltas {
                renderer.update_texture(&self.state.device, &self.state.queue, id, &delta);
            }
        }
        let shapes = std::mem::take(&mut output.shapes);
        output.shapes = self.shapes(ctx.tessellate(shapes, output.pixels_per_point));
    }
}

/// Triangles that share a texture and a clip rectangle.
struct Piece {
    clip_rect: Rect,
    texture: wgpu::BindGroup,
    indices: Range<u32>,
    first_vertex: i32,
}

/// Pieces in their order.
struct Painting {
    brush: Brush,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    pieces: Vec<Piece>,
}

impl CallbackTrait for Painting {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let points = screen.size_in_pixels.map(|pixels| pixels as f32 / screen.pixels_per_point);
        queue.write_buffer(&self.brush.screen, 0, bytemuck::bytes_of(&points));
        Vec::new()
    }

    fn paint(
        &self,
        info: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        pass.set_pipeline(&self.brush.pipeline);
        pass.set_bind_group(0, &self.brush.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for piece in &self.pieces {
            let clip = PaintCallbackInfo { clip_rect: piece.clip_rect, ..info }.clip_rect_in_pixels();
            if clip.width_px > 0 && clip.height_px > 0 {
                let [x, y, width, height] =
                    [clip.left_px, clip.top_px, clip.width_px, clip.height_px].map(|pixels| pixels as u32);
                pass.set_scissor_rect(x, y, width, height);
                pass.set_bind_group(1, &piece.texture, &[]);
                pass.draw_indexed(piece.indices.clone(), piece.first_vertex, 0..1);
            }
        }
    }
}

/// The pipeline, and the size of the window in points that it reads.
#[derive(Clone)]
struct Brush {
    pipeline: wgpu::RenderPipeline,
    screen: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Brush {
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let entry =
            |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let layout = |label, entries: &[_]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let uniform = |bytes| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: std::num::NonZeroU64::new(bytes),
        };
        let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        let screen_layout = layout("window", &[entry(0, vertex, uniform(8))]);
        // As egui makes its textures' groups, the last entry being what chooses its filter.
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let image_layout = layout(
            "window images",
            &[entry(0, fragment, image), entry(1, fragment, sampler), entry(2, fragment, uniform(16))],
        );
        let screen = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("window"),
            size: 8,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("window"),
            layout: &screen_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: screen.as_entire_binding() }],
        });
        Self { pipeline: pipeline(device, format, &screen_layout, &image_layout), screen, group }
    }
}

fn pipeline(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
    screen: &wgpu::BindGroupLayout,
    images: &wgpu::BindGroupLayout,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("window_painter.wgsl"));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("window"),
        bind_group_layouts: &[Some(screen), Some(images)],
        immediate_size: 0,
    });
    let over = |src_factor, dst_factor| wgpu::BlendComponent {
        src_factor,
        dst_factor,
        operation: wgpu::BlendOperation::Add,
    };
    let (one, blend) = (wgpu::BlendFactor::One, wgpu::BlendFactor::OneMinusSrcAlpha);
    let blend =
        wgpu::BlendState { color: over(one, blend), alpha: over(wgpu::BlendFactor::OneMinusDstAlpha, one) };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("window"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend: Some(blend),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A buffer as large as it has ever had to be, and what goes into it next.
struct Growing {
    usage: wgpu::BufferUsages,
    bytes: Vec<u8>,
    buffer: wgpu::Buffer,
}

impl Growing {
    fn new(device: &wgpu::Device, usage: wgpu::BufferUsages) -> Self {
        Self { usage, bytes: Vec::new(), buffer: Self::room(device, usage, 1 << 16) }
    }

    fn room(device: &wgpu::Device, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("window"),
            size,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    fn upload(&mut self, state: &RenderState) {
        let wanted = self.bytes.len() as u64;
        if self.buffer.size() < wanted {
            self.buffer = Self::room(&state.device, self.usage, wanted.next_power_of_two());
        }
        state.queue.write_buffer(&self.buffer, 0, &self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Color32, FontId, Sense, Shape, Stroke, Ui, pos2, vec2};
    use egui_kittest::Harness;

    /// Text, curves, something round, translucent and clipped, a gradient and an image of few pixels.
    struct Page(egui::TextureHandle);

    impl eframe::App for Page {
        fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
            let (rect, _) = ui.allocate_exact_size(vec2(280.0, 180.0), Sense::hover());
            let painter = ui.painter_at(rect.shrink(7.3));
            painter.rect_filled(rect, 0.0, Color32::from_rgb(40, 44, 52));
            let mut gradient = egui::Mesh::default();
            let colors = [Color32::RED, Color32::from_rgba_unmultiplied(20, 220, 90, 120), Color32::BLUE];
            for (at, color) in
                [pos2(20.0, 20.0), pos2(150.0, 30.0), pos2(60.0, 140.0)].into_iter().zip(colors)
            {
                gradient.colored_vertex(at, color);
            }
            gradient.add_triangle(0, 1, 2);
            painter.add(gradient);
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let place = Rect::from_min_size(pos2(170.0, 30.0), vec2(80.0, 61.0));
            painter.image(self.0.id(), place, whole, Color32::from_white_alpha(200));
            painter.rect_filled(place.translate(vec2(-50.0, 40.0)), 12.0, Color32::from_black_alpha(120));
            let wave = (0..60u8).map(f32::from).map(|i| pos2(20.0 + 4.0 * i, 150.0 + 12.0 * (0.4 * i).sin()));
            painter.add(Shape::line(wave.collect(), Stroke::new(2.3, Color32::YELLOW)));
            painter.circle_stroke(pos2(240.0, 180.0), 30.0, Stroke::new(3.0, Color32::WHITE));
            let font = FontId::proportional(17.0);
            painter.text(
                pos2(30.0, 60.0),
                egui::Align2::LEFT_TOP,
                "Ernst Chladni, 1787",
                font,
                Color32::WHITE,
            );
        }
    }

    fn window(own: bool) -> Harness<'static, Page> {
        let builder = Harness::builder().with_size([300.0, 200.0]).with_pixels_per_point(1.25).wgpu();
        builder.build_eframe(move |creation| {
            let state = creation.wgpu_render_state.clone().expect("wgpu");
            if own {
                creation.egui_ctx.add_plugin(WindowPainter::new(state));
            }
            let pixels = (0..12u8).map(|i| Color32::from_rgb(20 * i, 255 - 20 * i, 90)).collect();
            let image = egui::ColorImage::new([4, 3], pixels);
            Page(creation.egui_ctx.load_texture("few pixels", image, egui::TextureOptions::LINEAR))
        })
    }

    #[test]
    fn it_paints_what_egui_paints() {
        let [mut own, mut eguis] = [true, false].map(window);
        for _ in 0..2 {
            own.run_steps(2);
            eguis.run_steps(2);
            let (own, eguis) = (own.render().expect("it draws"), eguis.render().expect("it draws"));
            assert_eq!(own.dimensions(), eguis.dimensions());
            let apart = |(a, b): (&u8, &u8)| a.abs_diff(*b);
            let most = own.as_raw().iter().zip(eguis.as_raw()).map(apart).max();
            assert!(most <= Some(2), "{most:?}");
            let (low, high) = (eguis.as_raw().iter().min(), eguis.as_raw().iter().max());
            assert!(low < Some(&20) && high > Some(&240), "{low:?} {high:?}");
        }
    }

    #[test]
    fn what_others_paint_stays_in_its_place() {
        let mut tried = false;
        let builder = Harness::builder().with_size([100.0, 100.0]).wgpu();
        builder.build_eframe(|creation| {
            let state = creation.wgpu_render_state.clone().expect("wgpu");
            let mut painter = WindowPainter::new(state);
            let mesh = || Primitive::Mesh(egui::Mesh::default());
            let Shape::Callback(other) = painter.painting(Vec::new()).shape else { panic!("no callback") };
            let primitives = [mesh(), mesh(), Primitive::Callback(other.clone()), mesh()];
            let clip_rect = Rect::EVERYTHING;
            let shapes =
                painter.shapes(primitives.map(|primitive| ClippedPrimitive { clip_rect, primitive }).into());
            let is_other =
                |shape: &ClippedShape| matches!(&shape.shape, Shape::Callback(own) if *own == other);
            tried = shapes.iter().map(is_other).eq([false, true, false]);
            Page(creation.egui_ctx.load_texture("none", egui::ColorImage::example(), Default::default()))
        });
        assert!(tried);
    }
}
