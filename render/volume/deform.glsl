// Computes exp(-w)(p) from the frame's tables: see deform.h. A point whose level is below zero lies inside
// the cavity.
vec3 referenceFromDeformed(vec3 p) {
    const vec3 at = p * frame.deform_scale.xyz + frame.deform_offset.xyz;
    const vec4 inside = textureLod(deform_inside, at, 0.0);
    if (inside.w < 0.0) return p + inside.xyz;
    return p + textureLod(deform_outside, at, 0.0).xyz;
}

// Displacement of the tissue at p by a tool (patient/displacement/tool_displacement.h). Zero outside the
// table's box.
vec3 toolMoved(vec3 p) {
    const vec3 at = p * frame.tool_scale.xyz + frame.tool_offset.xyz;
    if (any(greaterThan(abs(at - 0.5), vec3(0.5)))) return vec3(0.0);
    return textureLod(tool_moved, at, 0.0).xyz;
}

// Transforms a gradient of the undisplaced tissue to the displaced tissue: g - grad(moved . g).
vec3 turnedByTool(vec3 p, vec3 g) {
    const vec3 here = toolMoved(p);
    if (here == vec3(0.0)) return g;
    const float h = frame.tool_scale.w;
    return g - vec3(dot(toolMoved(p + vec3(h, 0, 0)) - here, g), dot(toolMoved(p + vec3(0, h, 0)) - here, g),
                    dot(toolMoved(p + vec3(0, 0, h)) - here, g)) / h;
}
