// The panels: triangles as Dear ImGui lists them, a texture times a colour. The stage is defined before this text.

#ifdef VERTEX_STAGE

in vec2 position;   // window units, y down
in vec2 texel;
in vec4 colour;     // sRGB and opacity, as it goes to the screen

uniform vec2 window_size;

out vec2 texel_here;
out vec4 colour_here;

void main() {
    texel_here = texel;
    colour_here = colour;
    gl_Position = vec4(2.0 * position.x / window_size.x - 1.0, 1.0 - 2.0 * position.y / window_size.y, 0.0, 1.0);
}

#endif

#ifdef FRAGMENT_STAGE

uniform sampler2D picture;

in vec2 texel_here;
in vec4 colour_here;

out vec4 shown;

void main() {
    shown = colour_here * texture(picture, texel_here);
}

#endif
