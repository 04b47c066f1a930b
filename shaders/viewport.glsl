// The viewport: one picture at its place on the canvas. The stage to compile is defined before this text.
// All positions are in framebuffer pixels with y down, so that row 0 of the target is the top of the view.

#ifdef VERTEX_STAGE

void main() {
    // One triangle that covers everything.
    vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1));
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}

#endif

#ifdef FRAGMENT_STAGE

#include "view_transform.glsl"

uniform sampler2D picture;
uniform vec4 place;          // x, y, width, height of the picture
uniform bool encoded;        // the picture is sRGB already, not radiance
uniform bool has_alpha;
uniform float exposure_ev;
uniform vec3 canvas_srgb;

const float CHECK_PX = 12.0;

out vec4 shown;

vec3 checks(vec2 pixel) {
    vec2 cell = floor(pixel / CHECK_PX);
    return vec3(mod(cell.x + cell.y, 2.0) < 0.5 ? 0.32 : 0.42);
}

void main() {
    vec2 pixel = gl_FragCoord.xy;
    vec2 uv = (pixel - place.xy) / place.zw;
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        shown = vec4(canvas_srgb, 1.0);
        return;
    }
    vec4 texel = texture(picture, uv);
    vec3 srgb = encoded ? texel.rgb : view_transform(texel.rgb, exposure_ev);
    if (has_alpha) srgb = mix(checks(pixel - place.xy), srgb, clamp(texel.a, 0.0, 1.0));
    shown = vec4(srgb, 1.0);
}

#endif
