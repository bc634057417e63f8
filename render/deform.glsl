// exp(-w)(p) by the tables of the frame: see patient/breathing.h. In the cavity's coordinates (rho, phi, z) only z
// changes; the inverse tries inside, accepts if the point lies inside, else outside.
float breathRow(float z_m) { return (z_m - frame.breath.x) * frame.breath.y; }

BreathRow breathAt(float row) {
    const float r = clamp(row, 0.0, frame.breath.z - 1.0);
    const int i = min(int(r), int(frame.breath.z) - 2);
    const float f = r - float(i);
    const BreathRow a = breath_rows[i], b = breath_rows[i + 1];
    return BreathRow(mix(a.ellipse, b.ellipse, f), mix(a.z, b.z, f));
}

vec3 referenceFromDeformed(vec3 p) {
    const float row = breathRow(p.z);
    if (row <= 0.0 || row >= frame.breath.z - 1.0) return p;
    const BreathRow here = breathAt(row);
    const vec2 q = (p.xy - here.ellipse.xy) / here.ellipse.zw;
    const float rho = length(q);
    if (rho >= frame.breath.w) return p;
    float z = here.z.x;
    if (rho >= 1.0) {
        const float u = (frame.breath.w - rho) / (frame.breath.w - 1.0);
        z = mix(p.z, here.z.y, u * u * (3.0 - 2.0 * u));
    }
    const vec4 there = breathAt(breathRow(z)).ellipse;
    return vec3(there.xy + q * there.zw, z);
}
