// exp(-w)(p) by the tables of the frame: see deform.h. A point whose level is below zero lies inside the cavity.
vec3 referenceFromDeformed(vec3 p) {
    const vec3 at = p * frame.deform_scale.xyz + frame.deform_offset.xyz;
    const vec4 inside = textureLod(deform_inside, at, 0.0);
    if (inside.w < 0.0) return p + inside.xyz;
    return p + textureLod(deform_outside, at, 0.0).xyz;
}
