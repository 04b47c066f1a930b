// From scene radiance to the screen; the twin of relight_core/imaging/view_transform.py.
// Meant to be pasted into another shader, "#version 330" or later, before its main().

float view_clean(float radiance) {
    // By bits, since a compiler may assume that no number is NaN. Signed zeros and NaN become 0.
    uint bits = floatBitsToUint(radiance);
    if ((bits & 0x7fffffffu) > 0x7f800000u || (bits & 0x80000000u) != 0u) return 0.0;
    return bits == 0x7f800000u ? 65504.0 : min(radiance, 65504.0);
}

float view_encode(float linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

// linear: Rec.709 radiance, [0, inf). exposure_ev: stops. Returns sRGB in [0, 1].
vec3 view_transform(vec3 linear, float exposure_ev) {
    float gain = exp2(clamp(exposure_ev, -32.0, 32.0));
    vec3 shown = vec3(view_clean(linear.r), view_clean(linear.g), view_clean(linear.b)) * gain;
    shown = min(shown, vec3(65504.0));

    float peak = max(shown.r, max(shown.g, shown.b));
    if (peak > 1.0) {
        // Scale the largest channel to 1, which keeps the hue, then mix in white: at first as much as
        // keeps the luminance, never quite all.
        vec3 scaled = shown / peak;
        float dimmed = dot(scaled, vec3(0.2126, 0.7152, 0.0722));
        float missing = dimmed * (peak - 1.0) / max(1.0 - dimmed, 1e-4);
        shown = mix(scaled, vec3(1.0), 1.0 - exp(-missing));
    }
    return clamp(vec3(view_encode(shown.r), view_encode(shown.g), view_encode(shown.b)), 0.0, 1.0);
}
