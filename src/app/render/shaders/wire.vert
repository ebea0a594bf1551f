layout(location = 0) in vec3 a_position;

uniform mat4 u_clip_from_subject;

void main() {
    gl_Position = u_clip_from_subject * vec4(a_position, 1.0);
    // A touch towards the eye, so that an edge wins over its own triangles and loses to those in front.
    gl_Position.z -= 0.00035 * gl_Position.w;
}
