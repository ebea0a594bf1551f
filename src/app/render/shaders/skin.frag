// Skin under three soft lights. All vectors in the frame of the subject, all light linear, output sRGB.
in vec3 v_position;
in vec3 v_normal;
in float v_dent;
in vec4 v_shade;

uniform vec4 u_eye;          // eye and 1, or the direction to it and 0 in orthographic view
uniform vec3 u_key;          // directions to the lights
uniform vec3 u_fill;
uniform vec3 u_rim;
uniform vec3 u_up;           // of the picture
#ifdef TINT
in vec2 v_value;
uniform sampler2D u_table;
uniform float u_low;
uniform float u_per_width;
uniform int u_cyclic;
uniform float u_lines_per_unit;   // level lines, 0 for none
uniform float u_flat;             // light on flat skin that faces the eye
#else
uniform vec3 u_albedo;
uniform float u_exposure;
#endif
#ifdef PORES
uniform float u_pores;       // strength of the finest relief
#endif
uniform vec4 u_fingers[4];   // centre and radius of the finger spheres, mm
uniform int u_n_fingers;
#ifdef TRANSLUCENT
uniform float u_opacity;     // of skin that faces the eye
#endif

out vec4 o_color;

#ifdef PORES
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

#endif

// Light that wraps past the terminator, red farthest: what scattering under the skin does to a shadow's edge.
vec3 wrapped(float cosine) {
    const vec3 w = vec3(0.58, 0.50, 0.46);
    vec3 lit = max((vec3(cosine) + w) / (1.0 + w), 0.0);
    // Squared: it fades out without a kink.
    return lit * lit;
}

// To sRGB by square roots: within 0.002 of the standard's curve above 0.002, and much cheaper where no card helps.
vec3 srgb(vec3 c) {
    c = clamp(c, 0.0, 1.0);
    vec3 a = sqrt(c);
    vec3 b = sqrt(a);
    return max(0.662003 * a + 0.684122 * b - 0.323584 * sqrt(b) - 0.022541 * c, 0.0);
}

#ifdef TINT
vec3 linear(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

// The colour of the legend, with level lines.
vec3 tint() {
    float share;
    float at;
    if (u_cyclic == 1) {
        vec2 on_circle = v_value + vec2(dot(v_value, v_value) < 1e-12 ? 1.0 : 0.0, 0.0);
        share = fract(atan(on_circle.y, on_circle.x) / 6.2831853);
        at = share + 0.5 / 256.0;
    } else {
        share = v_value.x;
        at = (clamp(share, 0.0, 1.0) * 255.0 + 0.5) / 256.0;
    }
    vec3 color = linear(texture(u_table, vec2(at, 0.5)).rgb);
    if (u_lines_per_unit > 0.0) {
        float lines = u_lines_per_unit / max(u_per_width, 1e-30);
        float level = share * lines + u_low * u_lines_per_unit;
        // Lines per pixel; on a circle the smaller of two, so that its seam is no cliff.
        float across = fwidth(share) * lines;
        if (u_cyclic == 1) across = min(across, fwidth(fract(share + 0.5)) * lines);
        float away = abs(fract(level - 0.5) - 0.5) / max(across, 1e-9);
        // None on a plateau, where rounding alone would draw them, and none where they would run into one another.
        float drawn = smoothstep(0.0005, 0.002, across) * (1.0 - smoothstep(0.2, 0.45, across));
        float line = (1.0 - smoothstep(0.4, 1.3, away)) * drawn;
        float bright = dot(color, vec3(0.2126, 0.7152, 0.0722));
        color = mix(color, bright > 0.16 ? color * 0.35 : mix(color, vec3(1.0), 0.35), 0.8 * line);
    }
    return color;
}
#endif

void main() {
#ifdef TINT
    // First: derivatives need every pixel.
    vec3 tinted = tint();
#endif
    vec3 n = normalize(v_normal);
    vec3 v = normalize(u_eye.xyz - v_position * u_eye.w);
    if (!gl_FrontFacing) {
        // The inside of an open skin: plain, so that it is not taken for the back.
        float lit = 0.5 + 0.5 * abs(dot(n, v));
#ifdef TRANSLUCENT
        o_color = vec4(srgb(vec3(0.085, 0.078, 0.076) * lit), 0.5 * u_opacity);
#else
        o_color = vec4(srgb(vec3(0.085, 0.078, 0.076) * lit), 1.0);
#endif
        return;
    }
#ifdef PORES
    vec3 q = v_position * 1.15;
    float c = value_noise(q);
    vec3 slope = vec3(value_noise(q + vec3(0.35, 0, 0)), value_noise(q + vec3(0, 0.35, 0)), value_noise(q + vec3(0, 0, 0.35))) - c;
    slope -= n * dot(n, slope);
    n = normalize(n - slope * 0.22 * u_pores);
#endif

    // From the rest surface: below 0.5 in hollows, above on ridges.
    float hollow = max(1.0 - 2.0 * v_shade.x, 0.0);
    float ridge = max(2.0 * v_shade.x - 1.0, 0.0);
    // The first millimetres show most: a light press must be seen at a glance.
    float dent = 1.0 - 1.0 / (1.0 + 4.5 * max(v_dent, 0.0));
    float open = 1.0;
    float key_open = (1.0 - 0.30 * hollow + 0.09 * ridge) * (1.0 - 0.30 * dent);
    for (int i = 0; i < 4; i++) {
        if (i >= u_n_fingers) break;
        vec3 d = u_fingers[i].xyz - v_position;
        float r = u_fingers[i].w;
        float dd = dot(d, d);
        float per_reach = inversesqrt(max(dd, r * r));
        float cover = clamp(dot(n, d) * per_reach, 0.0, 1.0) * r * r * per_reach * per_reach;
        open *= 1.0 - 0.80 * cover;
        float along = dot(d, u_key);
        float miss = sqrt(max(dd - along * along, 0.0));
        float penumbra = 0.3 * r + 0.16 * max(along, 0.0);
        key_open *= 1.0 - 0.50 * step(0.0, along) * (1.0 - smoothstep(r - penumbra, r + penumbra, miss));
    }
    // What little light there is in a hollow has met skin before: it is a warm brown, not grey.
    vec3 around = (1.0 - vec3(0.52, 0.68, 0.72) * hollow + 0.14 * ridge) * (1.0 - vec3(0.30, 0.40, 0.44) * dent) * open;

#ifndef TINT
    // Blood shows a little more in some places than in others.
    float warm = v_shade.y - 0.5;
    float light = v_shade.z - 0.5;
    vec3 albedo = u_albedo * (1.0 + 0.04 * light) * (1.0 + vec3(0.01, -0.03, -0.03) * warm);
#endif

    vec3 sky = mix(vec3(0.230, 0.195, 0.175), vec3(0.315, 0.300, 0.290), 0.5 + 0.5 * dot(n, u_up));
    vec3 diffuse = sky * around
        + wrapped(dot(n, u_key)) * vec3(1.08, 1.03, 0.97) * key_open
        + wrapped(dot(n, u_fill)) * vec3(0.31, 0.285, 0.265) * around;

#ifdef TINT
    // White light: only how much of it there is against flat skin, darker parts deepened so that relief reads under any
    // colour, lighter ones held back so that colours keep their hue.
    float lit = dot(diffuse, vec3(1.0 / 3.0)) / u_flat;
    vec3 color = tinted;
    color *= lit < 1.0 ? pow(max(lit, 0.0), 1.8) : min(1.0 + 0.9 * (lit - 1.0), 1.4);
#else
    float nh = max(dot(n, normalize(u_key + v)), 0.0);
    nh *= nh;
    nh *= nh;
    nh *= nh;
    float gloss = 0.055 * nh * nh * max(dot(n, u_key), 0.0) * key_open;
    float grazing = 1.0 - clamp(dot(n, v), 0.0, 1.0);
    float edge = 0.11 * grazing * grazing * grazing * max(0.35 + 0.65 * dot(n, u_rim), 0.0) * open;

    vec3 color = albedo * diffuse + gloss + vec3(1.0, 0.93, 0.86) * edge;
    color *= u_exposure;
#endif
    // Half a step of noise hides the bands of slow gradients.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
#ifdef TRANSLUCENT
    // The more aslant, the longer the way through it: edges, ridges and dents stay to be seen.
    float through = clamp(dot(n, v), 0.0, 1.0);
    float veil = 1.0 - through;
    float thick = clamp(1.35 * veil * veil + 0.30 * dent + 0.22 * ridge - 0.10 * hollow, 0.0, 1.0);
    float opacity = mix(u_opacity, 0.97, thick);
#ifndef TINT
    opacity = min(opacity + 5.0 * gloss, 1.0);
#endif
    o_color = vec4(srgb(color) + grain / 255.0, opacity);
#else
    o_color = vec4(srgb(color) + grain / 255.0, 1.0);
#endif
}
