// Bones and hands: dull, under the lights of the skin. Light linear, output sRGB.
in vec3 v_position;
in vec3 v_normal;
in float v_tone;

uniform vec4 u_eye;
uniform vec3 u_key;
uniform vec3 u_fill;
uniform vec3 u_rim;
uniform vec3 u_up;
uniform vec3 u_colors[2];    // linear
uniform float u_gloss;
// Over a coloured skin what wears a finger's colour gets a rim, so that it is not taken for one of the map.
uniform float u_rimmed;
uniform vec3 u_rim_color;

out vec4 o_color;

vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    vec3 a = sqrt(c);
    vec3 b = sqrt(a);
    return max(0.662003 * a + 0.684122 * b - 0.323584 * sqrt(b) - 0.022541 * c, 0.0);
}

void main() {
    vec3 n = normalize(v_normal);
    vec3 v = normalize(u_eye.xyz - v_position * u_eye.w);
    float facing = clamp(dot(n, v), 0.0, 1.0);
    vec3 albedo = mix(u_colors[0], u_colors[1], clamp(v_tone, 0.0, 1.0));
    float key = clamp((dot(n, u_key) + 0.35) / 1.35, 0.0, 1.0);
    float fill = clamp((dot(n, u_fill) + 0.3) / 1.3, 0.0, 1.0);
    vec3 sky = mix(vec3(0.16, 0.14, 0.13), vec3(0.34, 0.34, 0.35), 0.5 + 0.5 * dot(n, u_up));
    // Less light reaches what turns away: solids stand in each other's way.
    float open = mix(0.45, 1.0, smoothstep(0.0, 0.75, facing));
    vec3 diffuse = sky * open + key * key * vec3(1.0, 0.97, 0.92) * open + fill * fill * vec3(0.22, 0.23, 0.25);
    float gloss = u_gloss * pow(clamp(dot(n, normalize(u_key + v)), 0.0, 1.0), 24.0);
    float edge = 0.07 * pow(1.0 - facing, 3.0) * max(0.3 + 0.7 * dot(n, u_rim), 0.0);
    vec3 color = srgb(albedo * diffuse + gloss + edge);
    float rim = u_rimmed * (1.0 - smoothstep(0.30, 0.42, facing));
    o_color = vec4(mix(color, u_rim_color, rim), 1.0);
}
