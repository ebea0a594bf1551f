// Two pictures that stand side by side in one texture, brought together for a red and a cyan filter.
in vec2 v_uv;

uniform sampler2D u_picture;
uniform mat3 u_left;
uniform mat3 u_right;

out vec4 o_color;

vec3 linear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
    vec2 half_uv = vec2(0.5 * v_uv.x, v_uv.y);
    vec3 left = linear(texture(u_picture, half_uv).rgb);
    vec3 right = linear(texture(u_picture, half_uv + vec2(0.5, 0.0)).rgb);
    o_color = vec4(srgb(u_left * left + u_right * right), 1.0);
}
