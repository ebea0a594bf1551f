// Rest-plus-offset position, unit normal with the depth of the dent in w, and what was baked from the rest surface.
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_normal;
layout(location = 2) in vec4 a_shade;

#ifdef TINT
layout(location = 3) in float a_value;
uniform float u_low;
uniform float u_per_width;
uniform int u_cyclic;

// The share of the range; of a cyclic range the point on the circle, so that a triangle across its seam is not torn.
out vec2 v_value;
#endif

uniform mat4 u_clip_from_subject;

// Depth drawn before and colour drawn after must agree to the last bit.
invariant gl_Position;

out vec3 v_position;
out vec3 v_normal;
out float v_dent;
out vec4 v_shade;

void main() {
    v_position = a_position;
    v_normal = a_normal.xyz;
    v_dent = a_normal.w;
    v_shade = a_shade;
#ifdef TINT
    float share = (a_value - u_low) * u_per_width;
    v_value = u_cyclic == 1 ? vec2(cos(6.2831853 * share), sin(6.2831853 * share)) : vec2(share, 0.0);
#endif
    gl_Position = u_clip_from_subject * vec4(a_position, 1.0);
}
