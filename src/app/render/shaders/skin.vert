// Rest-plus-offset position, unit normal with the depth of the dent in w, and what was baked from the rest surface.
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_normal;
layout(location = 2) in vec4 a_shade;

uniform mat4 u_clip_from_subject;

out vec3 v_position;
out vec3 v_normal;
out float v_dent;
out vec4 v_shade;

void main() {
    v_position = a_position;
    v_normal = a_normal.xyz;
    v_dent = a_normal.w;
    v_shade = a_shade;
    gl_Position = u_clip_from_subject * vec4(a_position, 1.0);
}
