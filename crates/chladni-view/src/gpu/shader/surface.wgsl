// Vertices of shapes: where they lie, and what their paint needs.

// Position and normal in the viewer's axes; all that bare surfaces hand on. Where it lies in the key
// light's map, in texels and depth, and how far from there is a step off its front.
struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

struct ValuedSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
}

struct ColoredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// Answers: place of the palette, and own light.
struct AnsweredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) answer: vec2f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// The same, and the outward displacement and lag.
struct FiguredSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) answer: vec4f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
}

// Corners carry whatever their paint needs: a value in x, a color, a (u, v) or an answer.
struct CornerSurface {
    @builtin(position) clip: vec4f,
    @location(0) at: vec3f,
    @location(1) normal: vec3f,
    @location(2) paint: vec3f,
    @location(3) map_at: vec3f,
    @location(4) map_step: vec3f,
    @location(5) barycentric: vec3f,
}

fn surface(position: vec3f, normal: vec3f) -> Surface {
    let scene = figure.model * vec4f(position, 1.0);
    let at = cell.view * scene;
    // The model matrix is a similarity: normals turn with it.
    let scene_normal = figure.model * vec4f(normal, 0.0);
    let turned = (cell.view * scene_normal).xyz;
    var s = Surface(cell.projection * at, at.xyz, turned, vec3f(0.0), vec3f(0.0));
    if SHADOWS {
        let texels = vec3f(vec2f(0.5, -0.5) * cell.shadow_map.y, 1.0);
        let first = cell.shadow_place.xy;
        let map = (cell.shadow * scene).xyz * texels + vec3f(first + 0.5 * cell.shadow_map.y, 0.0);
        // A disc around it stays in the map; what the camera cannot reach is beyond its edge.
        let inside = clamp(map.xy, first + 6.0, first + cell.shadow_map.y - 6.0);
        s.map_at = vec3f(inside, map.z);
        // More where the light grazes the surface.
        let length_of_normal = max(length(turned), 1e-12);
        let grazing = 1.0 - abs(dot(turned, cell.lights[0].direction.xyz)) / length_of_normal;
        let step = cell.shadow_map.z * (1.0 + 3.0 * grazing) / length_of_normal;
        s.map_step = (cell.shadow * scene_normal).xyz * texels * step;
    }
    return s;
}

@vertex
fn plain_vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Surface {
    return surface(position, normal);
}

@vertex
fn value_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) value: f32,
) -> ValuedSurface {
    let s = surface(position, normal);
    return ValuedSurface(s.clip, s.at, s.normal, value);
}

@vertex
fn color_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
) -> ColoredSurface {
    let s = surface(position, normal);
    return ColoredSurface(s.clip, s.at, s.normal, to_linear(color.rgb), s.map_at, s.map_step);
}

// The palette position and glow of a vertex that has left its rest.
fn answered(position: vec3f, normal: vec3f, rest: vec4f, bend: f32) -> vec2f {
    let d = position - rest.xyz;
    let way = length(d);
    let outward = dot(d, normal) / max(length(normal), 1e-12);
    let by = figure.answer;
    let place = by.x + by.y * rest.w + by.z * outward + by.w * way + figure.figured.w * bend;
    return vec2f(place, figure.glow.y * way);
}

@vertex
fn answer_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec4f,
    @location(3) bend: f32,
) -> AnsweredSurface {
    let s = surface(position, normal);
    let answer = answered(position, normal, rest, bend);
    return AnsweredSurface(s.clip, s.at, s.normal, answer, s.map_at, s.map_step);
}

@vertex
fn figured_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec4f,
    @location(3) bend: f32,
    @location(4) lagging: vec3f,
) -> FiguredSurface {
    let s = surface(position, normal);
    let lag = lagging - rest.xyz;
    let off = normal / max(length(normal), 1e-12);
    let by_speed = figure.figured.xy * length(lag);
    let answer = answered(position, normal, rest, bend) + by_speed;
    let outward = vec2f(dot(position - rest.xyz, off), dot(lag, off));
    return FiguredSurface(s.clip, s.at, s.normal, vec4f(answer, outward), s.map_at, s.map_step);
}

// Depth as the key light sees it.
@vertex
fn shadow_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return cell.shadow * figure.model * vec4f(position, 1.0);
}

// Depth as the viewer sees it.
@vertex
fn depth_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return cell.projection * (cell.view * (figure.model * vec4f(position, 1.0)));
}

// One vertex per corner, for what lives on corners: UVs with seams, and wires.
@vertex
fn corner_vertex(@builtin(vertex_index) corner: u32) -> CornerSurface {
    let v = vertex_of(corner);
    let position = position_of(v);
    let normal = normal_of(v);
    let s = surface(position, normal);
    let kind = u32(figure.back.w);
    var paint = vec3f(0.0);
    if kind == 1u { paint.x = bitcast<f32>(paint_at(v)); }
    if kind == 2u { paint = to_linear(unpack4x8unorm(paint_at(v)).rgb); }
    // Images begin at the top, v at the bottom.
    if kind == 3u {
        let uv = uv_of(corner);
        paint = vec3f(uv.x, 1.0 - uv.y, 0.0);
    }
    if kind == 4u {
        let i = 5u * v;
        let r = vec4u(paint_at(i), paint_at(i + 1u), paint_at(i + 2u), paint_at(i + 3u));
        let bend = bitcast<f32>(paint_at(i + 4u));
        paint = vec3f(answered(position, normal, bitcast<vec4f>(r), bend), 0.0);
    }
    let which = corner % 3u;
    let barycentric = vec3f(f32(which == 0u), f32(which == 1u), f32(which == 2u));
    return CornerSurface(s.clip, s.at, s.normal, paint, s.map_at, s.map_step, barycentric);
}
