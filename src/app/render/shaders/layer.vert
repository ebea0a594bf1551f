layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_color;

uniform mat4 u_clip_from_subject;
uniform float u_strength;

out vec4 v_color;

void main() {
    v_color = vec4(a_color.rgb, a_color.a * u_strength);
    gl_Position = u_clip_from_subject * vec4(a_position, 1.0);
    // A touch towards the eye, as far as the edges of the skin.
    gl_Position.z -= 0.00035 * gl_Position.w;
}
