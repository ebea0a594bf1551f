// A mesh that does not change, where its place puts it. In w of the normal: how much of the second colour.
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_normal;

uniform mat4 u_clip_from_subject;
uniform mat4 u_subject_from_model;   // turns, moves and scales evenly

out vec3 v_position;
out vec3 v_normal;
out float v_tone;

void main() {
    vec4 position = u_subject_from_model * vec4(a_position, 1.0);
    v_position = position.xyz;
    v_normal = mat3(u_subject_from_model) * a_normal.xyz;
    v_tone = a_normal.w;
    gl_Position = u_clip_from_subject * position;
}
