// egui's triangles. Colors are sRGB-encoded numbers times their opacity, in and out.

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) at_image: vec2f,
    @location(1) color: vec4f,
}

// Width and height of the window in points.
@group(0) @binding(0) var<uniform> screen: vec2f;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

@vertex
fn vertex(@location(0) at: vec2f, @location(1) at_image: vec2f, @location(2) color: vec4f) -> Corner {
    let share = at / screen;
    return Corner(vec4f(2.0 * share.x - 1.0, 1.0 - 2.0 * share.y, 0.0, 1.0), at_image, color);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4f {
    let color = in.color * textureSample(image, image_sampler, in.at_image);
    // Jimenez' interleaved gradient noise ("Next Generation Post-Processing in Call of Duty", 2014), as
    // egui's: less than half a step of eight bits, so that even colors stay even.
    let noise = fract(52.9829189 * fract(dot(in.clip.xy, vec2f(0.06711056, 0.00583715))));
    return vec4f(color.rgb + 0.95 * (noise - 0.5) / 255.0, color.a);
}
