// A ball in the light in force, half matte card and half varnish, seen from the camera.
// Row 0 of the target is its top. The stage to compile is defined before this text.

#ifdef VERTEX_STAGE

void main() {
    vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1));
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}

#endif

#ifdef FRAGMENT_STAGE

#include "view_transform.glsl"

uniform sampler2D matte;     // lat-long over the normal: radiance of a matte surface, the light unturned
uniform sampler2D gloss;     // lat-long over the mirrored direction: the light, blurred
uniform float side_px;
uniform float yaw_turns;     // of the light, in turns

const float PI = 3.14159265358979;
const float REFLECTANCE = 0.05;

out vec4 shown;

vec2 lat_long(vec3 direction) {
    float turned = atan(direction.x, -direction.z) / (2.0 * PI) + 0.5 - yaw_turns;
    return vec2(turned, acos(clamp(direction.y, -1.0, 1.0)) / PI);
}

void main() {
    vec2 at = vec2(gl_FragCoord.x, side_px - gl_FragCoord.y) * 2.0 / side_px - 1.0;
    float radius = length(at);
    float coverage = clamp((1.0 - radius) * side_px / 2.0 + 0.5, 0.0, 1.0);
    at *= min(1.0, 0.999 / max(radius, 1e-6));
    vec3 normal = vec3(at, sqrt(max(1.0 - dot(at, at), 0.0)));
    vec3 mirrored = 2.0 * normal.z * normal - vec3(0.0, 0.0, 1.0);
    float fresnel = REFLECTANCE + (1.0 - REFLECTANCE) * pow(1.0 - normal.z, 5.0);
    // Level 0 by hand: across the seam of the lat-long map the derivatives mean nothing.
    vec3 radiance = textureLod(matte, lat_long(normal), 0.0).rgb;
    radiance += fresnel * textureLod(gloss, lat_long(mirrored), 0.0).rgb;
    shown = vec4(view_transform(radiance, 0.0), coverage);
}

#endif
