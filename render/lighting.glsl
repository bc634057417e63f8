// Light of the operating room in linear units: a key lamp, a cool dome above, a warm bounce below.
const vec3 kKeyColour = vec3(1.0, 0.965, 0.91);
const vec3 kSkyColour = vec3(0.36, 0.44, 0.47);
const vec3 kGroundColour = vec3(0.11, 0.12, 0.12);

vec3 ambientLight(float up) { return mix(kGroundColour, kSkyColour, 0.5 + 0.5 * up); }

// Rolls highlights off instead of clipping them; identity below 0.6.
vec3 softClip(vec3 c) {
    const float knee = 0.6;
    const vec3 over = max(c - knee, 0.0);
    return min(c, knee) + (1.0 - knee) * (over / (over + (1.0 - knee)));
}
