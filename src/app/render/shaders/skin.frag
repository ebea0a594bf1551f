// Skin under three soft lights. All vectors in the frame of the subject, all light linear, output sRGB.
in vec3 v_position;
in vec3 v_normal;
in float v_dent;
in vec4 v_shade;

uniform vec4 u_eye;          // eye and 1, or the direction to it and 0 in orthographic view
uniform vec3 u_key;          // directions to the lights
uniform vec3 u_fill;
uniform vec3 u_rim;
uniform vec3 u_albedo;
uniform float u_exposure;
uniform float u_pores;       // strength of the finest relief, 0 where it would be smaller than a pixel
uniform vec4 u_fingers[4];   // centre and radius of the finger spheres, mm
uniform int u_n_fingers;

out vec4 o_color;

float hash(vec3 p) {
    p = fract(p * 0.3183099 + vec3(0.11, 0.17, 0.13));
    p *= 17.0;
    return fract(p.x * p.y * p.z * (p.x + p.y + p.z));
}

float value_noise(vec3 p) {
    vec3 i = floor(p);
    vec3 f = fract(p);
    f = f * f * (3.0 - 2.0 * f);
    return mix(
        mix(mix(hash(i), hash(i + vec3(1, 0, 0)), f.x), mix(hash(i + vec3(0, 1, 0)), hash(i + vec3(1, 1, 0)), f.x), f.y),
        mix(mix(hash(i + vec3(0, 0, 1)), hash(i + vec3(1, 0, 1)), f.x), mix(hash(i + vec3(0, 1, 1)), hash(i + vec3(1, 1, 1)), f.x), f.y),
        f.z);
}

// Light that wraps past the terminator, red farthest: what scattering under the skin does to a shadow's edge.
vec3 wrapped(float cosine) {
    const vec3 w = vec3(0.42, 0.30, 0.24);
    vec3 lit = clamp((vec3(cosine) + w) / (1.0 + w), 0.0, 1.0);
    // Squared: it fades out without a kink.
    return lit * lit;
}

vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), c));
}

void main() {
    vec3 n = normalize(v_normal);
    vec3 v = normalize(u_eye.xyz - v_position * u_eye.w);
    if (!gl_FrontFacing) {
        // The inside of an open skin: plain, so that it is not taken for the back.
        float lit = 0.5 + 0.5 * abs(dot(n, v));
        o_color = vec4(srgb(vec3(0.085, 0.078, 0.076) * lit), 1.0);
        return;
    }
    if (u_pores > 0.0) {
        vec3 q = v_position * 1.15;
        float c = value_noise(q);
        vec3 slope = vec3(value_noise(q + vec3(0.35, 0, 0)), value_noise(q + vec3(0, 0.35, 0)), value_noise(q + vec3(0, 0, 0.35))) - c;
        slope -= n * dot(n, slope);
        n = normalize(n - slope * 0.22 * u_pores);
    }

    // Openness from the rest surface: below 0.5 in hollows, above on ridges.
    float open = v_shade.x;
    float hollow = smoothstep(0.5, 0.0, open);
    float ridge = smoothstep(0.5, 1.0, open);
    // The first millimetres show most: a light press must be seen at a glance.
    float dent = 1.0 - exp(-3.2 * max(v_dent, 0.0));
    float ambient_open = (1.0 - 0.58 * hollow + 0.10 * ridge) * (1.0 - 0.36 * dent);
    float key_open = (1.0 - 0.20 * hollow + 0.05 * ridge) * (1.0 - 0.17 * dent);

    for (int i = 0; i < 4; i++) {
        if (i >= u_n_fingers) break;
        vec3 d = u_fingers[i].xyz - v_position;
        float r = u_fingers[i].w;
        float reach = max(length(d), r);
        float cover = clamp(dot(n, d) / reach, 0.0, 1.0) * (r * r) / (reach * reach);
        ambient_open *= 1.0 - 0.85 * cover;
        float along = dot(d, u_key);
        float miss = sqrt(max(dot(d, d) - along * along, 0.0));
        float penumbra = 0.25 * r + 0.18 * max(along, 0.0);
        key_open *= 1.0 - 0.72 * step(0.0, along) * (1.0 - smoothstep(r - penumbra, r + penumbra, miss));
    }

    // Blood shows a little more in some places than in others; hollows are warmer for the light bounced in them.
    float warm = v_shade.y - 0.5;
    float light = v_shade.z - 0.5;
    vec3 albedo = u_albedo * (1.0 + 0.16 * light) * vec3(1.0 + 0.05 * warm, 1.0 - 0.10 * warm, 1.0 - 0.12 * warm);
    vec3 ambient_tint = pow(vec3(max(ambient_open, 0.0)), vec3(0.82, 1.0, 1.08));

    vec3 sky = mix(vec3(0.25, 0.205, 0.18), vec3(0.41, 0.375, 0.355), 0.5 + 0.5 * n.y);
    vec3 diffuse = sky * ambient_tint
        + wrapped(dot(n, u_key)) * vec3(1.00, 0.955, 0.90) * 1.50 * key_open
        + wrapped(dot(n, u_fill)) * vec3(0.97, 0.96, 0.98) * 0.34 * ambient_tint;

    vec3 h = normalize(u_key + v);
    float facing = clamp(dot(n, v), 0.0, 1.0);
    float fresnel = 0.028 + 0.972 * pow(1.0 - clamp(dot(h, v), 0.0, 1.0), 5.0);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    float gloss = (0.55 * pow(nh, 14.0) + 1.1 * pow(nh, 48.0)) * fresnel * 1.6 * clamp(dot(n, u_key) * 3.0, 0.0, 1.0) * key_open;
    float edge = pow(1.0 - facing, 3.2) * smoothstep(-0.25, 0.8, dot(n, u_rim)) * ambient_open;

    vec3 color = albedo * diffuse + vec3(0.96, 0.98, 1.0) * gloss + vec3(0.60, 0.62, 0.66) * 0.40 * edge;
    color *= u_exposure;
    color = color / (1.0 + 0.16 * color);
    // Half a step of noise hides the bands of slow gradients.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    o_color = vec4(srgb(color) + grain / 255.0, 1.0);
}
