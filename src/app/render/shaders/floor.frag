// A quiet gradient, a little lighter behind the subject.
in vec2 v_uv;

uniform vec3 u_top;
uniform vec3 u_bottom;
uniform float u_glow;

out vec4 o_color;

void main() {
    vec3 color = mix(u_bottom, u_top, smoothstep(0.0, 1.0, v_uv.y));
    float away = length((v_uv - vec2(0.5, 0.56)) * vec2(1.1, 1.0));
    color += u_glow * (1.0 - smoothstep(0.0, 0.75, away));
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    o_color = vec4(color + grain / 255.0, 1.0);
}
