// Fingers and arrows: satin, in their own colour, under the lights of the skin.
in vec3 v_position;
in vec3 v_normal;
in vec4 v_color;

uniform vec4 u_eye;
uniform vec3 u_key;
uniform vec3 u_fill;

// Over a coloured skin fingers get a rim, so that their colour is not taken for one of its map.
uniform float u_rimmed;
uniform vec3 u_rim_color;

out vec4 o_color;

void main() {
    vec3 n = normalize(v_normal);
    vec3 v = normalize(u_eye.xyz - v_position * u_eye.w);
    float key = clamp((dot(n, u_key) + 0.25) / 1.25, 0.0, 1.0);
    float fill = clamp(dot(n, u_fill), 0.0, 1.0);
    float gloss = pow(clamp(dot(n, normalize(u_key + v)), 0.0, 1.0), 40.0);
    float edge = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
    vec3 color = v_color.rgb * (0.50 + 0.50 * key + 0.10 * fill) + vec3(0.30 * gloss + 0.14 * edge);
    float facing = clamp(dot(n, v), 0.0, 1.0);
    float rim = u_rimmed * (1.0 - smoothstep(0.30, 0.42, facing));
    o_color = vec4(mix(clamp(color, 0.0, 1.0), u_rim_color, rim), v_color.a);
}
