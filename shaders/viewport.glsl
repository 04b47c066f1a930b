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

#ifdef RECIPE
#include "recipe.glsl"
#else
uniform sampler2D picture;
#endif
uniform vec4 place;          // x, y, width, height of the picture before its turn
uniform float roll;          // its turn about its middle, counterclockwise, in radians
uniform bool encoded;        // the picture is sRGB already, not radiance
uniform bool has_alpha;      // by which the colours of a picture are multiplied already
uniform float exposure_ev;
uniform vec3 canvas_srgb;
uniform float check_px;      // side of a check behind what is transparent

out vec4 shown;

vec3 checks(vec2 pixel) {
    vec2 cell = floor(pixel / check_px);
    return vec3(mod(cell.x + cell.y, 2.0) < 0.5 ? 0.32 : 0.42);
}

float view_decode(float code) {
    return code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4);
}

// sRGB before the checks; light mixes, codes do not.
vec3 over_checks(vec3 srgb, float cover, vec2 pixel) {
    vec3 ground = checks(pixel);
    for (int i = 0; i < 3; i++) srgb[i] = view_encode(mix(view_decode(ground[i]), view_decode(srgb[i]), cover));
    return srgb;
}

// Apart, since drawing in software pays for a branch that is not taken.
#ifdef INSPECTED

const int SCALE = 1, DIFFERENCE = 2;

uniform sampler2D photo;     // what a difference is taken to; lies where the picture lies
uniform sampler2D colours;   // a row of colours, from the least value to the largest
uniform int paint;           // SCALE, DIFFERENCE or neither
uniform float range_ev;      // at the ends of a difference's colours
uniform bool clipping;       // stripes over what the screen can't show
uniform float stripe_px;

const float DARKEST = 0.002; // radiance below which a difference in stops means nothing
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
const vec3 TOO_BRIGHT = vec3(0.95, 0.22, 0.16), TOO_DARK = vec3(0.22, 0.45, 1.0), NO_NUMBER = vec3(1.0, 0.0, 0.85);

bool no_number(float value) {
    // By bits, since a compiler may assume that no number is NaN. Infinity was stored as the largest half.
    return (floatBitsToUint(value) & 0x7fffffffu) > 0x7f800000u || value >= 65504.0;
}

float stops_brighter(vec3 radiance, vec3 reference) {
    float now = dot(max(radiance, 0.0), LUMINANCE) * exp2(exposure_ev);
    float before = dot(max(reference, 0.0), LUMINANCE);
    return log2((now + DARKEST) / (before + DARKEST));
}

vec3 from_colours(float along) {
    float width = float(textureSize(colours, 0).x);
    return texture(colours, vec2((clamp(along, 0.0, 1.0) * (width - 1.0) + 0.5) / width, 0.5)).rgb;
}

vec3 striped(vec3 srgb, vec3 radiance, vec2 pixel) {
    if (no_number(radiance.r) || no_number(radiance.g) || no_number(radiance.b)) return NO_NUMBER;
    vec3 code = view_transform(radiance, exposure_ev) * 255.0;
    float peak = max(radiance.r, max(radiance.g, radiance.b)) * exp2(exposure_ev);
    bool bright = peak >= 1.0, dark = max(code.r, max(code.g, code.b)) < 0.5;
    if (!bright && !dark) return srgb;
    bool on = mod(bright ? pixel.x + pixel.y : pixel.x - pixel.y, 2.0 * stripe_px) < stripe_px;
    return on ? (bright ? TOO_BRIGHT : TOO_DARK) : srgb;
}

vec3 inspected(vec3 srgb, vec3 texel, vec2 uv, vec2 pixel) {
    if (paint == SCALE) srgb = from_colours(texel.g);
    if (paint == DIFFERENCE) {
        vec4 before = texture(photo, uv);
        float stops = stops_brighter(texel, before.rgb / max(before.a, 1e-6));
        srgb = from_colours(0.5 + 0.5 * stops / range_ev);
    }
    return clipping && !encoded ? striped(srgb, texel, pixel) : srgb;
}

#endif

void main() {
    vec2 pixel = gl_FragCoord.xy;
    vec2 from_middle = pixel - place.xy - 0.5 * place.zw;
    // Without a turn exactly the pixel's own place, so that crisp pixels stay so.
    if (roll != 0.0) from_middle = mat2(cos(roll), sin(roll), -sin(roll), cos(roll)) * from_middle;
    vec2 uv = (from_middle + 0.5 * place.zw) / place.zw;
    if (any(lessThan(uv, vec2(0.0))) || any(greaterThanEqual(uv, vec2(1.0)))) {
        shown = vec4(canvas_srgb, 1.0);
        return;
    }
#if defined(RECIPE) && defined(SUPERSAMPLED)
    vec4 texel = relit_over(uv, 1.0 / place.zw);
#elif defined(RECIPE)
    vec4 texel = relit_at(uv);
#else
    vec4 texel = texture(picture, uv);
    if (has_alpha) texel.rgb /= max(texel.a, 1e-6);
#endif
    vec3 srgb = encoded ? texel.rgb : view_transform(texel.rgb, exposure_ev);
#ifdef INSPECTED
    srgb = inspected(srgb, texel.rgb, uv, pixel);
#endif
    float cover = has_alpha ? clamp(texel.a, 0.0, 1.0) : 1.0;
    if (cover < 1.0) srgb = over_checks(srgb, cover, pixel - place.xy);
    shown = vec4(srgb, 1.0);
}

#endif
