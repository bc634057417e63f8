// Light of the operating room, in linear units: the lamp, and the ambient light of walls, floor and
// ceiling. Include after bindings.glsl.
const float kShadowBias = 0.0012;  // clip depth

// Irradiance of the room divided by pi, as a dome of two colours. The volume uses it; meshes use
// roomIrradiance().
vec3 ambientLight(float up) { return mix(kGroundColour, kSkyColour, 0.5 + 0.5 * up); }

// Rolls highlights off instead of clipping them; identity below 0.6.
vec3 softClip(vec3 c) {
    const float knee = 0.6;
    const vec3 over = max(c - knee, 0.0);
    return min(c, knee) + (1.0 - knee) * (over / (over + (1.0 - knee)));
}

// Share of the lamp's light that reaches a point in the lamp's clip space; 1 if no mesh is in the way.
// Percentage-closer filtering with two taps of 2 x 2 texels.
float lampShadowAt(vec4 clip) {
    const vec3 at = clip.xyz / clip.w;
    const vec2 uv = at.xy * 0.5 + 0.5;
    const float here = at.z + kShadowBias, s = room.settings.z;
    float lit = texture(lamp_shadow, vec4(uv + s * vec2(-0.7, -0.7), 0.0, here));
    lit += texture(lamp_shadow, vec4(uv + s * vec2(0.7, 0.7), 0.0, here));
    return 0.5 * lit;  // the beam ends before the map's edge
}

// The same for a point in the stage frame.
float lampShadow(vec3 p_stage) {
    const vec4 clip = room.shadow_from_stage * vec4(p_stage, 1.0);
    if (room.settings.x == 0.0 || clip.w <= 0.0 || any(greaterThan(abs(clip.xy), vec2(clip.w)))) return 1.0;
    return lampShadowAt(clip);
}
