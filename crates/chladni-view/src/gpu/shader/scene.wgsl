// Drawing of shapes, backgrounds and markers. Lighting happens in the viewer's axes, in linear
// light; colors leave premultiplied by their opacity.

struct Light { direction: vec4f, color: vec4f }

struct Cell {
    view: mat4x4f,
    projection: mat4x4f,
    lights: array<Light, 3>,
    // w: brightness of the upright softboxes.
    sky: vec4f,
    // w: how bright a panorama is.
    ground: vec4f,
    // Colors as sRGB numbers; w of the first: opacity; of the second: 1 where they run
    // upright, 2 for a halo.
    background_center: vec4f,
    background_corner: vec4f,
    // x, y, width, height in pixels.
    viewport: vec4f,
    // x: 1 where the target wants sRGB-encoded numbers; y: width over height of a picture behind, 0 for none; z: 1 in orthographic views; w: 1 for the curve
    // of film.
    output: vec4f,
    // From the scene to the key light's clip space.
    shadow: mat4x4f,
    // Strength, texels of a side of the map, size of a texel in the scene, -.
    shadow_map: vec4f,
    // The map's first texel among those of all maps, and the size of a texel in texture coordinates.
    shadow_place: vec4f,
    // Linear light of the bright line around.
    horizon: vec4f,
    // sRGB of the floor; w: how dark its shadow is.
    floor: vec4f,
    // The floor in the viewer's axes: normal and height of the eye; no normal where there is no floor.
    floor_plane: vec4f,
    // Along the floor from the shadow's middle, 1 at its edge.
    floor_axes: array<vec4f, 2>,
    // Exposure in the picture's left and right; strength of the background's middle in the left and right.
    wings: vec4f,
}

struct Figure {
    model: mat4x4f,
    // Linear light; w: opacity.
    color: vec4f,
    // Tint of back faces; w: paint (0 material, 1 values, 2 colors, 3 texture, 4 answer).
    back: vec4f,
    // Roughness, metal, softness, iridescence.
    material: vec4f,
    // Low, 1 / (high − low), row of the map, gloss of painted surfaces.
    scale: vec4f,
    // sRGB, opacity in w.
    wire: vec4f,
    // Width of the wire in pixels; first vertex: its upper bits and its lower 16; -.
    wire_width: vec4f,
    // sRGB of a brush's ring; w: its radius.
    brush: vec4f,
    // Linear light at grazing angles.
    edge: vec4f,
    // Of a palette: offset, along the shape, by a unit outward, by a unit in any direction.
    answer: vec4f,
    // Own light, more of it by a unit of length; saturation; 1 for palettes that are a circle.
    glow: vec4f,
    // Of a palette: by a unit of lag; light of its own by a unit of lag; turns in one vibration; by the bend.
    figured: vec4f,
    // sRGB of nodal lines, opacity in w.
    lines: vec4f,
    // Half their width as a share of the picture's height, and how far the surface may go.
    line: vec4f,
    // Linear light of its grains; w: their radius.
    grain: vec4f,
}

// Parts that a pipeline does not need are left out when it is compiled: a software device computes both sides of
// every branch.
override SHADOWS = true;
// Whether shadows are filtered between the texels of their map: without, a pixel must be no smaller.
override FILTERED = true;
// Whether a panorama shines in the place of sky, ground and softboxes.
override AROUND = false;
// Half the width, of 2, in which the picture's left passes into its right.
const WING = 0.3;

@group(0) @binding(0) var<uniform> cell: Cell;
@group(1) @binding(0) var<uniform> figure: Figure;
@group(2) @binding(0) var maps: texture_2d<f32>;
@group(2) @binding(1) var map_sampler: sampler;
@group(2) @binding(2) var skin: texture_2d<f32>;
@group(2) @binding(3) var skin_sampler: sampler;
@group(2) @binding(4) var shadows: texture_depth_2d;
@group(2) @binding(5) var shadow_sampler: sampler_comparison;
@group(2) @binding(6) var around: texture_2d<f32>;
@group(2) @binding(7) var around_sampler: sampler;
