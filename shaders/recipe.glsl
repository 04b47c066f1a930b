// A relit picture from small maps; the twin of relight_core/pipeline/results/picture.py.
// To be pasted into a fragment shader. OVER: something else is behind the person than in the photo. EYES: that mirror.

const int MOST_VIEWS = 16;

uniform sampler2D person;       // the person's own colour times the matte, and the matte; linear
uniform sampler2D behind;       // what the photo holds beside that
uniform vec2 size;              // of the picture, in texels of these two; beyond it they go on
uniform sampler2D gain;         // of the faces' views, one below the other
uniform sampler2D offset;
uniform sampler2D rest;         // gain beyond the views, over the whole picture
uniform int views;
uniform mat3x2 to_view[MOST_VIEWS];
uniform bool dimmed;            // what is behind is no darker than black
uniform vec3 behind_gain;
uniform bool transparent;
uniform vec3 black;             // what lies over all of the picture
uniform vec3 left_by_black;     // of the light that it lies over
uniform bool crisp;             // a pixel of the picture is one square on the screen, and all of it as its middle
uniform float level;            // of the averages to read where the picture is shown smaller than it is

#ifdef OVER

uniform sampler2D backdrop;     // what is behind the person instead
uniform sampler2D soft;         // the same blurred
uniform sampler2D nearby;       // the matte averaged about each place
uniform bool own_alpha;         // the matte itself serves for that

const float LENS_VEIL = 0.01, LIGHT_WRAP = 0.5, MOST_WRAP = 0.25;

#endif

#ifdef EYES

const int MOST_EYES = 32;

uniform sampler2D catchlights;          // of the eyes' views, one below the other; 0 at their borders
uniform int eyes;
uniform mat3x2 to_eye[MOST_EYES];
uniform float eye_level;                // as `level`, as far as eyes' maps stay apart

vec3 mirrored_at(vec2 uv) {
    vec3 mirrored = vec3(0.0);
    for (int i = 0; i < eyes; i++) {
        vec2 within = to_eye[i] * vec3(uv, 1.0);
        if (max(abs(within.x - 0.5), abs(within.y - 0.5)) >= 0.5) continue;
        mirrored += textureLod(catchlights, vec2(within.x, (float(i) + within.y) / float(eyes)), eye_level).rgb;
    }
    return mirrored;
}

#endif

vec4 with_black(vec3 radiance, float coverage) {
    return vec4(max(black + left_by_black * radiance, 0.0), coverage);
}

// Radiance and coverage at a place in the picture, [0, 1] across and down.
vec4 relit_at(vec2 uv) {
    if (crisp) {
        uv = (floor(uv * size) + 0.5) / size;
    }
    float nearest = 0.5;
    vec3 spot = vec3(0.0, 0.0, -1.0);
    for (int i = 0; i < views; i++) {
        vec2 within = to_view[i] * vec3(uv, 1.0);
        float away = max(abs(within.x - 0.5), abs(within.y - 0.5));
        if (away < nearest) {
            nearest = away;
            spot = vec3(within, float(i));
        }
    }
    // Not into the neighbour's map: half a texel from the edge is where the border's value is reached.
    float half_texel = 0.5 / float(textureSize(gain, 0).x);
    vec2 at = vec2(spot.x, (max(spot.z, 0.0) + clamp(spot.y, half_texel, 1.0 - half_texel)) / float(views));
    bool known = spot.z >= 0.0;
    vec2 stored = uv * size / vec2(textureSize(person, 0));
    vec4 own = textureLod(person, stored, level);
    vec3 lit = own.rgb * (known ? textureLod(gain, at, 0.0).rgb : textureLod(rest, uv, 0.0).rgb);
    lit += own.a * (known ? textureLod(offset, at, 0.0).rgb : vec3(0.0));
#ifdef EYES
    lit = max(lit + own.a * mirrored_at(uv), 0.0);
#endif
    if (transparent) return with_black(lit / max(own.a, 1e-6), own.a);
#ifdef OVER
    float near = own_alpha ? own.a : textureLod(nearby, uv, 0.0).r;
    vec3 wrapped = min(own.a * LENS_VEIL + LIGHT_WRAP * own.rgb, own.a * MOST_WRAP);
    vec3 over = (1.0 - own.a) * textureLod(backdrop, uv, 0.0).rgb;
    return with_black(lit + over + (1.0 - near) * wrapped * textureLod(soft, uv, 0.0).rgb, 1.0);
#else
    vec3 beside = textureLod(behind, stored, level).rgb;
    beside = dimmed ? max(beside, 0.0) : beside;
    return with_black(lit + beside * behind_gain, 1.0);
#endif
}

#ifdef SUPERSAMPLED

// The same averaged over a pixel of the screen of this extent, by one sample in each of its quarters. A texture look-up
// averages the photo and the gain apart, and the product of two averages is not the average of the picture where the
// gain has an edge.
vec4 relit_over(vec2 uv, vec2 extent) {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        vec4 quarter = relit_at(uv + extent * (vec2(i & 1, i >> 1) - 0.5) * 0.5);
        sum += vec4(quarter.rgb * quarter.a, quarter.a);
    }
    return vec4(sum.rgb / max(sum.a, 1e-6), sum.a / 4.0);
}

#endif
